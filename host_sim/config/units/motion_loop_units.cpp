// SPDX-License-Identifier: MIT
#include "motion_loop_units.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// The profile brakes with this share of its acceleration, so that it can follow its own curve.
constexpr double BRAKING_SHARE = 0.9;

constexpr double SOFT_SPEED_MOST = 0.5; // of rated speed

constexpr int LIFT_MAX = 14;      // of inertia_lift
constexpr double RATE_MAX = 0.49; // of a ramp with less torque than 131 LSB: learned more slowly

const char *const CORRECTION_REASON = "the firmware's correction of J";

// Steps by which the speed changes in a slow period at an electrical acceleration.
double ramp_steps(double acceleration_el, const TuningSettings &tuning, const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    return acceleration_el * slow_period * b.control_period_s / TWO_PI * STEPS_PER_TURN;
}

pi_cfg_t make_speed_pi(const TuningSettings &tuning, const Model &m, const Bases &b,
                       const char *key, double bandwidth_hz)
{
    const double omega = TWO_PI * bandwidth_hz;
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    // The error between full speed one way and the other fits 2·Ω_b.
    const double per_unit = 2 * b.speed_el_rad_s / b.current_a / m.torque_acceleration;
    return make_pi(2 * tuning.speed_damping * omega * per_unit,
                   omega * omega * per_unit * slow_period, 2, key, bandwidth_hz);
}

// The ripple of the estimate falls with the speed: where it allows the whole bandwidth, the loop
// has it.
double soft_speed_rpm(const MotorSettings &motor, const TuningSettings &tuning)
{
    const double share = std::max(1.0, tuning.speed_bandwidth_hz / tuning.low_speed_bandwidth_hz);
    return std::min(tuning.handover_speed_pct / 100 * share, SOFT_SPEED_MOST) *
           motor.rated_speed_rpm;
}

// current_per_step: i_q, Q15 of I_b, for a change of the reference by a step in a slow period.
void set_inertia_correction(speed_loop_cfg_t &c, const TuningSettings &tuning,
                            double current_per_step)
{
    constexpr double INTEGRAL_PER_LSB = 2048; // Q26 of Q15
    constexpr double Q17 = 131072;
    const double factor = 1 + tuning.adapt_inertia_pct / 100;
    const double ramp_q26 = current_per_step * c.ramp * INTEGRAL_PER_LSB;
    keep(c.inertia_least_q13, Q13 / factor, Q13 / 4, Q13);
    keep(c.inertia_most_q13, Q13 * factor, Q13, MANTISSA_MAX);
    if (tuning.adapt_inertia_pct > 0) {
        require(tuning.inertia_feed_forward, 1, 1,
                {"speed_loop.inertia_feed_forward", tuning.inertia_feed_forward},
                "adaptation.inertia_pct needs the whole of J fed forward");
        const double rate = std::min(Q17 / ramp_q26, RATE_MAX);
        const Mantissa mantissa =
            normalise(std::ldexp(rate, 16), 0, 30,
                      {"adaptation.inertia_pct", tuning.adapt_inertia_pct}, CORRECTION_REASON);
        c.inertia_rate = mantissa.value;
        c.inertia_rate_shift = mantissa.shift;
    }
}

// Of low speed, where it has gains of its own.
void set_soft_pi(speed_loop_cfg_t &c, const MotorSettings &motor, const TuningSettings &tuning,
                 const Model &m, const Bases &b)
{
    const double slow_hz = tuning.low_speed_bandwidth_hz;
    const bool has_own = slow_hz > 0 && std::abs(slow_hz - tuning.speed_bandwidth_hz) > 0;
    c.soft = c.pi;
    if (has_own) {
        c.soft = make_speed_pi(tuning, m, b, "speed_loop.low_speed_bandwidth_hz", slow_hz);
        keep(c.soft_speed, b.step_from_rpm(soft_speed_rpm(motor, tuning)), 0, Q30 / 2);
    }
}

