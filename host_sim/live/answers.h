/* SPDX-License-Identifier: MIT */
// How a line that a person has typed for a board ends.
#pragma once

#include "commands.h"

#include <string>

namespace nf::live
{

inline debug::Answer done(const std::string &text = "")
{
    return {debug::Outcome::done, text};
}

inline debug::Answer refused(const std::string &why)
{
    return {debug::Outcome::refused, why};
}

// Of the board: empty when it is done.
inline debug::Answer of_verdict(const std::string &why)
{
    return why.empty() ? done("ok") : refused("the board refuses: " + why);
}

} // namespace nf::live
