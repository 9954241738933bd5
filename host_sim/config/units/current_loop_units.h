/* SPDX-License-Identifier: MIT */
// The firmware's numbers of current control in RUN.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

current_loop_cfg_t make_current_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                     const Model &m, const Bases &b);

} // namespace nf
