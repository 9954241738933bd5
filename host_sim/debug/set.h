/* SPDX-License-Identifier: MIT */
// What a person changes in a run: state, configuration, converter counts, commands.
#pragma once

#include "timeline.h"

#include <string>

namespace nf::debug
{

enum class Span {
    once,
    for_ever
};

// "NAME = VALUE" or "NAME.raw = VALUE"; from the present tick on. The answer is a line. Throws
// std::runtime_error for what cannot be set, or not so.
std::string set_signal(Timeline &timeline, const std::string &assignment, Span span);

} // namespace nf::debug
