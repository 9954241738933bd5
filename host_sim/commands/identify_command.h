/* SPDX-License-Identifier: MIT */
// The command line of `motorsim identify`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct IdentifyArguments {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string motor;
    std::string board;
    std::string records;
    std::string output;
    std::string log;
    std::string json;
    bool overwrite = false;
    double temperature_c = 25;
};

void describe(CLI::App &command, IdentifyArguments &arguments);

int identify(const IdentifyArguments &arguments);

} // namespace nf::commands
