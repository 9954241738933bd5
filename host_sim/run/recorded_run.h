/* SPDX-License-Identifier: MIT */
// A drive as it was in the field, what it was told from there on, and what it answered.
#pragma once

#include "per_unit.h"

extern "C" {
#include "drive.h"
}

#include <cstdint>
#include <vector>

namespace nf
{

struct DriveImage {
    drive_cfg_t cfg;
    drive_t state; // its pointer to a configuration means nothing
    Bases bases;
};

struct RecordedRun {
    DriveImage image;
    std::vector<drive_in_t> frames;
    std::vector<drive_out_t> outputs; // one for each frame

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
