/* SPDX-License-Identifier: MIT */
// The command line of `motorsim replay`.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct ReplayArguments {
    std::string file;
    bool debug = false;
    std::string script;
};

void describe(CLI::App &command, ReplayArguments &arguments);

int replay(const ReplayArguments &arguments);

} // namespace nf::commands
