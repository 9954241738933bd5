/* SPDX-License-Identifier: MIT */
// What a user gave, as a message repeats it: short, in one line, and UTF-8 whatever it was.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nf
{

constexpr std::size_t READABLE = 60;       // characters of a word
constexpr std::size_t READABLE_PATH = 256; // of a path: the name of the file is at its end
// Of a whole line: far more than any message of ours has, and not the pages of a wrong file.
constexpr std::size_t READABLE_LINE = 4000;

// At most so many characters of a text, and then "…". A control character is shown as \n or \x1b,
// a byte that is not UTF-8 as \xff.
std::string readable(std::string_view text, std::size_t most = READABLE);

// What is wrong with a text that is not UTF-8, with the text; empty where it is.
std::string utf8_problem(std::string_view text);

} // namespace nf
