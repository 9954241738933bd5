/* SPDX-License-Identifier: MIT */
// The simulator's command line as a function: of the program, and of a page that has no process to start.
#pragma once

namespace nf
{

// Prints to stdout and stderr; the exit status. `argv` as of main().
int motorsim(int argc, char **argv);

} // namespace nf
