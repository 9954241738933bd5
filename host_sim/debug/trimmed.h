/* SPDX-License-Identifier: MIT */
// A line's words have blanks around them.
#pragma once

#include <string>

namespace nf::debug
{

inline std::string trimmed(const std::string &text)
{
    constexpr const char *BLANKS = " \t\r\n\v\f";
    const std::size_t first = text.find_first_not_of(BLANKS);
    return first == std::string::npos
               ? ""
               : text.substr(first, text.find_last_not_of(BLANKS) - first + 1);
}

} // namespace nf::debug
