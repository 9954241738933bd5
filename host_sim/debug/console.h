/* SPDX-License-Identifier: MIT */
// The dialogue of a session with whoever gives the commands.
#pragma once

#include "line_reader.h"
#include "session.h"

#include <cstdio>

namespace nf::debug
{

// Until `quit` or the end of the input. Answers go to `out`; refusals too when unattended, so that
// they stand at their command. False when one was refused and nobody was there to see it.
bool converse(Session &session, LineReader &reader, std::FILE *out);

} // namespace nf::debug
