/* SPDX-License-Identifier: MIT */
// What the drive has measured in a tick. It keeps none of it: it is computed here once more, from
// the frame and from what the drive believed before the tick, by the firmware's own functions.
#pragma once

#include "tick.h"

extern "C" {
#include "instant.h"
}

namespace nf
{

// Of the tick that has ended. The currents in both frames count where drive_is_controlled().
instant_t measured(const Tick &tick);

sample_t measured_sample(const Simulation &sim);
// In the frame of the current control, as drive.control.current_ref.
dq_t measured_current(const Simulation &sim);

} // namespace nf
