/* SPDX-License-Identifier: MIT */
// The digital inputs that command a drive: pulses and a button.
#pragma once

#include "g4_pin_book.h"

namespace nf
{

// Throws ConfigError for a pin that cannot do it.
void add_g4_commands(G4PinBook &book);

} // namespace nf
