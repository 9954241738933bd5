/* SPDX-License-Identifier: MIT */
// What the command-line programs have in common: how they end and how they write.
#ifndef NF_PROGRAM_H
#define NF_PROGRAM_H

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace nf
{

/// Exit status of wrong usage, a wrong file or a file that cannot be written.
constexpr int BAD_INPUT = 2;

/// Parses the command line of a program with commands. Returns the exit status where that is all
// there is to do: help or / version was asked for, or no command was given or a wrong one, which
// one line on stderr says.
std::optional<int> parse(CLI::App &app, int argc, char **argv);

/// Runs `body`; what it throws ends as one line on stderr behind the program's name, with
// BAD_INPUT. So does a standard / output that did not take all that was printed.
int guarded(const char *program, int (*body)(int, char **), int argc, char **argv);

/// Writes a file, whole or not at all; "-" is standard output. Throws std::runtime_error with the
// file's name and the / system's reason.
void write_text(const std::string &path, const std::string &text);

} // namespace nf

#endif
