// Where a setting comes from, and the error that names it.
#pragma once

#include <stdexcept>
#include <string>

namespace nf {

// A line of a file, or an override of the command line (`file` empty).
struct Origin {
    std::string file; // as it is shown to the user
    unsigned line = 0;

    std::string text() const; // "FILE:LINE" or "--set"
};

// A wrong file or override. what() is the complete line for the user, without a line feed:
//     FILE:LINE: KEY = VALUE: what is wrong; allowed: RANGE
struct ConfigError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace nf
