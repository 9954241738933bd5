/* SPDX-License-Identifier: MIT */
// The board that the page follows.
#pragma once

#include "calls.h"

#include "board_commands.h"

#include <string>

namespace nf::web::live_board
{

// Throws where none is connected.
live::BoardCommands &commands();

// What the program says to a line: a word and the name of the file that is given. Throws what a
// refusal says.
std::string told(const char *word, const Json &given);

// What an answer says. Throws what a refusal says.
std::string said_or_thrown(const debug::Answer &answer);

} // namespace nf::web::live_board
