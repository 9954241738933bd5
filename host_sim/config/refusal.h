/* SPDX-License-Identifier: MIT */
// Refusals of values that are wrong only beside others: which of the lines is blamed, and what the
// user can write.
#pragma once

#include "configuration.h"
#include "setting_error.h"

namespace nf
{

// Throws ConfigError for two settings of which one may not exceed the other.
void check_orders(const Config &config);

// Throws the ConfigError of a setting that does not fit the firmware. It names the line that holds
// it or, where a file for every drive holds it, the line of this drive's motor, board or scenario
// that moves the limit most, and then also what can be written instead.
[[noreturn]] void refuse(const Config &config, const SettingError &error);

} // namespace nf
