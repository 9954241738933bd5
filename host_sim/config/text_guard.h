/* SPDX-License-Identifier: MIT */
// Refuses text that toml++ does not survive, before it sees it:
//   characters outside ASCII that are in no string or comment reach its __builtin_unreachable(),
//   up to 3.4;
//   dotted keys nest without limit, up to 3.3, and each level costs stack.
// No valid file of ours has either.
#pragma once

#include <string>

namespace nf
{

// Throws ConfigError with the line.
void guard_text(const std::string &name, const std::string &text);

} // namespace nf
