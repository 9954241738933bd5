/* SPDX-License-Identifier: MIT */
// The command line of `motorsim live`.
#pragma once

#include "live_run.h"
#include "serve_command.h"

#include <string>

#include <CLI/CLI.hpp>

namespace nf::live
{

struct LiveArguments : LiveOptions {
    std::string port;
    ServeArguments serve; // in place of following a board
    unsigned rate = 0;    // 0: board.baud of --board, else of the default
};

void describe(CLI::App &command, LiveArguments &arguments);

// False as follow(). Throws what is to be said in one line.
bool live(LiveArguments arguments);

} // namespace nf::live
