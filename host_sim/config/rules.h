/* SPDX-License-Identifier: MIT */
// What a tuning leaves open is filled in by rules, the same for every motor and board: docs/tuning_rules.md.
#pragma once

#include "per_unit.h"

#include <cmath>
#include <map>
#include <string>

namespace nf
{

// Within what a rule's value has to stay, by key: what the firmware's numbers hold.
struct RuleRange {
    double least = 0;
    double most = HUGE_VAL;
};
using RuleRanges = std::map<std::string, RuleRange>;

// The tuning with what it leaves open filled in.
TuningSettings by_rules(const TuningSettings &as_written, const MotorSettings &motor,
                        const BoardSettings &board, const ModelScales &model,
                        const RuleRanges &ranges = {});

// The key of the motor or board file that a rule's value follows from most, or null where `key` is written or has no rule.
const char *rule_source(const std::string &key, const TuningSettings &as_written);

// The estimate follows a ramp of speed with this delay, T·κ_p/κ. None with the published law, and with a sensor.
double estimate_lag_s(const TuningSettings &tuning, double period_s);

// The vector that dead time and device drop take off the voltage: its first harmonic is 4/3 of what a leg loses.
double leg_loss_v(const BoardSettings &board, double dead_time_s, double device_drop_v);

} // namespace nf
