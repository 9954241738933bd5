/* SPDX-License-Identifier: MIT */
// The recording of a run whose inputs are known: what a board would send that has a ring of any
// size.
#pragma once

#include "recorded_run.h"

#include <cstdint>
#include <functional>
#include <string>

extern "C" {
#include "recorder_dump.h"
}

namespace nf::replay
{

struct RunRecording {
    std::string text; // lines, as a board sends them
    int64_t first;    // tick of the run
    int64_t ticks;
    bool ends_in_fault;
};

// Up to POST_TICKS behind the run's last fault, else to its end. It begins with the second tick, or
// later: a recording holds two configurations at most, and is not longer than read_file() takes. Of
// two ticks at least. It takes some tenths of a second: `meanwhile` is called every few
// milliseconds.
RunRecording recording_of(const RecordedRun &run, const recorder_about_t &about,
                          const std::function<void()> &meanwhile);

} // namespace nf::replay
