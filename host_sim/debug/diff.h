/* SPDX-License-Identifier: MIT */
// One tick of the drive beside its twins in double precision, module by module in the tick's order.
//
// Each module's twin gets what the drive's module was given in this tick: the state before it, and the signals as
// they are in the drive. So a wrong result shows at the module that made it, and the first that departs is the one to
// look at. A tolerance is what the roundings of that module can make of one tick, each at its worst.
#pragma once

#include "config.h"
#include "tick.h"

#include <string>
#include <vector>

namespace nf::debug
{

struct Comparison {
    std::string module;
    std::string quantity;
    std::string unit;
    double drive;
    double reference;
    double tolerance;

    bool departs() const;
};

struct Diff {
    std::vector<Comparison> rows;
    std::string left_out; // what was not compared and why, or empty
};

// built: the configuration as it was made, which the drive's copy should equal.
Diff diff_tick(const drive_t &before, const Tick &tick, const drive_cfg_t &built);

// NULL when all are within their roundings.
const Comparison *first_departure(const Diff &diff);

// A table, and the verdict as the last line.
std::string diff_text(const Diff &diff);

} // namespace nf::debug
