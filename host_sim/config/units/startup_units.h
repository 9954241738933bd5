/* SPDX-License-Identifier: MIT */
// The firmware's numbers of what happens below the speed at which the back-EMF tells the angle: one
// rule for every motor, from its file.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

startup_cfg_t make_startup(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                           const Bases &b);

// How long the start-up of a rotor that rests when it is measured takes from the run request to
// standstill under control, in seconds. One that swings is measured again.
double startup_time(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &as_written);

} // namespace nf
