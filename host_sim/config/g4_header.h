/* SPDX-License-Identifier: MIT */
// The part of hal_config.h that only hal/stm32g4 reads: pins, sequences and codes of its registers.
#pragma once

#include "configuration.h"

#include <string>

namespace nf
{

// A chip of hal/stm32g4. Throws ConfigError for a board that it cannot serve.
std::string g4_header(const Config &config);

// hal_memory.ld, which the linker script of hal/stm32g4 includes: the memories of the chip without
// the pages of the store. Throws likewise.
std::string g4_memory(const Config &config);

// What a timer of the chip makes of a dead time, in ticks: the code of the shortest one that is as
// long. RM0440 28.6.20 (DTG): steps of 1 tick up to 127, of 2 up to 254, of 8 up to 504, then of 16
// up to 1008.
unsigned g4_dead_time_code(double ticks);

// The code of the shortest sampling time of at least so long, RM0440 21.7.6 (SMP): 2.5, 6.5, 12.5,
// 24.5 or 47.5 cycles of 42.5 MHz.
unsigned g4_sampling_code(double ns);

} // namespace nf
