/* SPDX-License-Identifier: MIT */
// Which states the firmware may be put into from outside: by a recording, by a person.
#pragma once

#include <string>

extern "C" {
#include "drive.h"
}

namespace nf
{

// drive_step never leaves the ranges of state.def, and is proven only within them. Empty, or one
// line: the first word that is wrong, what it is and what is allowed. Looks at no word as what it
// may not be.
std::string state_problem(const drive_t &state, const drive_cfg_t &cfg);

} // namespace nf
