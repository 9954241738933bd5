/* SPDX-License-Identifier: MIT */
// The command line of `motorsim debug`.
#pragma once

#include "choice.h"

#include <string>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct DebugArguments : Choice {
    std::string script;
};

void describe(CLI::App &command, DebugArguments &arguments);

int debug(const DebugArguments &arguments);

} // namespace nf::commands
