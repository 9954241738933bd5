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

Metrics::Metrics(DriveMode mode, double period_s, double rated_speed_rpm)
    : mode_(mode), period_s_(period_s), rated_rpm_(rated_speed_rpm),
      settled_ticks_(std::llround(SETTLED_AFTER_S / period_s)),
      speed_filter_gain_(1.0 - std::exp(-period_s / LOST_SPEED_S))
{
}

void Metrics::command_step(double command)
{
    close_step_window();
    if (mode_ == DriveMode::position && ticks_ > 0) {
        position_error_.add(std::abs(command_ - last_actual_));
    }
    step_height_ = std::abs(command - command_);
    step_sign_ = command > command_ ? 1.0 : -1.0;
    excess_ = 0;
    settling_ = {true, SETTLING_BAND * step_height_, ticks_, ticks_};
    command_ = command;
}

void Metrics::load_step()
{
    close_step_window();
    const bool with_command = settling_.active && settling_.since == ticks_;
    if (mode_ == DriveMode::speed && !with_command) {
        dip_ = 0;
        recovery_ = {true, RECOVERY_BAND * rated_rpm_, ticks_, ticks_};
    }
}

void Metrics::add(const Instant &now)
{
    const double speed_error = now.speed_rpm - now.speed_estimated_rpm;
    speed_error_max_ = std::max(speed_error_max_, std::abs(speed_error));
    speed_error_squares_ += speed_error * speed_error;
    angle_error_max_ = std::max(angle_error_max_, std::abs(now.angle_error_deg));
    iq_error_max_ = std::max(iq_error_max_, std::abs(now.iq_error_a));
    watch_lock(now);

    const double beyond = now.actual - command_;
    ticks_++;
    if (settling_.active) {
        excess_ = std::max(excess_, beyond * step_sign_);
        settling_.outside = std::abs(beyond) > settling_.band ? ticks_ : settling_.outside;
    }
    if (recovery_.active) {
        dip_ = std::max(dip_, std::abs(beyond));
        recovery_.outside = std::abs(beyond) > recovery_.band ? ticks_ : recovery_.outside;
    }
    last_actual_ = now.actual;
    if (now.reference_moving) {
        close_settled_window();
    }
    quiet_ticks_++;
    if (quiet_ticks_ > settled_ticks_) {
        add_settled(now);
    }
}

void Metrics::watch_lock(const Instant &now)
{
    const double speed_error = (now.speed_rpm - now.speed_estimated_rpm) / rated_rpm_;
    speed_error_mean_square_ +=
        (speed_error * speed_error - speed_error_mean_square_) * speed_filter_gain_;
    locked_ = locked_ && now.running && std::abs(now.angle_error_deg) < LOST_DEG &&
              speed_error_mean_square_ < LOST_SPEED * LOST_SPEED;
}

void Metrics::add_settled(const Instant &now)
{
    if (window_ticks_ == 0) {
        const double base = std::abs(command_);
        command_scale_ = 100.0 / (base > 0 ? base : rated_rpm_);
    }
    window_ticks_++;
    window_id_sum_ += now.i_d_a;
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

void Metrics::close_settled_window()
{
    if (window_ticks_ > 0) {
        id_settled_.add(std::abs(window_id_sum_ / static_cast<double>(window_ticks_)));
    }
    window_ticks_ = 0;
    window_id_sum_ = 0;
    quiet_ticks_ = 0;
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

MetricValues Metrics::finish()
{
    close_step_window();
    MetricValues m;
    m.locked = locked_ && ticks_ > 0;
    if (ticks_ == 0) {
        return m;
    }
    if (mode_ == DriveMode::position) {
        position_error_.add(std::abs(command_ - last_actual_));
    }
    m.speed_error_max_rpm = speed_error_max_;
    m.speed_error_rms_rpm = std::sqrt(speed_error_squares_ / static_cast<double>(ticks_));
    m.speed_error_max_pct = speed_error_max_ / rated_rpm_ * 100.0;
    m.command_error_settled_pct = command_error_settled_.get();
    m.angle_error_max_deg = angle_error_max_;
    m.iq_error_max_a = iq_error_max_;
    m.settling_time_s = settling_time_.get();
    m.overshoot_pct = overshoot_.get();
    m.speed_dip_rpm = dips_.get();
    m.recovery_time_s = recovery_time_.get();
    m.position_error_final_rad = position_error_.get();
    m.id_settled_a = id_settled_.get();
    return m;
}

} // namespace nf
