/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the phase compensator.
#pragma once

#include "bases.h"

namespace nf
{

phase_compensator_cfg_t make_compensator(const MotorSettings &motor, const TuningSettings &tuning,
                                         const Bases &b);

} // namespace nf
