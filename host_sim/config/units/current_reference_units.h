/* SPDX-License-Identifier: MIT */
// The firmware's numbers of i_d* in RUN, with or without a start-up.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

current_reference_cfg_t make_current_reference(const MotorSettings &motor,
                                               const BoardSettings &board,
                                               const TuningSettings &tuning,
                                               const ModelScales &scales, const Model &m,
                                               const Bases &b);

} // namespace nf
