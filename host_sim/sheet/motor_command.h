/* SPDX-License-Identifier: MIT */
// The command line of `motorsim motor`.
#pragma once

#include <map>
#include <string>

#include <CLI/CLI.hpp>

namespace nf::sheet
{

struct MotorArguments {
    std::map<std::string, std::string> given; // by option; what was not given is absent
    std::string output;
    bool overwrite = false;
};

void describe(CLI::App &command, MotorArguments &arguments);

// Asks on a terminal for what is missing, and writes the motor file. Throws what is to be said in
// one line.
void write_motor(const MotorArguments &arguments);

} // namespace nf::sheet
