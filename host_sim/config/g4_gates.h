/* SPDX-License-Identifier: MIT */
// The gates of a board: six outputs of timer 1, or three with an enable each.
#pragma once

#include "g4_pin_book.h"

namespace nf
{

// Throws ConfigError for pins that the timer's three channels do not reach.
void resolve_g4_gates(G4PinBook &book);

} // namespace nf
