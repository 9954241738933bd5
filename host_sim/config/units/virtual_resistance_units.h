/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the virtual resistance.
#pragma once

#include "bases.h"

namespace nf
{

virtual_resistance_cfg_t make_virtual_resistance(const TuningSettings &tuning, const Bases &b);

} // namespace nf
