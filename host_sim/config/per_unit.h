/* SPDX-License-Identifier: MIT */
// From settings in SI units to the firmware's per-unit integers: the one place where this is done,
// for the simulator at run time and for the header that targets compile.
#pragma once

#include "bases.h"
#include "settings.h"

namespace nf
{

// The tuning that acts: settings that are left to the motor (0) are filled in by rule, as far as
// the firmware's numbers hold; with an angle sensor, what finds the angle is off. Throws
// SettingError naming the offending key.
TuningSettings settled_tuning(const MotorSettings &motor, const BoardSettings &board,
                              const TuningSettings &as_written, const ModelScales &scales);

// The firmware's numbers of the tuning that acts. Throws SettingError naming the offending key, or
// logic_error if config_check refuses the result, which no settings within the ranges of the keys
// can bring about.
drive_cfg_t make_drive_cfg(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &as_written, const ModelScales &scales);

} // namespace nf
