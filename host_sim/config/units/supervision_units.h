/* SPDX-License-Identifier: MIT */
// The firmware's numbers of what supervision allows.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

// period_s: between two looks of the checks that run in turn.
supervision_cfg_t make_supervision(const MotorSettings &motor, const BoardSettings &board,
                                   const TuningSettings &tuning, const Model &m, double period_s,
                                   const Bases &b);

} // namespace nf
