/* SPDX-License-Identifier: MIT */
// The sessions that the tab Step can open; each is NULL when there is none.
#pragma once

#include "session.h"

namespace nf::web
{

// Of the machine that is played with: its recent past, and on from there.
namespace play_session
{
debug::Session *stepper();
}

// Of the recording that was opened last.
namespace replay_session
{
debug::Session *stepper();
}

} // namespace nf::web
