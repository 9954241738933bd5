/* SPDX-License-Identifier: MIT */
// Runs a configuration from the start of its prelude to its end and judges it.
//
// The first tick is at t = −prelude_s, with the rotor as the scenario says and the drive in INIT.
// RUN is requested as soon as the drive is READY (operator.h); the prelude has to be long enough
// for that. Steps of command and load, requests and faults act from the tick nearest to their time,
// before t = 0 as well.
#pragma once

#include "run_result.h"

#include <optional>
#include <string>
#include <vector>

namespace nf
{

// Throws ConfigError, and what the sink throws.
RunResult run_scenario(const Config &config, const RunOptions &options = {});
// The motor, the board and the script of one configuration, and a drive that believes another one,
// of a board with the same timer and converters. Figures are shares of what the drive takes the
// motor to be rated for.
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
