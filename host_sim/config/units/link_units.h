/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the line between the drive and a PC.
#pragma once

#include "bases.h"

namespace nf
{

link_cfg_t make_link(const TuningSettings &tuning, const Bases &b);

} // namespace nf
