/* SPDX-License-Identifier: MIT */
// The firmware's numbers of the limits that end in a fault at once.
#pragma once

#include "bases.h"

namespace nf
{

protection_cfg_t make_protection(const BoardSettings &board, const Bases &b);

} // namespace nf
