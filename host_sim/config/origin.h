/* SPDX-License-Identifier: MIT */
// Where a setting comes from, and the error that names it.
#pragma once

#include <stdexcept>
#include <string>

namespace nf
{

// Who chose a value, from what serves every drive to what somebody wrote for this one. The files of
// the data folder are by kind; a file elsewhere and an option are the user's own.
enum class Author {
    tuning,
    imperfection,
    board,
    scenario,
    motor,
    user
};

// A line of a file. Line 0 means a place without lines: the whole file, or an option such as --set.
struct Origin {
    std::string file; // as it is shown to the user
    unsigned line = 0;
    Author author = Author::user;

    std::string text() const; // "FILE:LINE" or "FILE"
};

// A wrong file or override. what() is the complete line for the user, without a line feed:
//     FILE:LINE: KEY = VALUE: what is wrong; allowed: RANGE
struct ConfigError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Throws the ConfigError of that form. An empty value leaves out "= VALUE", an empty `allowed` the
// end. It is readable() and stays one line; a caller shortens what a user wrote.
[[noreturn]] void fail(const Origin &origin, const std::string &key, const std::string &value,
                       const std::string &problem, const std::string &allowed);

} // namespace nf
