/* SPDX-License-Identifier: MIT */
// How far a command is, on a terminal.
#pragma once

#include <functional>

namespace nf::commands
{

// A line on a terminal that shows how far a run is; nothing where stderr is no terminal.
std::function<void(double)> progress_line();

// Of so many runs that they take a while; where stderr is no terminal, a line for each quarter.
std::function<void(double)> progress_of_runs(int runs);

} // namespace nf::commands
