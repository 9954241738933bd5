/* SPDX-License-Identifier: MIT */
// From a board file's [hal] to the peripherals of an STM32G4.
#pragma once

#include "configuration.h"
#include "g4_board.h"

namespace nf
{

// Throws ConfigError in the user's terms for pins that cannot do it, that are used twice, and for
// inputs that the two converters cannot sample together. The chip is one of hal/stm32g4.
G4Board resolve_g4_board(const Config &config);

} // namespace nf
