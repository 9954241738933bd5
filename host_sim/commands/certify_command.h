/* SPDX-License-Identifier: MIT */
// The command line of `motorsim certify`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct CertifyArguments {
    std::string motor;
    std::string board;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::vector<std::string> tunings;
    int runs = 200;
    uint32_t seed = 1;
    std::string output;
    std::string json;
    bool overwrite = false;
};

void describe(CLI::App &command, CertifyArguments &arguments);

int certify(const CertifyArguments &arguments);

} // namespace nf::commands
