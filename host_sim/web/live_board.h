/* SPDX-License-Identifier: MIT */
// The board that the page follows.
#pragma once

#include "board_commands.h"

namespace nf::web::live_board
{

// Throws where none is connected.
live::BoardCommands &commands();

} // namespace nf::web::live_board
