/* SPDX-License-Identifier: MIT */
// The commands of a session.
#pragma once

#include "session.h"

#include <string>
#include <vector>

namespace nf::debug
{

enum class Outcome {
    done,
    refused, // the text says why, in a line
    quit
};

struct Answer {
    Outcome outcome;
    std::string text;
};

// One line of input. Nothing that it may hold ends the session but `quit`.
Answer execute(Session &session, const std::string &line);

// Words that `word`, the last one of a line, may become.
std::vector<std::string> completions(const std::string &line_before, const std::string &word);

} // namespace nf::debug
