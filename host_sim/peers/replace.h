/* SPDX-License-Identifier: MIT */
// Puts an estimator in the place of the drive's own observer. All else stays the drive's: its
// start-up and hand-over, its measurement of R and L, its compensation of the dead time, its loops,
// ramps and supervision.
//
// After each tick the drive's angle and speed for the next instant are written over. While the
// drive leads the rotor by an imposed current, the estimator follows what the drive knows, as its
// observer does. That observer's network goes on beside it, untrained, with the estimator's speed
// and angle, as with a sensor: the drive takes the flux and the residual from it.
#pragma once

#include "estimator.h"
#include "scenario.h"

#include <memory>

namespace nf::peers
{

// For RunOptions::estimate. Throws ConfigError where the drive has a sensor: there is nothing to
// put an estimator in place of.
std::function<void(drive_t &, const sample_t &)>
in_place_of_the_observer(const Config &config, std::unique_ptr<Estimator> estimator);

} // namespace nf::peers
