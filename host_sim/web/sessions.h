/* SPDX-License-Identifier: MIT */
// The sessions that the tab Step can open; each is NULL when there is none.
#pragma once

#include "session.h"

namespace nf::web
{

// Of the machine that is played with: its recent past, and on from there.
debug::Session *play_stepper();

// Of the recording that was opened last.
debug::Session *replay_stepper();

} // namespace nf::web
