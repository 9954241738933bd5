/* SPDX-License-Identifier: MIT */
// Regular expressions (ECMAScript, upper and lower case alike). Only this library includes <regex>:
// each source that does takes two to three seconds more to compile.
#pragma once

#include <string>

namespace nf
{

// `text` with each match replaced; $1 is the first group. Throws std::regex_error, where the
// expression is none.
std::string replace_matches(const std::string &text, const char *expression, const char *instead);

} // namespace nf
