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

// Per unit, as the drive has it.
struct Measured {
    sample_t sample;
    dq_t along_rotor;  // turned with θ̂
    dq_t along_vector; // turned with the angle of the imposed vector
};

// Of the tick that has ended.
Measured measured(const Tick &tick);

// The currents along the rotor, turned with the θ̂ that the drive had before it went on by its
// speed: where nobody has kept the tick.
dq_t measured_current(const Simulation &sim);

} // namespace nf
