// SPDX-License-Identifier: MIT
#include "times.h"

#include <algorithm>
#include <cmath>

namespace nf::zoo
{
namespace
{

// The times of a scenario. A drive accelerates with this share of its largest torque at least, and
// with this one of the rated torque where it imposes the current, up to a tenth of rated speed; the
// hand-over takes a while.
constexpr double RAMP_TORQUE = 0.15;
constexpr double IMPOSED_TORQUE = 0.05;
constexpr double IMPOSED_SPEED = 0.1;
constexpr double HANDOVER_S = 0.2;
// For the speed to settle and to show whether it swings: the largest torque's time from rest to
// rated speed is two thirds of a period of the speed loop.
constexpr double REST_LOOPS = 3;
constexpr double REST_S = 0.3;
// And at the last and lowest speed until ripple and swings can be told apart.
constexpr double LAST_TURNS = 2.5; // electrical
constexpr double LAST_SETTLED_S = 0.2;
// The start-up of a standing rotor in units of 1/ω_n of its swing in the field of the rated
// current, and ticks.
constexpr double START_SWINGS = 60;
constexpr double START_TICKS = 256;
// From when on that field holds a load.
constexpr double HELD_SWINGS = 0.3;
constexpr double HELD_TICKS = 64;

} // namespace

Times times_of(const Motor &motor, double pwm_frequency_hz)
{
    const double tick_s = 1 / pwm_frequency_hz;
    const double swing = std::sqrt(motor.pole_pairs * motor.rated_torque_nm / motor.inertia_kg_m2);
    const double rated_a = motor.rated_torque_nm / (1.5 * motor.pole_pairs * motor.flux_linkage_wb);
    // From rest to rated speed with rated torque, and with the largest one.
    const double rated_s =
        motor.rated_speed_rpm * RAD_S_PER_RPM * motor.inertia_kg_m2 / motor.rated_torque_nm;
    const double fastest_s = rated_s * rated_a / motor.max_current_a;
    const double rest = REST_S + REST_LOOPS * fastest_s;
    const double imposed = IMPOSED_SPEED * rated_s / IMPOSED_TORQUE + HANDOVER_S;
    const double last_turn_s = 60 / (LAST_SPEED * motor.rated_speed_rpm * motor.pole_pairs);
    const auto reach = [&](double share) { return share * fastest_s / RAMP_TORQUE; };
    Times times{};
    times.held = HELD_SWINGS / swing + HELD_TICKS * tick_s;
    times.started = START_SWINGS / swing + START_TICKS * tick_s;
    times.full = times.started + imposed + reach(0.55) + rest;
    times.loaded = times.full + reach(0.45) + rest;
    times.unloaded = times.loaded + rest;
    times.stopped = times.unloaded + rest;
    times.reversed = times.stopped + reach(1) + imposed + rest;
    times.end =
        times.reversed + imposed + std::max(rest, LAST_SETTLED_S + LAST_TURNS * last_turn_s);
    return times;
}

} // namespace nf::zoo
