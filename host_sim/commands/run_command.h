/* SPDX-License-Identifier: MIT */
// The command line of `motorsim run`.
#pragma once

#include "choice.h"

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace nf::commands
{

struct RunArguments : Choice {
    std::string estimator;
    std::string trace;
    bool trace_prelude = false;
    std::string json;
    std::string record;
    std::string extremes;
    std::string vcd;
    std::optional<double> vcd_from_s;
    std::optional<double> vcd_to_s;
};

void describe(CLI::App &command, RunArguments &arguments);

int run(const RunArguments &arguments);

} // namespace nf::commands
