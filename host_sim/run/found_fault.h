/* SPDX-License-Identifier: MIT */
// A fault with all that the drive knows of it.
#pragma once

#include "bases.h"

extern "C" {
#include "drive.h"
}

#include <optional>

namespace nf
{

struct FoundFault : fault_t {
    std::optional<double> swing_hz; // of OSCILLATION
    const char *advice = "";        // by what the drive knew
};

// The fault that the drive has latched last.
FoundFault found_fault(const drive_t &drive, const Bases &bases);

// Frequency of the last swing that supervision has found since the start, if there was one.
std::optional<double> last_swing_hz(const drive_t &drive, const Bases &bases);

} // namespace nf
