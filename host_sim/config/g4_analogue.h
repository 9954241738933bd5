/* SPDX-License-Identifier: MIT */
// The analogue side of a board: shunts, amplifiers, comparators and converters.
#pragma once

#include "g4_pin_book.h"

namespace nf
{

// Shunts, amplifiers, bus, temperature and throttle. Throws ConfigError for pins that cannot do it.
void add_g4_inputs(G4PinBook &book);

// Comparators at the shunts. Throws ConfigError for a shunt that reaches none.
void add_g4_comparators(G4PinBook &book);

// Which converter samples what, once all pins have their uses: an amplifier's output pin that is
// used for something else leaves the path in the chip. Throws ConfigError for inputs that the
// converters cannot sample together.
void assign_g4_converters(G4PinBook &book);

} // namespace nf
