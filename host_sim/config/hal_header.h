/* SPDX-License-Identifier: MIT */
// The C header that gives a hardware binding its board.
#pragma once

#include "config.h"

#include <string>

namespace nf
{

// Numbers of [hal] and [board] as macros HAL_..., in counts and ticks. The same files give the
// same text on every machine. Refuses, with file, line and reason, what the hardware cannot do:
// dead time or sampling that do not fit the PWM period, scales that contradict each other, a trip
// level out of the converter's range, a baud rate that the chip does not make, a missing key.
std::string make_hal_header(const Config &config);

// hal_memory.ld, which the linker script of hal/stm32g4 includes: the memories of the board's chip.
// Refuses the same, and a chip that this binding does not serve.
std::string make_hal_memory(const Config &config);

// Its macros of the power stage without their comments, and without any check; empty for a board
// without [hal]. A configuration has to fit them.
std::string hal_facts(const Config &config);

} // namespace nf
