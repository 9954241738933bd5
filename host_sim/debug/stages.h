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
    bool shown_with = true;                 // while the flag is not 0, or while it is
    std::vector<drive_state_t> states = {}; // only in these; empty: in each
};

const std::vector<Stage> &all_stages();

std::string stages_text(const Tick &tick);

} // namespace nf::debug
