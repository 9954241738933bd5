/* SPDX-License-Identifier: MIT */
// The firmware's numbers of torque control.
#pragma once

#include "bases.h"

namespace nf
{

// speed_loop: made already.
torque_loop_cfg_t make_torque_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                   const speed_loop_cfg_t &speed_loop, const Bases &b);

} // namespace nf
