/* SPDX-License-Identifier: MIT */
// The firmware's numbers of RUN without current regulators.
#pragma once

#include "bases.h"

namespace nf
{

// The lowest speed of the voltage drive is at least so many hand-over speeds: it gives back at 3/4
// of it, which has to be before the observer does.
constexpr double ABOVE_HANDOVER = 1.5;

voltage_drive_cfg_t make_voltage_drive(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b);

} // namespace nf
