/* SPDX-License-Identifier: MIT */
// What a run of a scenario is given beside its configuration, and what comes out of it.
#pragma once

#include "found_fault.h"
#include "metrics.h"
#include "saturation.h"
#include "tick.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

struct RunOptions {
    TickSink *sink = nullptr;             // sees every tick
    std::function<void(double)> progress; // share of the run that is done, now and then
    // Writes over what the drive knows of the rotor at the next instant, after the control of each
    // tick.
    std::function<void(drive_t &, const sample_t &)> estimate;
    // What the power stage does in place of the drive's demand of this tick.
    std::function<drive_out_t(const Tick &)> power_stage;
    // Who commands each tick in place of the script, whose command then only judges the run; none:
    // the script goes on to command.
    std::function<std::optional<drive_command_t>()> commander;
};

// What the drive takes for a parameter of the motor at the end of a run, beside what the motor has.
struct Parameter {
    const char *name; // with its unit
    double configured;
    double estimated;
    double actual;
};

struct RunResult {
    std::vector<Parameter> parameters;
    MetricValues metrics;
    Saturations saturations; // over the evaluation, while running
    std::vector<FoundFault> faults;
    std::vector<std::string> notes; // what the drive did by itself
    int64_t ticks = 0;
    int64_t zero = 0;                             // the tick of t = 0
    double period_s = 0;                          // of a tick
    drive_state_t state_final = DRIVE_STATE_INIT; // after the last tick
    bool gates_enabled_final = false;             // whether the power stage still switches then

    // When a fault was found, in the time of the scenario's files.
    double time_s(const fault_t &fault) const
    {
        return static_cast<double>(int64_t{fault.tick} - zero) * period_s;
    }
};

} // namespace nf
