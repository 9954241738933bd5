/* SPDX-License-Identifier: MIT */
// One tick of the drive, computed again.
//
// The instrumented drive computes the tick from the state before it. It is made of the sources of
// the drive; each call of a control module passes a seam, where the module's twin in double
// precision computes the same from the same inputs. So a module that computes wrongly shows by its
// name. What is not a control module's shows too: each word that the tick has left in state and
// outputs is compared with the same word of the tick computed again.
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

// Steps `drive` as drive_step() does. Returns what the control modules have computed, in the order
// of their calls. A tolerance is what the roundings of one call can make, each at its worst.
std::vector<Comparison> step_beside_twins(drive_t &drive, const drive_in_t &in, drive_out_t &out,
                                          const Bases &bases);

// built: the configuration as it was made, which the drive's copy should equal.
std::vector<Comparison> diff_tick(const drive_t &before, const Tick &tick,
                                  const drive_cfg_t &built);

// NULL when all are within their roundings.
const Comparison *first_departure(const std::vector<Comparison> &rows);

// A table, and the verdict as the last line.
std::string diff_text(const std::vector<Comparison> &rows);

} // namespace nf::debug
