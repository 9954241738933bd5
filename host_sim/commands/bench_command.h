/* SPDX-License-Identifier: MIT */
// The command line of `motorsim bench`.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct BenchArguments {
    std::string scenario = "s1";
    int runs = 30;
    std::string json;
};

void describe(CLI::App &command, BenchArguments &arguments);

int bench(const BenchArguments &arguments);

} // namespace nf::commands
