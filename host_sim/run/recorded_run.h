/* SPDX-License-Identifier: MIT */
// A drive as it was in the field, what it was told from there on, and what it answered.
#pragma once

#include "bases.h"

extern "C" {
#include "drive.h"
}

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nf
{

struct DriveImage {
    drive_cfg_t cfg;
    drive_t state; // its pointer to a configuration means nothing
    Bases bases;
};

// The drive takes over another configuration before this frame.
struct ConfigChange {
    std::size_t frame;
    drive_cfg_t cfg;
};

struct RecordedRun {
    DriveImage image; // before the first frame, and before a change that comes there
    std::vector<drive_in_t> frames;
    std::vector<drive_out_t> outputs;  // one for each frame
    std::vector<ConfigChange> changes; // in the order of their frames

    int64_t first() const
    {
        return image.state.tick;
    }
    // The drive's count wraps, a run's does not. For what is within 2^31 ticks of the first.
    int64_t tick_of(uint32_t count) const
    {
        return first() + static_cast<int32_t>(count - image.state.tick);
    }
};

} // namespace nf
