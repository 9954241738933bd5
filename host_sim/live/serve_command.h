/* SPDX-License-Identifier: MIT */
// The command line of `motorsim live --simulate`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace nf::live
{

// The choice of files is as of `motorsim run`; motor and board are short for `set`.
struct ServeArguments {
    std::string scenario; // empty: nothing is simulated
    std::vector<std::string> with;
    double pace = 1;
    std::string link;
    std::string flash;
};

struct ServeFiles {
    std::string motor;
    std::string board;
    std::vector<std::string> set;
};

void describe(CLI::App &command, ServeArguments &arguments);

// Serves a simulated board until Ctrl-C. Throws what is to be said in one line.
void serve(const ServeArguments &arguments, const ServeFiles &files);

// What is wrong with a name on the command line; empty where nothing is.
std::string not_empty(const std::string &name);

} // namespace nf::live
