// SPDX-License-Identifier: MIT
#include "imposed_current.h"

#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// In this time, in units of 1/ω_n, the imposed current rises.
constexpr double RISE = 0.8;

// While the rotor is pulled in, its EMF drives up to 0.8 of the imposed current on top of it.
constexpr double SWING_HEADROOM = 1.8;

// A vector of the current φ/(L_q − L_d) has no stiffness against a rotor on it: the reluctance
// turns it away as strongly as the magnet holds it. Half of it leaves half of the stiffness, if the
// file's L_d and L_q are right.
constexpr double SALIENT_SHARE = 0.5;

// What the imposed current takes of R·I, as a multiple of the EMF at the hand-over: R, known within
// some percent, and gains of sensors 2 % apart then leave the angle within some degrees.
constexpr double HIDDEN_EMF = 3;

} // namespace

double stiff_current(const MotorSettings &motor)
{
    const double saliency = motor.inductance_q_h - motor.inductance_d_h;
    return saliency > 0 ? SALIENT_SHARE * motor.flux_linkage_wb / saliency : HUGE_VAL;
}

double hold_current(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &tuning)
{
    return std::min({tuning.startup_current_pct / 100 * continuous_current(motor),
                     board.overcurrent_a / SWING_HEADROOM, motor.max_current_a,
                     stiff_current(motor)});
}

double handover_rad_s(const MotorSettings &motor, const TuningSettings &tuning)
{
    return tuning.handover_speed_pct / 100 * motor.pole_pairs *
           rad_s_from_rpm(motor.rated_speed_rpm);
}

double moving_current(const MotorSettings &motor, const BoardSettings &board,
                      const TuningSettings &tuning)
{
    const double seen =
        HIDDEN_EMF * handover_rad_s(motor, tuning) * motor.flux_linkage_wb / motor.resistance_ohm;
    return std::clamp(std::min(stiff_current(motor), seen), hold_current(motor, board, tuning),
                      motor.max_current_a);
}

double active_share(double current_a, const MotorSettings &motor)
{
    return 1 - SALIENT_SHARE * current_a / stiff_current(motor);
}

double swing_rad_s(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m)
{
    const double current = hold_current(motor, board, tuning);
    return std::sqrt(m.torque_acceleration * current * active_share(current, motor));
}

int32_t hold_slope(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const double current = hold_current(motor, board, tuning) / b.current_a * Q15;
    const double rise_s = RISE / swing_rad_s(motor, board, tuning, m);
    return static_cast<int32_t>(std::max(1.0, std::ceil(current / ticks(rise_s, b))));
}

double count_a(const BoardSettings &board)
{
    return board.current_full_scale_a / std::ldexp(1.0, board.adc_bits - 1);
}

} // namespace nf
