/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the limits that lower the torque.
#pragma once

#include "bases.h"

namespace nf
{

// Least way from board.bus_nominal_v to where the drive acts on a high bus: braking is derated on
// it.
double braking_room_v(const Bases &b);

// period_s: between two looks at the current.
derating_cfg_t make_derating(const MotorSettings &motor, const BoardSettings &board,
                             double period_s, const Bases &b);

} // namespace nf
