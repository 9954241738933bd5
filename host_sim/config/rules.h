/* SPDX-License-Identifier: MIT */
// What a tuning leaves open is filled in by rules, the same for every motor and board:
// docs/tuning_rules.md.
#pragma once

#include "settings.h"

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

// The key of the motor or board file that a rule's value follows from most, or null where `key` is
// written or has no rule.
const char *rule_source(const std::string &key, const TuningSettings &as_written);

} // namespace nf
