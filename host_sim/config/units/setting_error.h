/* SPDX-License-Identifier: MIT */
// What is said of a setting that the firmware has no number for.
#pragma once

#include <stdexcept>
#include <string>

namespace nf
{

// Up to where a setting can be turned into the firmware's numbers, the others being as they are.
struct SettingLimit {
    bool at_most; // else at least
    double value; // in the setting's unit
};

// A setting that cannot be turned into the firmware's numbers. `key` is the one to change.
struct SettingError : std::runtime_error {
    SettingError(const char *key_, double value_, SettingLimit limit_, const char *reason_);
    std::string key;
    double value;
    SettingLimit limit;
    std::string reason;
};

} // namespace nf
