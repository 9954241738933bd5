/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the serial line: a PC, or a person at the console.
#pragma once

#include "bases.h"

namespace nf
{

link_cfg_t make_link(const TuningSettings &tuning, const Bases &b);

console_cfg_t make_console(const TuningSettings &tuning, const Bases &b);

} // namespace nf
