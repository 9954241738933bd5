/* SPDX-License-Identifier: MIT */
// Phase margin of the speed loop on a rigid shaft: what estimate, periods, current loop and torque
// filter leave of it.
#pragma once

#include "settings.h"

namespace nf
{

enum class TorqueFilter {
    none,
    as_set // in the tuning
};

// Of a loop with this bandwidth, rad. The tuning is complete but for the bandwidth. A notch below
// the frequency up to which the loop is to act leaves nothing: −π.
double speed_margin(const TuningSettings &tuning, double control_period_s, double bandwidth_hz,
                    TorqueFilter filter);

// The largest bandwidth up to `most_hz` that has at least this margin, with the tuning's torque
// filter.
double bandwidth_of_margin(const TuningSettings &tuning, double control_period_s, double margin,
                           double most_hz);

// Frequency at which the speed loop on a rigid shaft lags by half a turn, Hz: where it swings when
// its gain is too large. The tuning is complete. At most half of the loop's rate.
double speed_lag_hz(const TuningSettings &tuning, double control_period_s);

} // namespace nf
