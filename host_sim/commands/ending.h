/* SPDX-License-Identifier: MIT */
// How a command of motorsim ends.
#pragma once

#include <stdexcept>

namespace nf::commands
{

// Exit status: what was asked for holds or was done, or it does not hold. program.h has that of
// wrong input.
constexpr int LIMITS_HOLD = 0;
constexpr int LIMIT_BROKEN = 1;

// What is wrong with the options or the files of a command line, in one line.
struct FileError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace nf::commands
