// SPDX-License-Identifier: MIT
#include "weakening_units.h"

#include "modulator_units.h"
#include "numbers.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf
{
namespace
{

// Electrical angle in a PWM period up to which the middle current of the observer and the lead of
// the voltage hold.
constexpr double TURN_MAX_RAD = 0.7;

// What the firmware keeps of the voltage for the current control, and the largest EMF, of U_b:
// weakening.c.
constexpr double WEAKENING_RESERVE = 3.0 / 256;
constexpr double EMF_MOST = 1.9;

// What the field is weakened by, with i_d down to −deepest_a.
const char *weakened_by(const MotorSettings &motor, double deepest_a)
{
    if (deepest_a <= 0) {
        return "and current_loop.weakening_pct = 0 or drive.method = \"voltage_phase\" does not "
               "weaken the field";
    }
    return deepest_a == motor.demagnetising_current_a
               ? "even with the field weakened by motor.demagnetising_current_a"
               : "even with the field weakened by current_loop.weakening_pct of "
                 "motor.max_current_a";
}

} // namespace

double deepest_current(const MotorSettings &motor, const TuningSettings &tuning)
{
    const double share_a = tuning.weakening_pct / 100 * motor.max_current_a;
    const double bears_a = motor.demagnetising_current_a;
    if (tuning.method == ControlMethod::voltage_phase) {
        return 0; // its phase compensator holds i_d at 0
    }
    return bears_a > 0 ? std::min(share_a, bears_a) : share_a;
}

void check_speed(const MotorSettings &motor, const BoardSettings &board,
                 const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const double speed = rad_s_from_rpm(motor.max_speed_rpm) * motor.pole_pairs;
    const double deepest_a = deepest_current(motor, tuning);
    const double least_flux = motor.flux_linkage_wb - motor.inductance_d_h * deepest_a;
    const Source setting = {"motor.max_speed_rpm", motor.max_speed_rpm};
    require(speed * std::max(least_flux, 0.0), 0,
            largest_ratio(board) * board.bus_nominal_v * (1 - WEAKENING_RESERVE), setting,
            fmt::format("above it the motor's EMF exceeds what board.bus_nominal_v and "
                        "board.duty_margin_pct leave, {}",
                        weakened_by(motor, deepest_a))
                .c_str());
    require(
        speed * motor.flux_linkage_wb, 0, EMF_MOST * b.voltage_v, setting,
        "above it the motor's EMF exceeds 1.9 times board.bus_full_scale_v, which the firmware's "
        "numbers end with");
    require(m.max_speed_el * b.control_period_s, 0, TURN_MAX_RAD,
            {"motor.max_speed_rpm", motor.max_speed_rpm},
            "above it the rotor turns more than 0.7 rad in a PWM period; a higher "
            "board.pwm_frequency_hz raises it");
}

} // namespace nf
