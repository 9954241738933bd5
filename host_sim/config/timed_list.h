/* SPDX-License-Identifier: MIT */
// The lists of a scenario that step a quantity: [[scenario.command]], [[scenario.load]].
#pragma once

#include "configuration.h"
#include "document.h"

#include <string>
#include <vector>

namespace nf
{

// A value that an entry can hold beside its time.
struct EntryValue {
    const char *list;
    const char *key;
    const char *unit;
    double largest;               // either sign
    double MotorSettings::*rated; // what it is a percentage of; null: a value in SI
    const char *help;

    std::string name() const;    // "scenario.command.speed_rpm"
    std::string allowed() const; // "-200000 to 200000 rpm"
};
const std::vector<EntryValue> &entry_values();

// The lists in SI; what they state as a share is one of this motor's ratings. Both throw
// ConfigError for whatever a list holds that it must not.
std::vector<TimedValue> read_commands(const Node &list, DriveMode mode, const MotorSettings &motor);
std::vector<TimedValue> read_loads(const Node &list, const MotorSettings &motor);

// What an entry of a checked list of speeds holds.
const EntryValue &speed_value(const Node &entry);

} // namespace nf
