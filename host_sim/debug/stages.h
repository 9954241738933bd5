/* SPDX-License-Identifier: MIT */
// Every intermediate of one tick in the order in which the drive computes it.
#pragma once

#include "tick.h"

#include <string>
#include <vector>

namespace nf::debug
{

struct Stage {
    const char *title;
    std::vector<const char *> signals;
    // A word of which it depends whether a tick has this stage; NULL: each has.
    const char *flag = nullptr;
    bool shown_with = true; // while the flag is not 0, or while it is
    // Only in these; empty: in each. A table leaves it out, which gcc allows of what has an
    // initialiser.
    std::vector<drive_state_t> states = {}; // NOLINT(readability-redundant-member-init)
};

const std::vector<Stage> &all_stages();

// Those that this tick has.
std::vector<const Stage *> stages_of(const Tick &tick);

std::string stages_text(const Tick &tick);

} // namespace nf::debug
