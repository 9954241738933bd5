/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the voltages for L_d and L_q, at most a share of the bus so that the
// duty has room.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

// fall_a: by so much the step lowers the current along it. swing_a: by so much the pulse swings the
// current across.
inductance_cfg_t make_inductance(double fall_a, double swing_a, const BoardSettings &board,
                                 const Model &m, const Bases &b);

// Seconds that step and pulse take at most.
double inductance_time_s(const Bases &b);

} // namespace nf
