// SPDX-License-Identifier: MIT
#include "diff.h"

#include "observer_roundings.h"
#include "signals.h"
#include "twin_modulator.h"
#include "twin_rotor_position.h"

extern "C" {
#include "align.h"
#include "low_speed.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

using twin::CurrentLoop;
using twin::NnObserver;
using twin::PerUnit;
using twin::Q13;
using twin::Q14;
using twin::Q15;
using twin::Q27;
using twin::STEPS_PER_TURN;
using twin::TWO_PI;
using twin::Vector;

// Roundings of one tick in LSB, as the modules' headers state them.
constexpr double CLARKE_LSB = 1.0;
constexpr double PARK_LSB = 2.0;
// The mean of two bus voltages, rounded down, times a ratio below 1; the product rounded down.
constexpr double APPLIED_LSB = 1.5;
// PI: two parts. Decoupling: reactance and its product. EMF, resistance: one each. The integral: 1/2048.
constexpr double INTEGRAL_LSB = 1.0 / 2048.0;
constexpr double CURRENT_LOOP_LSB = 6.0 + INTEGRAL_LSB;
constexpr double ROOT_LSB = 1.0; // of the circle
constexpr double LIMIT_LSB = 1.0;
constexpr double SPEED_LOOP_LSB = 3.0; // proportional part, integral and feed-forward
// Two components, each rounded down, turned.
constexpr double RATIO_LSB = 1.4143;
// The middle of a range that is not symmetric is rounded down.
constexpr double MIDDLE_LSB = 0.5;
// A voltage of magnitude U: the product rounded down.
constexpr double VOLTAGE_LSB = 1.0;
// α_r is good to 2^-17 turn; g·α_r is rounded down to 2^-32 turn by two shifts, the twin's radians to less.
constexpr double CURRENT_ANGLE_STEPS = 32768.0;
constexpr double FIRING_ANGLE_STEPS = 1.1;
constexpr double MEAN_SHARE = 1.0 / 32.0; // of the current's mean in a tick
// β·√3/2 1.1, α/2 0.5, half the sum 1.05.
constexpr double DUTY_LSB = 2.65;
constexpr double PHASE_LSB = 1.6;      // of a ratio or a current
constexpr double LACKING = 1.0 / 4.0;  // of what the current lacks of its reference
constexpr double LACKING_LSB = 1.0;    // rounded down
constexpr int32_t CURRENT_MAX = 16383; // its currents at the converters' full scale
constexpr int32_t ERROR_MAX = 8191;    // the observer's errors saturate at a quarter

constexpr const char *NEVER_COMPARED =
    "never compared: changes of state, protection and supervision, derating, how a turning rotor is caught, the\n"
    "alignment and the size of an imposed current, the corrections of the model\n";

constexpr double Q26 = 67108864.0;
constexpr double Q12 = 4096.0;
constexpr int32_t LARGEST_MANTISSA = 32767;

double radians(int64_t turns_q32)
{
    return static_cast<uint32_t>(static_cast<uint64_t>(turns_q32)) / STEPS_PER_TURN * TWO_PI;
}

// What is left between two positions within a turn: −2^31 … 2^31 − 1.
int32_t apart(int64_t from_q32, int64_t to_q32)
{
    return static_cast<int32_t>(
        static_cast<uint32_t>(static_cast<uint64_t>(to_q32) - static_cast<uint64_t>(from_q32)));
}

// As drive_is_controlled(), whose header is C only.
bool is_controlled(drive_state_t state)
{
    return state > DRIVE_STATE_CATCH_SPIN && state < DRIVE_STATE_FAULT;
}

// One tick and the rows that have come of it.
class TickDiff
{
public:
    TickDiff(const drive_t &before, const Tick &tick, const drive_cfg_t &built)
        : before_(before), after_(tick.sim->drive()), in_(tick.sim->in()), out_(tick.sim->out()),
          built_(built), si_{tick.sim->bases(), tick.sim->cfg()},
          running_(after_.state == DRIVE_STATE_RUN),
          track_(before.state == DRIVE_STATE_RUN || low_speed_tracks(&before)),
          sensed_(built.sampling.sensor_pole_pairs != 0)
    {
        found_ = before.observer;
        position_q32_ = before.position.turns_q32;
        if (sensed_) {
            follow_sensor();
        }
        // The model is corrected after the observer's part of a tick, and before the loops'.
        si_.cfg.observer = before_.model.observer;
        si_.cfg.current_loop = running_ ? after_.model.run_loop : after_.model.hold_loop;
    }

    Diff all();

private:
    void configuration();
    void model();
    void model_word(const char *name, int32_t drive, double reference, double tolerance);
    void sampling();
    void transforms();
    void applied_voltage();
    void follow_sensor();
    void angle_sensor();
    void observer();
    void network(const NnObserver &twin, const Vector &tolerance);
    void turned_error();
    void training();
    void follow();
    void plan();
    void position_plan();
    int64_t measured_position() const;
    void speed_loop();
    void imposed_speed();
    void magnitude();
    void current_loop();
    void voltage_limit();
    void phase_compensator();
    void voltage_drive(double lead);
    void loops();
    void rest();
    void reciprocal();
    void modulation();
    int64_t modulated_frame() const;
    void duties(double angle);
    Vector expected_current() const;
    void position();

    NnObserver twin_before(const Vector &state) const;
    Vector network_state(const nn_observer_t &obs, double angle) const;
    double angle_now() const
    {
        return radians(position_q32_);
    }
    bool drags() const
    {
        return is_controlled(before_.state) && !running_ && before_.state != DRIVE_STATE_ALIGN;
    }
    // The frame in which a current is controlled changes in this tick, or its loop starts.
    bool begins_anew() const
    {
        const bool changed = before_.state != after_.state;
        return changed &&
               (before_.state == DRIVE_STATE_RUN || running_ || before_.state == DRIVE_STATE_ALIGN);
    }
    // The slow period's part that falls on this tick: as many ticks are left of it.
    bool has_slow_part(uint32_t left) const
    {
        return before_.slow_count == left + 1U && before_.state == after_.state;
    }
    void leave_out(const char *what)
    {
        diff_.left_out += (diff_.left_out.empty() ? "" : "; ") + std::string(what);
    }

    void add(const char *quantity, const char *unit, double drive, double reference,
             double tolerance)
    {
        diff_.rows.push_back({module_, quantity, unit, drive, reference, tolerance});
    }
    void add(const char *axis_1, const char *axis_2, const char *unit, const Vector &drive,
             const Vector &reference, const Vector &tolerance)
    {
        add(axis_1, unit, drive.x(), reference.x(), tolerance.x());
        add(axis_2, unit, drive.y(), reference.y(), tolerance.y());
    }
    Vector current(const ab_t &i) const
    {
        return {si_.current(i.alpha), si_.current(i.beta)};
    }
    Vector current(const dq_t &i) const
    {
        return si_.current(i);
    }
    // As a current saturates in the drive.
    Vector limited(const Vector &i, int32_t highest_q15) const
    {
        return i.cwiseMax(si_.current(-highest_q15 - 1)).cwiseMin(si_.current(highest_q15));
    }
    Vector park_tolerance(const Vector &v, double lsb) const
    {
        return Vector::Constant(PARK_LSB * lsb + twin::turn_error(v));
    }

    const drive_t &before_;
    const drive_t &after_;
    const drive_in_t &in_;
    const drive_out_t &out_;
    const drive_cfg_t &built_;
    PerUnit si_;
    bool running_;
    bool track_;
    bool sensed_;
    nn_observer_t found_{};    // the observer as its network finds it
    int64_t position_q32_ = 0; // and θ̂
    const char *module_ = "";
    Diff diff_;
};

// The word of the table that a byte belongs to, or the byte.
std::string place_text(std::size_t byte)
{
    for (const SignalInfo &signal : all_signals()) {
        const Word &word = signal.word;
        if (signal.value == nullptr && word.home == Word::Home::cfg && byte >= word.offset &&
            byte < word.offset + word.bytes) {
            return signal.name;
        }
    }
    return fmt::format("cfg, word at byte {}", byte / 4 * 4);
}

void TickDiff::configuration()
{
    module_ = "configuration";
    const auto *const own = reinterpret_cast<const unsigned char *>(before_.cfg);
    const auto *const good = reinterpret_cast<const unsigned char *>(&built_);
    const auto [at, other] = std::mismatch(own, own + sizeof built_, good);
    if (at == own + sizeof built_) {
        add("words as built", "", 1, 1, 0);
        return;
    }
    const auto byte = static_cast<std::size_t>(at - own);
    int32_t drive = 0;
    int32_t reference = 0;
    std::memcpy(&drive, own + byte / 4 * 4, sizeof drive);
    std::memcpy(&reference, good + byte / 4 * 4, sizeof reference);
    add(place_text(byte).c_str(), "", drive, reference, 0);
}

void TickDiff::model_word(const char *name, int32_t drive, double reference, double tolerance)
{
    add(name, "", drive, reference, tolerance);
}

// Configured values times what the drive has found out of R, L and φ; each ratio that is applied rounds down, and the
// ratio after it, below 2, doubles that: 1 for one, 3 for two.
void TickDiff::model()
{
    module_ = "model";
    const model_t &m = after_.model;
    const nn_observer_cfg_t &from = built_.observer;
    const double r = m.resistance_q14 / Q14;
    const double l = m.inductance_q14 / Q14;
    const double inverse = m.inductance_inverse_q14 / Q14;
    const double flux = std::floor(m.flux_q30 / 65536.0) / Q14;
    const auto mantissa = [](double value) { return std::min<double>(value, LARGEST_MANTISSA); };
    model_word("observer.decay", m.observer.decay, mantissa(from.decay * r * inverse), 3);
    model_word("observer.volt_gain", m.observer.volt_gain, mantissa(from.volt_gain * inverse), 1);
    model_word("observer.flux_q27", m.observer.flux_q27,
               std::min(from.flux_q27 * flux * inverse, Q27 - 1), 3);
    model_word("observer.rate", m.observer.rate, mantissa(from.rate * l * l), 3);
    model_word("observer.proportional", m.observer.proportional,
               mantissa(from.proportional * l * l), 3);
    model_word("observer.corner", m.observer.corner, std::min(from.corner * r * inverse, Q27), 3);
    model_word("run_loop.resistance_q13", m.run_loop.resistance_q13,
               mantissa(built_.current_loop.resistance_q13 * r), 1);
    model_word("run_loop.emf_q13", m.run_loop.emf_q13, mantissa(built_.current_loop.emf_q13 * flux),
               1);
    const std::array<std::pair<const pi_cfg_t *, const pi_cfg_t *>, 4> gains = {{
        {&m.run_loop.pi_d, &built_.current_loop.pi_d},
        {&m.run_loop.pi_q, &built_.current_loop.pi_q},
        {&m.hold_loop.pi_d, &built_.hold_loop.pi_d},
        {&m.hold_loop.pi_q, &built_.hold_loop.pi_q},
    }};
    const std::array<const char *, 4> names = {"run_loop.pi_d", "run_loop.pi_q", "hold_loop.pi_d",
                                               "hold_loop.pi_q"};
    for (std::size_t k = 0; k < gains.size(); k++) {
        model_word(fmt::format("{}.kp", names[k]).c_str(), gains[k].first->kp, gains[k].second->kp,
                   0);
        model_word(fmt::format("{}.ki", names[k]).c_str(), gains[k].first->ki, gains[k].second->ki,
                   0);
    }
}

// Integers that nothing rounds.
void TickDiff::sampling()
{
    module_ = "sampling";
    const auto phase = [&](uint16_t count, int32_t offset) {
        const double q15 = std::ldexp(count, static_cast<int>(si_.cfg.sampling.current_shift));
        return si_.current(std::clamp(q15 - offset, -16384.0, 16383.0));
    };
    const double bus = std::ldexp(in_.adc_bus, static_cast<int>(si_.cfg.sampling.bus_shift));
    const double none = si_.current(1) / 2; // below one LSB
    add("i_a", "A", si_.current(after_.signals.phase_a), phase(in_.adc_ia, before_.offset_a), none);
    add("i_b", "A", si_.current(after_.signals.phase_b), phase(in_.adc_ib, before_.offset_b), none);
    add("bus", "V", si_.voltage(after_.signals.bus), si_.voltage(std::min(bus, Q15 - 1)),
        si_.voltage(1) / 2);
}

void TickDiff::transforms()
{
    const drive_signals_t &s = after_.signals;
    const double lsb = si_.current(1);
    const Vector stationary = current(s.current_ab);
    module_ = "Clarke";
    add("i_alpha", "i_beta", "A", stationary,
        twin::clarke(si_.current(s.phase_a), si_.current(s.phase_b)),
        Vector::Constant(CLARKE_LSB * lsb));
    module_ = "Park";
    add("i_d", "i_q", "A", current(s.current), twin::park(stationary, angle_now()),
        park_tolerance(stationary, lsb));
    if (before_.state != DRIVE_STATE_RUN) {
        add("i_d, frame", "i_q, frame", "A", current(s.current_frame),
            twin::park(stationary, radians(before_.frame.turns_q32)),
            park_tolerance(stationary, lsb));
    }
}

void TickDiff::applied_voltage()
{
    module_ = "applied voltage";
    const double bus = si_.voltage(before_.bus_before + after_.signals.bus) / 2;
    const Vector ratio(before_.ratio_acting.alpha / Q15, before_.ratio_acting.beta / Q15);
    add("v_alpha", "v_beta", "V", si_.voltage(after_.signals.voltage_applied), ratio * bus,
        Vector::Constant(APPLIED_LSB * si_.voltage(1)));
}

// A loop of second order pulls speed and angle to the sensor before the network sees them; in RUN the tick before has
// turned the angle on.
void TickDiff::follow_sensor()
{
    constexpr double ANGLE_SHARE = 1.0 / 8.0;
    constexpr double SPEED_SHARE = 1.0 / 256.0;
    constexpr uint32_t COUNT_TO_ANGLE = 65536;
    const bool turned = before_.state == DRIVE_STATE_RUN;
    const int64_t expected = position_q32_ + (turned ? 0 : before_.observer.speed);
    const uint32_t measured = in_.angle * COUNT_TO_ANGLE * built_.sampling.sensor_pole_pairs;
    const int32_t error = apart(expected, measured);
    const double limit = before_.model.observer.speed_limit;
    found_.speed = static_cast<step_t>(
        std::clamp(before_.observer.speed + std::floor(error * SPEED_SHARE), -limit, limit));
    found_.speed_out = found_.speed;
    found_.weight_step = 0;
    position_q32_ = expected + static_cast<int64_t>(std::floor(error * ANGLE_SHARE));
}

// Integers that nothing rounds.
void TickDiff::angle_sensor()
{
    if (!sensed_) {
        return;
    }
    module_ = "angle sensor";
    const double rpm = si_.bases.rpm_from_step(1);
    add("speed", "rpm", after_.frame_speed * rpm, found_.speed * rpm, rpm / 2);
}

// x̂, ŷ in A, in the frame at an angle.
Vector TickDiff::network_state(const nn_observer_t &obs, double angle) const
{
    const double one = si_.state_base() / Q27;
    return twin::park(Vector(obs.alpha_q27, obs.beta_q27) * one, angle);
}

NnObserver TickDiff::twin_before(const Vector &state) const
{
    const nn_observer_t &obs = found_;
    NnObserver twin(twin::observer_params(si_));
    twin.set(state, si_.speed_of_step(obs.speed), si_.speed_of_step(obs.speed_out),
             si_.speed_of_step(obs.weight_step) * si_.bases.control_period_s);
    twin.set_rho(obs.rho_q13 / Q13);
    return twin;
}

void TickDiff::observer()
{
    const nn_observer_t &obs = found_;
    const double advance = obs.speed_out / STEPS_PER_TURN * TWO_PI;
    const Vector state = network_state(obs, angle_now() - advance);
    NnObserver twin = twin_before(state);
    const double speed = twin.speed_out();
    // The resistance takes its drop from the current as it was stored: rounded, and a little turned where θ̂ was pulled.
    const double restored = (twin.current() - current(obs.current)).cwiseAbs().sum();
    const Vector network = twin::network_roundings(si_, twin, speed, state).array() +
                           twin::half_turn_error(si_, twin, speed, state) +
                           twin.decay().diagonal().maxCoeff() * restored;

    twin.step(current(after_.signals.current),
              twin::park(si_.voltage(after_.signals.voltage_applied), angle_now() - advance / 2));
    this->network(twin, network);
    turned_error();
    if (track_) {
        training();
    } else {
        follow();
    }
}

void TickDiff::network(const NnObserver &twin, const Vector &tolerance)
{
    module_ = "observer network";
    const nn_observer_t &obs = after_.observer;
    const Vector output = tolerance + twin::output_roundings(si_, twin.state());
    add("x", "y", "A", network_state(obs, angle_now()), twin.state(), tolerance);
    add("i_d", "i_q", "A", current(obs.current), limited(twin.current(), CURRENT_MAX), output);
    add("e_d", "e_q", "A", current(obs.error), limited(twin.error(), ERROR_MAX), output);
}

// e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q): each product rounded down, that of e_q turned again.
void TickDiff::turned_error()
{
    const nn_observer_t &obs = after_.observer;
    const double rho = before_.observer.rho_q13 / Q13;
    const Vector e = current(obs.error);
    const double error_q = si_.cfg.observer.saliency_q13 / Q13 * e.y();
    const Vector turned(e.x() + rho * error_q, error_q - rho * e.x());
    add("e'_d", "e'_q", "A", current(obs.turned), limited(turned, ERROR_MAX),
        Vector(2.0 + std::abs(rho), 2.0) * si_.current(1));
}

// Paper A (18)–(22). The drive's speed has a limit, its descent 16 bits.
void TickDiff::training()
{
    module_ = "observer training";
    const nn_observer_t &obs = after_.observer;
    const NnObserver::Params p = twin::observer_params(si_);
    const Vector state = current(before_.observer.state) * (si_.state_base() / si_.current(Q15));
    const Vector turned = current(obs.turned);
    const int bits = 30 - static_cast<int>(si_.cfg.observer.descent_shift);
    const double one = std::ldexp(si_.bases.current_a * si_.state_base(), -bits);
    const double descent = std::clamp(turned.y() * state.x() - turned.x() * state.y(),
                                      -(LARGEST_MANTISSA + 1) * one, LARGEST_MANTISSA * one);
    add("descent", "A2", obs.descent * one, descent, one);

    NnObserver twin = twin_before(state);
    twin.train(descent);
    const double rpm = si_.bases.rpm_from_step(1);
    const double rpm_per_rad_s = rpm / si_.speed_of_step(1);
    const double limit = si_.speed_of_step(si_.cfg.observer.speed_limit);
    const double integral = std::clamp(twin.speed(), -limit, limit);
    const double path = twin.speed_out() - twin.speed();
    // ΔW2 rounded down to a step, its momentum to two; ω̂_out to another.
    const double step = (p.alpha > 0 ? 3.0 : 1.0) * si_.speed_of_step(1);
    const double speed = step + p.eta / p.period_s * one;
    const double flux_2 = twin.flux_current() * twin.flux_current();
    const double out = speed + si_.speed_of_step(1) + p.kappa_p / p.period_s / flux_2 * one;
    add("speed", "rpm", obs.speed * rpm, integral * rpm_per_rad_s, speed * rpm_per_rad_s);
    add("speed_out", "rpm", obs.speed_out * rpm, (integral + path) * rpm_per_rad_s,
        out * rpm_per_rad_s);
}

// W2 is given: the speed of the imposed current, exactly.
void TickDiff::follow()
{
    module_ = "observer following";
    const double rpm = si_.bases.rpm_from_step(1);
    add("speed", "rpm", after_.observer.speed * rpm, before_.frame_speed * rpm, rpm / 2);
    add("speed_out", "rpm", after_.observer.speed_out * rpm, before_.frame_speed * rpm, rpm / 2);
}

int64_t TickDiff::measured_position() const
{
    return running_ ? position_q32_ : before_.frame.turns_q32;
}

// Ramp or position profile. Below RUN the reference of a speed goes by the imposed vector's ramp.
void TickDiff::plan()
{
    const bool plans = has_slow_part(1) && (running_ || drags());
    if (!plans) {
        return;
    }
    module_ = "speed plan";
    if (before_.mode != in_.command.mode) {
        leave_out("speed plan: it begins anew, the mode changes");
        return;
    }
    if (after_.mode == DRIVE_MODE_POSITION) {
        position_plan();
        return;
    }
    const double rpm = si_.bases.rpm_from_step(1);
    twin::SpeedLoop twin(twin::speed_loop_params(si_));
    twin.reset(si_.speed_of_step(before_.speed_loop.reference), 0);
    double wanted = si_.step_of_speed(twin.ramp(si_.speed_of_step(in_.command.target)));
    if (!running_) {
        const double ramp = si_.cfg.startup.ramp;
        wanted = before_.frame_speed + std::clamp(wanted - before_.frame_speed, -ramp, ramp);
    }
    add("reference", "rpm", after_.speed_reference * rpm, wanted * rpm, rpm / 2);
}

// One period of the profile, d away from its target, in units u, B = 2^30/braking_inverse, s = √(d/B + c²): d rounded
// down to a unit makes v_max/(2Bs), at its end v_max/(2Bc), the root v_max·2^-15, 2 steps more. The reference adds the
// lag, rounded down to 2^-16 turn, times the gain, and 1.
void TickDiff::position_plan()
{
    const position_loop_cfg_t &c = si_.cfg.position_loop;
    const position_loop_t &from = before_.position_loop;
    constexpr double TURN_Q16 = 65536.0;
    const auto rad = [](double q32) { return twin::radians_of_q32(q32); };
    const double target = in_.command.target * TURN_Q16;
    twin::PositionLoop twin(twin::position_loop_params(si_));
    twin.reset(rad(static_cast<double>(from.profile_q32)), si_.speed_of_step(from.profile_speed));
    const double reference = twin.step(rad(target), rad(static_cast<double>(measured_position())));

    const double unit = std::ldexp(1.0, static_cast<int>(c.distance_shift));
    const double distance =
        std::max(std::abs(target - static_cast<double>(from.profile_q32)) / unit - 1.0, 0.0);
    const double braking = 1073741824.0 / c.braking_inverse;
    const double soft = c.softness_q15 / Q15;
    const double slope = 1 / (2 * braking * std::sqrt(distance / braking + soft * soft));
    const double profile = c.speed_max * (slope + 1 / Q15) + 2;
    const double gain = std::ldexp(c.gain, -static_cast<int>(c.gain_shift));
    const double rpm = si_.bases.rpm_from_step(1);
    add("profile's speed", "rpm", after_.position_loop.profile_speed * rpm,
        si_.step_of_speed(twin.speed()) * rpm, profile * rpm);
    add("reference", "rpm", after_.speed_reference * rpm, si_.step_of_speed(reference) * rpm,
        (profile + gain + 1) * rpm);
}

// In the ticks in which it runs.
void TickDiff::speed_loop()
{
    const bool runs =
        has_slow_part(0) && running_ && before_.voltage_driven == after_.voltage_driven;
    if (has_slow_part(0) && drags()) {
        imposed_speed();
    }
    if (!runs) {
        return;
    }
    if (after_.voltage_driven) {
        magnitude();
        return;
    }
    module_ = "speed loop";
    const pi_cfg_t &pi = si_.cfg.speed_loop.pi;
    const torque_range_t &range = after_.torque_range;
    twin::SpeedLoop::Params p = twin::speed_loop_params(si_);
    p.current_min_a = si_.current(range.lower);
    p.current_max_a = si_.current(range.upper);
    twin::SpeedLoop twin(p);
    twin.reset(si_.speed_of_step(before_.speed_loop.reference),
               before_.speed_loop.pi.integral_q26 / Q26 * si_.bases.current_a);
    const double demand = twin.step(si_.speed_of_step(after_.speed_reference),
                                    si_.speed_of_step(after_.observer.speed));
    const double kp = std::ldexp(pi.kp, -static_cast<int>(pi.kp_shift));
    const double ki = std::ldexp(pi.ki, -static_cast<int>(pi.ki_shift) - 11) + INTEGRAL_LSB;
    const double middle = range.lower == -range.upper ? 0 : 2 * MIDDLE_LSB;
    add("i_q reference", "A", si_.current(after_.signals.current_ref.q), demand,
        (SPEED_LOOP_LSB + middle + kp + ki) * si_.current(1));
    add("integral", "A", after_.speed_loop.pi.integral_q26 / Q26 * si_.bases.current_a,
        twin.pi().integral(), ki * si_.current(1));
}

// Of an imposed vector there is no PI: its speed is the reference, its torque current what that takes.
void TickDiff::imposed_speed()
{
    module_ = "speed loop";
    const torque_range_t &range = after_.torque_range;
    const double rpm = si_.bases.rpm_from_step(1);
    twin::SpeedLoop::Params p = twin::speed_loop_params(si_);
    p.current_min_a = si_.current(range.lower);
    p.current_max_a = si_.current(range.upper);
    twin::SpeedLoop twin(p);
    twin.reset(si_.speed_of_step(before_.speed_loop.reference), 0);
    const double torque = twin.accelerate(si_.speed_of_step(after_.speed_reference));
    add("frame's speed", "rpm", after_.frame_speed * rpm, si_.step_of_speed(twin.reference()) * rpm,
        rpm / 2);
    add("i_q reference", "A", si_.current(after_.signals.current_ref.q), torque,
        2 * si_.current(1));
}

// |U| by the speed PI. The EMF: the speed rounded down to Q15, the product rounded down.
void TickDiff::magnitude()
{
    module_ = "voltage magnitude";
    const pi_cfg_t &pi = si_.cfg.voltage_drive.pi;
    const double one = si_.bases.voltage_v / Q26;
    const double reference = std::clamp<double>(
        after_.speed_reference, -si_.cfg.speed_loop.speed_max, si_.cfg.speed_loop.speed_max);
    const double emf_per_q15 = after_.model.run_loop.emf_q13 / Q13;
    const double emf = emf_per_q15 * std::ldexp(reference, -si_.bases.speed_shift);
    twin::Pi twin(twin::voltage_pi_params(si_));
    twin.reset(before_.speed_loop.pi.integral_q26 * one);
    const double magnitude =
        twin.step(si_.speed_of_step(reference - after_.observer.speed), si_.voltage(emf),
                  si_.voltage(before_.signals.voltage_limit));
    const double kp = std::ldexp(pi.kp, -static_cast<int>(pi.kp_shift));
    const double ki = std::ldexp(pi.ki, -static_cast<int>(pi.ki_shift) - 11) + INTEGRAL_LSB;
    add("U", "V", si_.voltage(after_.voltage_magnitude), magnitude,
        (SPEED_LOOP_LSB + emf_per_q15 + kp + ki) * si_.voltage(1));
    add("integral", "V", after_.speed_loop.pi.integral_q26 * one, twin.integral(),
        ki * si_.voltage(1));
}

void TickDiff::voltage_limit()
{
    add("limit", "V", si_.voltage(after_.signals.voltage_limit),
        si_.voltage(after_.signals.bus * (si_.cfg.modulator.ratio_max_q15 / Q15)),
        LIMIT_LSB * si_.voltage(1));
}

// Paper B (40), (41), (43). Its angle beside that of the rotor.
void TickDiff::phase_compensator()
{
    module_ = "phase compensator";
    constexpr double DEG_PER_STEP = 360.0 / STEPS_PER_TURN;
    constexpr double DEG_PER_RAD = 360.0 / TWO_PI;
    const dq_t &i = after_.signals.current;
    const auto rotor = static_cast<uint32_t>(static_cast<uint64_t>(position_q32_));
    const double limit = after_.signals.voltage_limit;
    const double magnitude = std::clamp<double>(after_.voltage_magnitude, -limit, limit);
    twin::PhaseCompensator twin(twin::phase_compensator_params(si_));
    twin.set(apart(rotor, before_.compensator.angle) / STEPS_PER_TURN * TWO_PI,
             before_.compensator.current_angle / STEPS_PER_TURN * TWO_PI);
    const double lead =
        twin.step(si_.current(i.d), si_.current(i.q), 0,
                  after_.observer.speed_out / STEPS_PER_TURN * TWO_PI, magnitude < 0 ? -1 : 1);
    add("alpha_r", "deg el", after_.compensator.current_angle * DEG_PER_STEP,
        twin.current_angle() * DEG_PER_RAD, CURRENT_ANGLE_STEPS * DEG_PER_STEP);
    add("firing angle", "deg el", apart(rotor, after_.compensator.angle) * DEG_PER_STEP,
        twin.angle() * DEG_PER_RAD, FIRING_ANGLE_STEPS * DEG_PER_STEP);
    voltage_drive(lead);
}

void TickDiff::voltage_drive(double lead)
{
    module_ = "voltage drive";
    const drive_signals_t &s = after_.signals;
    voltage_limit();
    const double limit = si_.voltage(s.voltage_limit);
    const double magnitude = std::clamp(si_.voltage(after_.voltage_magnitude), -limit, limit);
    add("v_d", "v_q", "V", si_.voltage(s.voltage),
        Vector(-std::sin(lead), std::cos(lead)) * magnitude,
        Vector::Constant(VOLTAGE_LSB * si_.voltage(1) + twin::turn_error(Vector(magnitude, 0))));
    const Vector mean = current(before_.signals.current_ref);
    add("i_d, mean", "i_q, mean", "A", current(s.current_ref),
        mean + (current(s.current) - mean) * MEAN_SHARE, Vector::Constant(si_.current(1)));
}

// What makes the voltage of this tick.
void TickDiff::loops()
{
    if (begins_anew()) {
        leave_out("the loops: they begin anew, the state changes in this tick");
    } else if (before_.voltage_driven != after_.voltage_driven) {
        leave_out("the loops: they begin anew, current regulators come or go in this tick");
    } else if (after_.state == DRIVE_STATE_ALIGN &&
               align_steps_voltage(&after_.align, &si_.cfg.startup.align)) {
        leave_out("current loop: it rests while the alignment measures");
    } else if (after_.voltage_driven) {
        phase_compensator();
    } else {
        current_loop();
    }
}

void TickDiff::current_loop()
{
    const drive_signals_t &s = after_.signals;
    const double lsb = si_.voltage(1);
    module_ = "current loop";
    voltage_limit();
    CurrentLoop twin(twin::current_loop_params(si_));
    const double one = si_.bases.voltage_v / Q26;
    twin.reset({before_.current_loop.pi_d.integral_q26 * one,
                before_.current_loop.pi_q.integral_q26 * one});
    const double speed =
        running_
            ? si_.speed_of_q15(s.speed)
            : si_.speed_of_q15(std::floor(std::ldexp(after_.frame_speed, -si_.bases.speed_shift)));
    const Vector v =
        twin.step(current(s.current_ref), current(running_ ? s.current : s.current_frame), speed,
                  si_.voltage(s.voltage_limit));
    // At the circle v_q = √(limit² − v_d²): an error of v_d counts |v_d/v_q| times.
    const double steepness = std::abs(v.y()) > lsb ? std::abs(v.x() / v.y()) : 1.0;
    const double cut = twin.cut() ? CURRENT_LOOP_LSB * (1.0 + steepness) + ROOT_LSB : 0.0;
    add("v_d", "v_q", "V", si_.voltage(s.voltage), v,
        Vector(CURRENT_LOOP_LSB, CURRENT_LOOP_LSB + cut) * lsb);
    // What the circle takes is given back to the integral of q.
    add("integral d", "integral q", "V",
        Vector(after_.current_loop.pi_d.integral_q26, after_.current_loop.pi_q.integral_q26) * one,
        Vector(twin.pi_d().integral(), twin.pi_q().integral()),
        Vector(INTEGRAL_LSB, INTEGRAL_LSB + (twin.cut() ? CURRENT_LOOP_LSB + cut : 0.0)) * lsb);
}

// The bus is followed in every tick.
void TickDiff::reciprocal()
{
    module_ = "modulator";
    const double inverse = before_.modulator.inverse_bus_q12 / Q12;
    const double bus = after_.signals.bus / Q15;
    const double next =
        std::clamp(inverse * (2.0 - inverse * bus), 1.0, si_.cfg.modulator.inverse_max_q12 / Q12);
    // The error of the reciprocal rounded down, times the reciprocal; the step to nearest.
    add("1/bus", "1/V", after_.modulator.inverse_bus_q12 / Q12 / si_.bases.voltage_v,
        next / si_.bases.voltage_v, (inverse + 0.5) / Q12 / si_.bases.voltage_v);
}

// Gates open: the legs rest in the middle, and while a turning rotor is looked for at the low side.
void TickDiff::rest()
{
    reciprocal();
    if (before_.state == after_.state) {
        const bool catching = after_.state == DRIVE_STATE_CATCH_SPIN;
        const int32_t full = si_.cfg.modulator.timer_counts;
        const double counts = catching ? 0 : full / 2;
        add("duty_a", "", static_cast<double>(out_.compare.phase[0]) / full, counts / full, 0);
        add("duty_b", "", static_cast<double>(out_.compare.phase[1]) / full, counts / full, 0);
        add("duty_c", "", static_cast<double>(out_.compare.phase[2]) / full, counts / full, 0);
    }
}

// An imposed frame that is put elsewhere in this tick has been turned on from there.
int64_t TickDiff::modulated_frame() const
{
    if (running_) {
        return position_q32_;
    }
    return begins_anew() ? after_.frame.turns_q32 - after_.frame_speed : before_.frame.turns_q32;
}

void TickDiff::modulation()
{
    reciprocal();
    const step_t step = running_ ? after_.observer.speed_out : after_.frame_speed;
    const double angle = radians(modulated_frame()) + 1.5 * step / STEPS_PER_TURN * TWO_PI;
    const Vector ratio =
        twin::park_inverse(Vector(after_.signals.voltage.d, after_.signals.voltage.q) / Q15 *
                               (after_.modulator.inverse_bus_q12 / Q12),
                           angle);
    const Vector own(after_.signals.ratio_ab.alpha / Q15, after_.signals.ratio_ab.beta / Q15);
    add("ratio_alpha", "ratio_beta", "", own, ratio,
        Vector::Constant((PARK_LSB + RATIO_LSB) / Q15 + twin::turn_error(ratio)));
    duties(angle);
}

// The current for which dead time is given back: near its reference, or the imposed one's mean.
Vector TickDiff::expected_current() const
{
    const drive_signals_t &s = after_.signals;
    const Vector reference = current(s.current_ref);
    return running_ ? Vector(reference + LACKING * (current(s.current) - reference))
                    : current(s.current_mean);
}

void TickDiff::duties(double angle)
{
    const modulator_cfg_t &cfg = si_.cfg.modulator;
    const Vector ratio(after_.signals.ratio_ab.alpha / Q15, after_.signals.ratio_ab.beta / Q15);
    const double bus_v = si_.bases.voltage_v / (after_.modulator.inverse_bus_q12 / Q12);
    Eigen::Vector3d exact = twin::Modulator::duties(ratio, 1.0);
    double lsb = DUTY_LSB + 0.5 * Q15 / cfg.timer_counts;
    if (modulator_compensates(&cfg)) {
        const twin::Modulator::Losses losses = {cfg.dead_time_q15 / Q15, si_.voltage(cfg.drop_q15),
                                                si_.current(cfg.ripple_q15),
                                                cfg.edge_slope / si_.current(Q15)};
        const Vector i = twin::park_inverse(expected_current(), angle);
        exact += twin::Modulator::give_back(losses, ratio * bus_v, bus_v, i);
        exact = exact.cwiseMax(0.0).cwiseMin(1.0);
        const double longest = ratio.norm();
        const double loss = (losses.dead_time_share + losses.drop_v / bus_v) * Q15;
        const double crossing = 2 * PHASE_LSB + 9 * (2 * longest * PHASE_LSB + 1);
        const double ripple = crossing * cfg.ripple_q15 / Q15 + 1;
        const double current_lsb =
            PHASE_LSB + PARK_LSB + LACKING_LSB + twin::turn_error(i) / si_.current(1);
        // Never more than the whole give-back, in either direction; drop and product rounded down.
        const double share = std::min(cfg.edge_slope * (ripple + current_lsb) / Q15, 2.0);
        lsb += share * loss + 2 + PHASE_LSB;
    }
    const std::array<const char *, 3> names = {"duty_a", "duty_b", "duty_c"};
    for (int leg = 0; leg < 3; leg++) {
        const auto k = static_cast<std::size_t>(leg);
        add(names[k], "", static_cast<double>(out_.compare.phase[k]) / cfg.timer_counts, exact(leg),
            lsb / Q15);
    }
}

// Paper A (23), exact; while θ̂ does not run free it closes up to the frame by 1/64, rounded down.
void TickDiff::position()
{
    module_ = "rotor position";
    constexpr double DEG_PER_STEP = 360.0 / STEPS_PER_TURN;
    constexpr double PULL = 1.0 / 64.0;
    const auto moved = static_cast<double>(after_.position.turns_q32 - position_q32_);
    double step = after_.observer.speed_out;
    if (!running_ && !track_) {
        step += apart(position_q32_, after_.frame.turns_q32) * PULL;
    }
    add("advance", "deg el", moved * DEG_PER_STEP, step * DEG_PER_STEP, DEG_PER_STEP);
    if (!running_ && !begins_anew()) {
        const auto turned = static_cast<double>(after_.frame.turns_q32 - before_.frame.turns_q32);
        add("frame's advance", "deg el", turned * DEG_PER_STEP, after_.frame_speed * DEG_PER_STEP,
            DEG_PER_STEP / 2);
    }
}

Diff TickDiff::all()
{
    configuration();
    model();
    angle_sensor();
    if (before_.state <= DRIVE_STATE_OFFSET_CAL || after_.state == DRIVE_STATE_OFFSET_CAL) {
        leave_out("all that works with currents: their offset is not known yet");
        return diff_;
    }
    sampling();
    if (!is_controlled(before_.state) || !is_controlled(after_.state)) {
        leave_out("the control of a current: there is none in this tick");
        rest();
        return diff_;
    }
    transforms();
    applied_voltage();
    if (before_.state == DRIVE_STATE_ALIGN && after_.state != DRIVE_STATE_ALIGN) {
        leave_out("the observer: it begins anew, the state changes in this tick");
    } else {
        observer();
    }
    plan();
    speed_loop();
    loops();
    modulation();
    position();
    return diff_;
}

} // namespace

