/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the speed loop and of the position loop.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

speed_loop_cfg_t make_speed_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                 const Model &m, const Bases &b);

position_loop_cfg_t make_position_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b);

} // namespace nf
