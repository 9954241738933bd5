/* SPDX-License-Identifier: MIT */
// A recording, run again.
#pragma once

#include "found_fault.h"
#include "recording.h"

#include <optional>
#include <string>

namespace nf::replay
{

// Where the drive departs from what was recorded: "tick 4711: out.compare.phase[1], recorded 4250,
// computed 4251".
struct Difference {
    int64_t tick; // of the run
    std::string signal;
    int64_t recorded;
    int64_t computed;
};

struct Result {
    std::optional<Difference> difference; // the first
    uint32_t end_hash;                    // of the state after the last frame
    FoundFault fault;                     // then
    drive_state_t state;
    double speed_rpm; // the drive's estimate in the tick before the fault, else at the end
};

// Runs the firmware on each frame and compares each tick's outputs, then the final state.
Result replay(const Recording &recording);

// Of what departs, or else of the fault, or else the last.
int64_t tick_of_interest(const Recording &recording, const Result &result);

// The recording and what came of it, for a person.
std::string summary(const Recording &recording, const Result &result);

} // namespace nf::replay
