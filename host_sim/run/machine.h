/* SPDX-License-Identifier: MIT */
// The simulated machine of a configuration.
#pragma once

#include "config.h"

extern "C" {
#include "drive_cfg.h"
#include "plant.h"
}

namespace nf
{

// The motor file times the scales of [plant], what [plant] adds to it, and the board. The timer is
// the one that the drive's compare values are meant for. Throws ConfigError for a value that does
// not go with the others.
plant_cfg_t make_plant_cfg(const Config &config, const drive_cfg_t &drive);

} // namespace nf
