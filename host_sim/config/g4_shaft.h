/* SPDX-License-Identifier: MIT */
// The pins of sensors of the shaft: Hall sensors, an incremental encoder, an absolute one.
#pragma once

#include "g4_pin_book.h"

namespace nf
{

// Throws ConfigError for pins that cannot do it.
void add_g4_shaft(G4PinBook &book);

} // namespace nf
