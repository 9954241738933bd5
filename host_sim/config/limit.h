/* SPDX-License-Identifier: MIT */
// The limit of a value as a text. What is written is allowed itself: a person tries it next.
#pragma once

#include "setting_error.h"

#include <string>

namespace nf
{

// With so many digits, rounded to where it is still allowed.
double rounded(const SettingLimit &limit, int digits = 4);

// Likewise, as a number without a unit.
std::string limit_number(const SettingLimit &limit, int digits = 4);

// "-0.5 to 7", each end allowed.
std::string limits_text(double lowest, double highest, int digits = 4);

} // namespace nf
