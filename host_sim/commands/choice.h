/* SPDX-License-Identifier: MIT */
// What is simulated: the options that several commands have.
#pragma once

#include "config.h"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct Choice {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string motor;
    std::string board;

    // --motor and --board are short for --set.
    Config load() const;
};

void describe(CLI::App &command, Choice &arguments);

// Some of its options alone.
void describe_with(CLI::App &command, std::vector<std::string> &with);
void describe_set(CLI::App &command, std::vector<std::string> &set);
void describe_board(CLI::App &command, std::string &board, const char *help);

} // namespace nf::commands
