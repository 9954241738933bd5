// A drive as it was in the field, and what it was told from there on.
#pragma once

#include "config/per_unit.h"

extern "C" {
#include "drive.h"
}

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
};

} // namespace nf