bool Comparison::departs() const
{
    return !(std::abs(drive - reference) <= tolerance);
}

Diff diff_tick(const drive_t &before, const Tick &tick, const drive_cfg_t &built)
{
    return TickDiff(before, tick, built).all();
}

const Comparison *first_departure(const Diff &diff)
{
    const auto found = std::find_if(diff.rows.begin(), diff.rows.end(),
                                    [](const Comparison &row) { return row.departs(); });
    return found == diff.rows.end() ? nullptr : &*found;
}

std::string diff_text(const Diff &diff)
{
    std::string text = fmt::format("  {:<19}{:<24}{:>13}{:>13}{:>12}{:>12}\n", "module", "quantity",
                                   "drive", "reference", "apart", "tolerance");
    for (const Comparison &row : diff.rows) {
        text += fmt::format("{} {:<19}{:<24}{:>13.6g}{:>13.6g}{:>12.3g}{:>12.3g} {}\n",
                            row.departs() ? '*' : ' ', row.module, row.quantity, row.drive,
                            row.reference, std::abs(row.drive - row.reference), row.tolerance,
                            row.unit);
    }
    if (!diff.left_out.empty()) {
        text += fmt::format("not compared in this tick: {}\n", diff.left_out);
    }
    text += NEVER_COMPARED;
    const Comparison *const first = first_departure(diff);
    if (first == nullptr) {
        return text +
               fmt::format("no departure: {} values within their roundings\n", diff.rows.size());
    }
    return text + fmt::format("first departure: {}, {}: drive {:.6g}, reference {:.6g} {}, "
                              "tolerance {:.3g}\n",
                              first->module, first->quantity, first->drive, first->reference,
                              first->unit, first->tolerance);
}

} // namespace nf::debug
