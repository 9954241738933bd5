/* SPDX-License-Identifier: MIT */
// Error bars: how far a value of a motor file may be wrong, and with how many digits it is worth
// writing.
#pragma once

#include "settings.h"

#include <string>

namespace nf
{

// The error bar of a standard deviation and a systematic bound, both in one unit: 95 % of values
// lie within.
double error_bar(double std, double bound);

// The error bar of a value of [motor] or [measured] in the value's own unit, 0 or more; 0 where
// none is stated, or for any other key. Of a standard deviation and a bound it is error_bar(). The
// rated torque has the bar of φ, of which it is made. `key` is "section.key".
double bar_of(const MotorSettings &motor, const MeasuredSettings &measured, const std::string &key);

// A finite number above 0 with two significant digits, as a TOML number: "0.031", "1.0", "12",
// "1.5e-06".
std::string two_digits(double number);

// A finite value as a TOML number, rounded to what its bar allows: the second significant digit of
// the bar is the place of the last one, 2.1253 with a bar of 0.031 is "2.125". At least one
// significant digit is left, so a value within the range of a key stays there: the ends of all
// ranges have one. Without a bar (0) it is written exactly.
std::string within_bar(double value, double bar);

} // namespace nf
