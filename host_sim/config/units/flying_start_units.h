/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the pulses that look for a turning rotor, and how long they take.
#pragma once

#include "bases.h"
#include "motor_model.h"

namespace nf
{

flying_start_cfg_t make_flying_start(const MotorSettings &motor, const BoardSettings &board,
                                     const Model &m, const Bases &b);

// Seconds that looking takes for a rotor that rests.
double flying_start_time_s(const MotorSettings &motor, const Model &m, const Bases &b);

} // namespace nf
