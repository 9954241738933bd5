// SPDX-License-Identifier: MIT
#include "metrics.h"

#include <algorithm>
#include <cmath>

namespace nf
{

const std::vector<MetricField> &metric_fields()
{
    static const std::vector<MetricField> fields = {
        {"speed_error_max_rpm", &MetricValues::speed_error_max_rpm},
        {"speed_error_rms_rpm", &MetricValues::speed_error_rms_rpm},
        {"speed_error_max_pct", &MetricValues::speed_error_max_pct},
        {"command_error_settled_pct", &MetricValues::command_error_settled_pct},
        {"angle_error_max_deg", &MetricValues::angle_error_max_deg},
        {"iq_error_max_a", &MetricValues::iq_error_max_a},
        {"settling_time_s", &MetricValues::settling_time_s},
        {"overshoot_pct", &MetricValues::overshoot_pct},
        {"speed_dip_rpm", &MetricValues::speed_dip_rpm},
        {"recovery_time_s", &MetricValues::recovery_time_s},
        {"position_error_final_rad", &MetricValues::position_error_final_rad},
        {"id_settled_a", &MetricValues::id_settled_a},
        {"angle_error_rms_deg", &MetricValues::angle_error_rms_deg},
        {"speed_error_command_pct", &MetricValues::speed_error_command_pct},
        {"speed_error_load_pct", &MetricValues::speed_error_load_pct},
        {"torque_error_settled_pct", &MetricValues::torque_error_settled_pct},
        {"ripple_speed_pct", &MetricValues::ripple_speed_pct},
        {"ripple_current_pct", &MetricValues::ripple_current_pct},
        {"swing_speed_pct", &MetricValues::swing_speed_pct},
        {"swing_current_pct", &MetricValues::swing_current_pct},
        {"swing_hz", &MetricValues::swing_hz},
        {"lost_time_s", &MetricValues::lost_time_s},
    };
    return fields;
}

const std::vector<FlagField> &flag_fields()
{
    static const std::vector<FlagField> fields = {
        {"locked", &MetricValues::locked},
        {"locked_coarse", &MetricValues::locked_coarse},
        {"limit_cycle", &MetricValues::limit_cycle},
        {"reached", &MetricValues::reached},
    };
    return fields;
}

void Metrics::Worst::add(double x)
{
    value = std::max(value, x);
    seen = true;
}

std::optional<double> Metrics::Worst::get() const
{
    return seen && !spoiled ? std::optional<double>(value) : std::nullopt;
}

Metrics::Metrics(DriveMode mode, double period_s, double rated_speed_rpm, double rated_current_a,
                 double rated_torque_nm)
    : mode_(mode), period_s_(period_s), rated_rpm_(rated_speed_rpm), rated_a_(rated_current_a),
      rated_nm_(rated_torque_nm), settled_ticks_(std::llround(SETTLED_AFTER_S / period_s)),
      mean_gain_(1.0 - std::exp(-period_s / LOST_MEAN_S)),
      speed_swing_(2 * SWING_SPEED * rated_speed_rpm, period_s),
      current_swing_(2 * SWING_CURRENT * rated_current_a, period_s)
{
}

void Metrics::command_step(double command)
{
    close_step_window();
    close_approach();
    if (mode_ == DriveMode::position && ticks_ > 0) {
        position_error_.add(std::abs(command_ - last_actual_));
    }
    step_height_ = std::abs(command - command_);
    step_sign_ = command > command_ ? 1.0 : -1.0;
    excess_ = 0;
    settling_ = {true, SETTLING_BAND * step_height_, ticks_, ticks_};
    command_ = command;
    approach_ = {step_height_, {}};
    after_ = After::command;
}

void Metrics::load_step()
{
    close_step_window();
    const bool with_command = settling_.active && settling_.since == ticks_;
    if (mode_ == DriveMode::speed && !with_command) {
        dip_ = 0;
        recovery_ = {true, RECOVERY_BAND * rated_rpm_, ticks_, ticks_};
    }
    after_ = After::load;
}

void Metrics::disturbed()
{
    close_swings();
}

void Metrics::add(const Instant &now)
{
    const double speed_error = now.speed_rpm - now.speed_estimated_rpm;
    speed_error_max_ = std::max(speed_error_max_, std::abs(speed_error));
    speed_error_squares_ += speed_error * speed_error;
    angle_error_max_ = std::max(angle_error_max_, std::abs(now.angle_error_deg));
    angle_error_squares_ += now.angle_error_deg * now.angle_error_deg;
    iq_error_max_ = std::max(iq_error_max_, std::abs(now.iq_error_a));
    if (after_ != After::nothing) {
        (after_ == After::load ? error_load_ : error_command_).add(std::abs(speed_error));
    }
    if (now.reference_moving) {
        close_settled_window();
    }
    quiet_ticks_++;
    average(now);
    locked_coarse_ = locked_coarse_ && is_held_coarsely(now);
    if (!lost_time_s_ && !(locked_coarse_ && is_held())) {
        lost_time_s_ = now.time_s;
    }
    ticks_++;
    watch_steps(now.actual - command_);
    last_actual_ = now.actual;
    const double nearest = approach_.nearest.value_or(now.actual);
    const bool nearer = std::abs(now.actual - command_) < std::abs(nearest - command_);
    approach_.nearest = nearer ? now.actual : nearest;
    watch_window(now);
}

void Metrics::watch_steps(double beyond)
{
    if (settling_.active) {
        excess_ = std::max(excess_, beyond * step_sign_);
        settling_.outside = std::abs(beyond) > settling_.band ? ticks_ : settling_.outside;
    }
    if (recovery_.active) {
        dip_ = std::max(dip_, std::abs(beyond));
        recovery_.outside = std::abs(beyond) > recovery_.band ? ticks_ : recovery_.outside;
    }
}

void Metrics::watch_window(const Instant &now)
{
    ripple_.add(now.angle_el_rad, {now.speed_rpm, now.i_q_a}, now.supply_rad);
    if (quiet_ticks_ > settled_ticks_) {
        add_settled(now);
    }
}

// What `locked` is judged by.
void Metrics::average(const Instant &now)
{
    const double speed_error = now.speed_rpm - now.speed_estimated_rpm;
    speed_mean_.add(speed_error / rated_rpm_, mean_gain_);
    if (quiet_ticks_ > settled_ticks_) {
        settled_mean_.add(speed_error, mean_gain_);
    }
    if (now.closed_loop) {
        angle_mean_.add(now.angle_error_deg, mean_gain_);
    } else {
        angle_mean_ = {};
    }
}

bool Metrics::is_held_coarsely(const Instant &now) const
{
    return now.running && std::abs(now.angle_error_deg) < LOST_DEG &&
           speed_mean_.value < LOST_SPEED * LOST_SPEED;
}

// What `locked` asks for beyond that. A standstill has no share of the command.
bool Metrics::is_held() const
{
    const bool has_command = mode_ == DriveMode::speed && std::abs(command_) > 0;
    const double limit = LOST_COMMAND * command_;
    const bool has_speed = !has_command || settled_mean_.value < limit * limit;
    return has_speed && angle_mean_.value < LOST_RMS_DEG * LOST_RMS_DEG;
}

void Metrics::add_settled(const Instant &now)
{
    if (window_ticks_ == 0) {
        const double base = std::abs(command_);
        command_scale_ = 100.0 / (base > 0 ? base : rated_rpm_);
    }
    window_ticks_++;
    window_id_sum_ += now.i_d_a;
    window_actual_sum_ += now.actual;
    if (mode_ == DriveMode::speed) {
        command_error_settled_.add(std::abs(command_ - now.actual) * command_scale_);
    }
}

// A window that ends outside the band never settled.
void Metrics::close_wait(Wait &wait, Worst &into) const
{
    if (wait.outside < ticks_) {
        into.add(static_cast<double>(wait.outside - wait.since) * period_s_);
    } else {
        into.spoiled = true;
    }
    wait.active = false;
}

void Metrics::close_torque_window()
{
    const double base = command_ == 0 ? rated_nm_ : std::abs(command_);
    if (mode_ == DriveMode::torque && base > 0 && window_ticks_ >= settled_ticks_) {
        const double mean = window_actual_sum_ / static_cast<double>(window_ticks_);
        torque_error_settled_.add(std::abs(mean - command_) / base * 100.0);
    }
}

void Metrics::close_settled_window()
{
    if (window_ticks_ > 0) {
        id_settled_.add(std::abs(window_id_sum_ / static_cast<double>(window_ticks_)));
        close_torque_window();
    }
    window_ticks_ = 0;
    window_id_sum_ = 0;
    window_actual_sum_ = 0;
    quiet_ticks_ = 0;
    settled_mean_ = {};
    close_swings();
}

void Metrics::close_swings()
{
    const auto [speed, current] = ripple_.split(static_cast<std::size_t>(settled_ticks_));
    const auto watch = [](const Ripple::Split &split, Worst &amplitude, SwingFinder &finder) {
        for (std::size_t k = 0; k < split.rest.size(); k++) {
            finder.add(split.rest[k], split.signal[k]);
        }
        if (split.amplitude) {
            amplitude.add(*split.amplitude);
        }
        finder.restart();
    };
    watch(speed, ripple_speed_, speed_swing_);
    watch(current, ripple_current_, current_swing_);
    ripple_.clear();
}

// Steps of command and load in one tick leave a window of no ticks between them; it says nothing.
void Metrics::close_step_window()
{
    close_settled_window();
    if (settling_.active && settling_.since < ticks_) {
        overshoot_.add(excess_ / step_height_ * 100.0);
        close_wait(settling_, settling_time_);
    }
    if (recovery_.active && recovery_.since < ticks_) {
        dips_.add(dip_);
        close_wait(recovery_, recovery_time_);
    }
}

// A torque has a slope and limits of its own: torque_error_settled_pct judges it.
void Metrics::close_approach()
{
    const bool asks = approach_.height > 0 && approach_.nearest;
    if (mode_ == DriveMode::torque || missed_ || !asks) {
        return;
    }
    if (std::abs(*approach_.nearest - command_) > REACHED_BAND * approach_.height) {
        missed_ = MetricValues::Missed{command_, *approach_.nearest};
    }
}

std::optional<double> Metrics::of_rated(const Worst &worst, double rated)
{
    const std::optional<double> value = worst.get();
    return value ? std::optional<double>(*value / rated * 100.0) : std::nullopt;
}

void Metrics::finish_errors(MetricValues &m) const
{
    const auto count = static_cast<double>(ticks_);
    m.speed_error_max_rpm = speed_error_max_;
    m.speed_error_rms_rpm = std::sqrt(speed_error_squares_ / count);
    m.speed_error_max_pct = speed_error_max_ / rated_rpm_ * 100.0;
    m.speed_error_command_pct = of_rated(error_command_, rated_rpm_);
    m.speed_error_load_pct = of_rated(error_load_, rated_rpm_);
    m.angle_error_max_deg = angle_error_max_;
    m.angle_error_rms_deg = std::sqrt(angle_error_squares_ / count);
    m.iq_error_max_a = iq_error_max_;
    m.lost_time_s = lost_time_s_;
}

void Metrics::finish_swings(MetricValues &m) const
{
    const std::optional<Swing> &speed = speed_swing_.largest();
    const std::optional<Swing> &current = current_swing_.largest();
    m.limit_cycle = speed || current;
    m.ripple_speed_pct = of_rated(ripple_speed_, rated_rpm_);
    m.ripple_current_pct = of_rated(ripple_current_, rated_a_);
    if (speed) {
        m.swing_speed_pct = speed->amplitude / rated_rpm_ * 100.0;
        m.swing_hz = speed->hz;
    }
    if (current) {
        m.swing_current_pct = current->amplitude / rated_a_ * 100.0;
        m.swing_hz = current->hz;
    }
}

MetricValues Metrics::finish()
{
    close_step_window();
    close_approach();
    MetricValues m;
    m.reached = !missed_ && ticks_ > 0;
    m.missed = missed_;
    m.locked_coarse = locked_coarse_ && ticks_ > 0;
    m.locked = !lost_time_s_ && ticks_ > 0;
    if (ticks_ == 0) {
        return m;
    }
    if (mode_ == DriveMode::position) {
        position_error_.add(std::abs(command_ - last_actual_));
    }
    finish_errors(m);
    finish_swings(m);
    m.command_error_settled_pct = command_error_settled_.get();
    m.torque_error_settled_pct = torque_error_settled_.get();
    m.settling_time_s = settling_time_.get();
    m.overshoot_pct = overshoot_.get();
    m.speed_dip_rpm = dips_.get();
    m.recovery_time_s = recovery_time_.get();
    m.position_error_final_rad = position_error_.get();
    m.id_settled_a = id_settled_.get();
    return m;
}

} // namespace nf
