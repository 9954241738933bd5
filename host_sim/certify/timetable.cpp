// SPDX-License-Identifier: MIT
#include "timetable.h"

#include "sampling_units.h"
#include "times.h"

namespace nf::certify
{
namespace
{

zoo::Times times_of(const Config &config, double inertia_kg_m2)
{
    const MotorSettings &motor = config.motor;
    zoo::Motor as_drawn;
    as_drawn.pole_pairs = motor.pole_pairs;
    as_drawn.flux_linkage_wb = motor.flux_linkage_wb;
    as_drawn.rated_torque_nm = motor.rated_torque_nm;
    as_drawn.rated_speed_rpm = motor.rated_speed_rpm;
    as_drawn.max_current_a = motor.max_current_a;
    as_drawn.inertia_kg_m2 = inertia_kg_m2;
    return zoo::times_of(as_drawn, config.board.pwm_frequency_hz);
}

// The last part of a stretch, when the speed has settled.
Window end_of(double from_s, double to_s)
{
    constexpr double share = 0.3;
    return {to_s - share * (to_s - from_s), to_s};
}

} // namespace

ScenarioSettings timetable(const Config &config, double inertia_kg_m2)
{
    const zoo::Times times = times_of(config, inertia_kg_m2);
    const double rated_rpm = config.motor.rated_speed_rpm;
    ScenarioSettings scenario;
    scenario.id = "certify";
    scenario.title = "start, half and rated speed, load on and off, reversal";
    scenario.mode = DriveMode::speed;
    scenario.prelude_s = calibration_time(config.board, config.tuning);
    scenario.evaluate_from_s = times.started;
    scenario.duration_s = times.end;
    scenario.command = {{times.started, rated_rpm / 2},
                        {times.full, rated_rpm},
                        {times.stopped, -REVERSED_SPEED * rated_rpm}};
    scenario.load = {{times.held, 0}, {times.full, 0}, {times.loaded, 0}, {times.unloaded, 0}};
    return scenario;
}

Windows windows_of(const ScenarioSettings &scenario)
{
    const std::vector<TimedValue> &load = scenario.load;
    return {end_of(load[STEP_LOAD].time_s, load[STEP_LOAD + 1].time_s),
            end_of(scenario.command.back().time_s, scenario.duration_s)};
}

} // namespace nf::certify
