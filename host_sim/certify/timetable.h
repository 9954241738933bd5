/* SPDX-License-Identifier: MIT */
// What happens in each run of a certificate: start, half and rated speed, load on and off, reversal
// to half of rated speed.
#pragma once

#include "config.h"

#include <cstddef>

namespace nf::certify
{

// A stretch of a run, s.
struct Window {
    double from_s;
    double to_s;

    bool holds(double time_s) const
    {
        return time_s >= from_s && time_s < to_s;
    }
};

// Where the speeds are judged: at the end of the load at rated speed, and at the end of the
// reversal.
struct Windows {
    Window loaded;
    Window reversed;
};

// The steps of the load that a draw sets, in scenario.load.
constexpr std::size_t START_LOAD = 0;
constexpr std::size_t STEP_LOAD = 2;

// The speed after the reversal, a share of the rated one, backwards.
constexpr double REVERSED_SPEED = 0.5;

// The scenario for this motor, slow enough for an inertia of `inertia_kg_m2`, without any load.
ScenarioSettings timetable(const Config &config, double inertia_kg_m2);

Windows windows_of(const ScenarioSettings &scenario);

} // namespace nf::certify
