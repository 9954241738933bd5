/* SPDX-License-Identifier: MIT */
// How a quantity is spelt on a data sheet, in one spelling.
#pragma once

#include <string>
#include <vector>

namespace nf::sheet
{

// A line of the user that cannot be taken. what() is the complete line, without a line feed.
[[noreturn]] void refuse(const std::string &option, const std::string &typed,
                         const std::string &problem);

// Of a text with blanks and control characters: these as '?', those at the ends and repeated ones
// left out.
std::string tidied(const std::string &text);

// The text with one spelling of each sign and unit that has several. Throws std::runtime_error for
// more than 200 characters.
//   · ⋅ × * → '.'   ² ^2 → 2   Ω → ohm   µ → u   1/min, min⁻¹, U/min → rpm
//   /1000 rpm → /krpm   6-step → six step
//   a mark within the unit goes to the end: "Vrms/krpm" → "V/krpm rms", "A_pk" → "A pk"
std::string one_spelling(const std::string &text);

// The end of `symbol` in `text` from `from` on, or npos. In `symbol` a '.' stands for ".", "-", a
// blank or nothing, and a '/' for "/" or " per ". Upper and lower case are alike, but for an 'm' at
// the beginning: mohm is no Mohm. What stands after it is a blank, a comma, a bracket or the end.
std::size_t end_of_unit(const std::string &symbol, const std::string &text, std::size_t from);

// The words of a text in lower case; what is neither letter, digit nor beyond ASCII is between
// words.
std::vector<std::string> words_of(const std::string &text);

} // namespace nf::sheet
