/* SPDX-License-Identifier: MIT */
// The part of hal_config.h for inputs and for sensors of the shaft.
#pragma once

#include "configuration.h"
#include "g4_board.h"

#include <string>

namespace nf
{

std::string g4_input_lines(const Config &config, const G4Board &board);

// What they add to the clocks of RCC's registers: " | RCC_AHB1ENR_DMA1".
struct G4InputClocks {
    std::string ahb1;
    std::string apb1;
    std::string apb2;
};

G4InputClocks g4_input_clocks(const G4Board &board);

} // namespace nf