// The torque of J is fed forward.
void set_inertia(speed_loop_cfg_t &c, const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const double current_per_step = tuning.inertia_feed_forward / ramp_steps(1.0, tuning, b) /
                                    m.torque_acceleration / b.current_a * Q15;
    const Mantissa inertia =
        normalise(std::ldexp(current_per_step, 16 - LIFT_MAX), 0, 30 + LIFT_MAX,
                  {"speed_loop.inertia_feed_forward", tuning.inertia_feed_forward},
                  "more is beyond the firmware's numbers for this inertia");
    const int shift = static_cast<int>(inertia.shift) - LIFT_MAX;
    c.inertia = inertia.value;
    c.inertia_shift = static_cast<uint32_t>(std::max(shift, 0));
    c.inertia_lift = static_cast<uint32_t>(std::max(-shift, 0));
    set_inertia_correction(c, tuning, current_per_step);
}

// The profile's braking distance in units of 2^shift Q32 turns, 2^13…2^14 of them.
void store_braking(position_loop_cfg_t &c, const TuningSettings &tuning, const Bases &b)
{
    const double speed = rad_s_from_rpm(tuning.position_speed_rpm);
    const double brake = tuning.position_acceleration_rad_s2 * BRAKING_SHARE;
    const double distance_q32 = b.turns_from_mech_rad(speed * speed / (2 * brake)) * STEPS_PER_TURN;
    require(distance_q32, std::ldexp(Q13, 8), std::ldexp(Q13, 48),
            {"position_loop.speed_rpm", tuning.position_speed_rpm, 2},
            "the braking distance at position_loop.acceleration_rad_s2 in the firmware's numbers");
    int shift = 8;
    while (std::ldexp(distance_q32, -shift) >= Q14) {
        shift++;
    }
    c.distance_shift = static_cast<uint32_t>(shift);
    c.braking_inverse = static_cast<int32_t>(std::lround(Q30 / std::ldexp(distance_q32, -shift)));
    store(c.softness_q15, brake * tuning.position_softness_s / speed * Q15, 0, 12288,
          {"position_loop.softness_s", tuning.position_softness_s},
          "a share of the time to brake from full speed");
}

} // namespace

speed_loop_cfg_t make_speed_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                 const Model &m, const Bases &b)
{
    const double one_step_ramp = ramp_steps(1.0, tuning, b); // steps for 1 rad/s²
    speed_loop_cfg_t c{};
    c.pi = make_speed_pi(tuning, m, b, "speed_loop.bandwidth_hz", tuning.speed_bandwidth_hz);
    set_soft_pi(c, motor, tuning, m, b);
    store(c.ramp, rad_s_from_rpm(tuning.speed_ramp_rpm_s) * motor.pole_pairs * one_step_ramp, 1,
          Q30 / 2, {"speed_loop.ramp_rpm_s", tuning.speed_ramp_rpm_s},
          "the firmware's steps of speed in a slow period");
    store(c.speed_max, b.step_from_rpm(motor.max_speed_rpm), 1, Q30 / 2,
          {"motor.max_speed_rpm", motor.max_speed_rpm},
          "an eighth of an electrical turn in a PWM period");
    set_inertia(c, tuning, m, b);
    c.error_shift = static_cast<uint32_t>(b.speed_shift) + 1U;
    return c;
}

position_loop_cfg_t make_position_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b)
{
    position_loop_cfg_t c{};
    const double acceleration = tuning.position_acceleration_rad_s2 * motor.pole_pairs;
    store(c.ramp, ramp_steps(acceleration, tuning, b), 1, Q30 / 2,
          {"position_loop.acceleration_rad_s2", tuning.position_acceleration_rad_s2},
          "the firmware's steps of speed in a slow period");
    store(c.speed_max, b.step_from_rpm(tuning.position_speed_rpm), 1, Q30 / 2,
          {"position_loop.speed_rpm", tuning.position_speed_rpm},
          "an eighth of an electrical turn in a PWM period");
    store_braking(c, tuning, b);
    const double gain = TWO_PI * tuning.position_bandwidth_hz * b.control_period_s * 65536.0;
    const Mantissa g =
        normalise(gain, 0, 30, {"position_loop.bandwidth_hz", tuning.position_bandwidth_hz},
                  "half the PWM frequency in rad/s");
    c.gain = g.value;
    c.gain_shift = g.shift;
    c.pole_pairs = static_cast<uint32_t>(motor.pole_pairs);
    return c;
}

} // namespace nf
