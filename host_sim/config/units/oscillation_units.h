/* SPDX-License-Identifier: MIT */
// The firmware's numbers of a swing of the speed loop that is to be found.
#pragma once

#include "bases.h"

namespace nf
{

oscillation_cfg_t make_oscillation(const MotorSettings &motor, const TuningSettings &tuning,
                                   const Bases &b);

} // namespace nf
