/* SPDX-License-Identifier: MIT */
// The motor file that an identification leaves behind.
#pragma once

#include "settings.h"

#include <string>

namespace nf
{

// The text of a motor file, TOML, that load_motor() and load_parts() read back. `head` stands above
// it as a comment; it may have several lines, and a control character in it becomes '?'. Of the
// optional keys those at their default are left out, and [measured] if nothing of it is left.
//
// Numbers are rounded: a value to what its bar allows (bars.h), a bar to two digits, a condition of
// the measurement to four. A value without a bar, as those of the name plate, is exact. Behind a
// value with a bar stands the bar as a comment.
//
// Throws ConfigError with one line "identified motor: KEY = VALUE: …; allowed: RANGE" for a value
// outside the range of its key: no loader would take the file.
std::string measured_motor_file(const MotorSettings &motor, const MeasuredSettings &measured,
                                const std::string &head);

} // namespace nf
