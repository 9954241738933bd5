/* SPDX-License-Identifier: MIT */
// The pins of sensors of the shaft: Hall sensors, an incremental encoder, an absolute one.
#pragma once

#include "g4_pin_book.h"

namespace nf
{

// Throws ConfigError for pins that cannot do it.
void add_g4_shaft(G4PinBook &book);

// Timer 3 or 4 whose channels 1 to 3 the Hall sensors have, in any order, so that it takes the time
// of their edges. 0: there is none, or an encoder at other pins has it.
int g4_hall_timer(const HalSettings &hal);

} // namespace nf
