/* SPDX-License-Identifier: MIT */
// What a measurement asks of a motor: said before it begins.
#pragma once

#include "config.h"

namespace nf::identify
{

struct Demands {
    double current_a = 0;         // peak of a phase, while the shaft turns
    double largest_current_a = 0; // the same while it stands
    double speed_rpm = 0;         // of the shaft, with its swings
};

// By the firmware's own rules. plate: as load_plate() has read it. Throws ConfigError where the
// firmware cannot hold the plate with its board.
Demands demands_of(const Config &plate);

} // namespace nf::identify
