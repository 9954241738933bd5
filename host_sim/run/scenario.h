/* SPDX-License-Identifier: MIT */
// Runs a configuration from the start of its prelude to its end and judges it.
//
// The first tick is at t = −prelude_s, with the rotor as the scenario says and the drive in INIT. RUN
// is requested as soon as the drive is READY (operator.h); the prelude has to be long enough for that.
// Steps of command and load, requests and faults act from the tick nearest to their time, before t = 0
// as well.
#pragma once

#include "found_fault.h"
#include "metrics.h"
#include "saturation.h"
#include "tick.h"

#include <functional>
#include <string>
#include <vector>

namespace nf
{

struct RunOptions {
    TickSink *sink = nullptr;             // sees every tick
    std::function<void(double)> progress; // share of the run that is done, now and then
    // Writes over what the drive knows of the rotor at the next instant, after the control of each tick.
    std::function<void(drive_t &)> estimate;
    // What the power stage does in place of the drive's demand of this tick.
    std::function<drive_out_t(const Tick &)> power_stage;
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

// Throws ConfigError, and what the sink throws.
RunResult run_scenario(const Config &config, const RunOptions &options = {});
// The motor, the board and the script of one configuration, and a drive that believes another one, of a board with the same
// timer and converters. Figures are shares of what the drive takes the motor to be rated for.
RunResult run_scenario(const Config &real, const Config &believed, const RunOptions &options = {});

constexpr const char *SATURATION_INTERNAL_COUNT = "saturation_internal_count";

// A figure of the run by its name: those of metric_fields() and the one above.
std::optional<double> figure(const RunResult &result, const std::string &metric);

// As in a scenario's file.
const char *flag_text(bool value);

// A limit that does not hold. `value` is empty when the figure is (metrics.h).
struct Violation {
    std::string metric;
    std::string value;
    std::string limit;

    std::string text() const; // one line
};

// The limits of the configuration's selection of imperfection sets; none: an empty list.
std::vector<Violation> violations(const Config &config, const RunResult &result);

// The limits themselves, or NULL.
const AcceptLimits *limits_of(const Config &config);

} // namespace nf
