/* SPDX-License-Identifier: MIT */
// What the flight recorder sends, taken apart: configuration, the state before the first frame, the
// frames.
#pragma once

#include "recorded_run.h"

extern "C" {
#include "fault_log.h"
#include "recorder_dump.h"
}

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace nf::replay
{

// The reason of a reset: "watchdog after exception 3".
std::string reset_text(hal_reset_t reset);

// What is wrong with a file, in one line.
struct RecordingError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Outputs of a packed recording that are not those that the drive had: of which ticks of the run,
// and their CRCs.
struct Departure {
    int64_t first;
    int64_t last;
    uint32_t recorded;
    uint32_t computed;
};

struct Recording {
    recorder_header_t header;
    // Of a packed recording the outputs are computed: the recording has their CRCs.
    RecordedRun run;
    std::optional<Departure> departure; // the first
    std::string
        remark; // what a person should know of the file beside it, in one line; may be empty

    std::string name() const;  // of motor, board, tuning
    std::string build() const; // of the image, in hex; empty for the simulator
    int64_t last() const       // tick of the run
    {
        return run.first() + static_cast<int64_t>(run.frames.size()) - 1;
    }
    // "ends with a reset: watchdog"; empty where the last reset is not known.
    std::string reset() const;
    // Of the end; none without a FAULT, and none if a reset has cut the recording: replay() finds
    // it.
    fault_t fault() const;
};

// The scales of the firmware's integers. `about`: each value within its range.
Bases bases_of(const recorder_about_t &about, const drive_cfg_t &cfg);

// Refuses scales that no motor and board have. Throws RecordingError.
void check_scales(const recorder_about_t &about);

// Words of a recording. Throws RecordingError, and nothing else, for whatever they are.
Recording parse(const std::vector<uint32_t> &words);

} // namespace nf::replay
