/* SPDX-License-Identifier: MIT */
// What has to hold of a drive, whatever it is told: the ranges of the proof, and what its header
// promises.
#pragma once

extern "C" {
#include "drive.h"
}

namespace fuzz
{

// Ends the program with a line when a configuration that was accepted is outside the ranges that
// the proof is for.
void configuration_holds(const drive_cfg_t &cfg);

// One tick. Ends the program with a line when the state is outside the ranges of the proof, a
// compare value outside the period, or the gates are on where they must not be.
void step_holds(drive_t &drive, const drive_in_t &in, drive_out_t &out);

// After a tick that began in `before`.
void tick_holds(drive_state_t before, const drive_t &drive, const drive_in_t &in,
                const drive_out_t &out);

} // namespace fuzz
