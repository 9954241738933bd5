/* SPDX-License-Identifier: MIT */
// The nearest known name to a misspelt one.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace nf
{

// The name of `known` that `wrong` most likely meant, or "". Of names with a dot, what
// follows the dot counts most, so that a key in the wrong table is found.
std::string nearest(const std::string &wrong, const std::vector<std::string> &known);

// All that it may have meant, the likeliest first, at most `count`.
std::vector<std::string> nearest(const std::string &wrong, const std::vector<std::string> &known,
                                 std::size_t count);

// The same, and where it can have meant none: the nearest, however far they are. None for what is
// too long to be a name.
std::vector<std::string> nearest_at_all(const std::string &wrong,
                                        const std::vector<std::string> &known, std::size_t count);

} // namespace nf
