/* SPDX-License-Identifier: MIT */
// What may come next on a command line: for a shell that completes it, and for one that is
// misspelt.
#ifndef NF_COMPLETION_H
#define NF_COMPLETION_H

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace nf
{

/// Names of the type of an option's or argument's value, as help shows it. What has one of these is
// completed with the names / that the programs know.
inline constexpr const char *A_MOTOR = "MOTOR";
inline constexpr const char *A_BOARD = "BOARD";
inline constexpr const char *A_TUNING = "TUNING";
inline constexpr const char *A_SCENARIO = "SCENARIO";
inline constexpr const char *AN_IMPERFECTION = "IMPERFECTION";
inline constexpr const char *A_SETTING = "SECTION.KEY=VALUE";

/// What the last of `words`, those behind the program's name, can be completed to: commands,
// options, names; whole words, in / the order of help. None where a file or a free value is
// expected. The last word may be empty.
std::vector<std::string> completions(const CLI::App &app, const std::vector<std::string> &words);

/// The command or option that `wrong`, which `app` did not expect when it parsed, most likely
// meant; "" for none.
std::string nearest_word(const CLI::App &app, const std::string &wrong);

/// The argument in front of the words to complete, as a shell asks for it.
inline constexpr const char *ASK_COMPLETIONS = "--complete";

/// What a shell, bash or zsh, has to read so that it asks the program `name` for completions.
std::string completion_script(const std::string &shell, const std::string &name);

} // namespace nf

#endif
