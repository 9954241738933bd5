/* SPDX-License-Identifier: MIT */
// How fast the simulator is: whole runs of a scenario, and its plant and drive alone.
#pragma once

#include "config.h"

#include <string>

namespace nf
{

struct BenchResult {
    std::string scenario;
    int runs = 0;
    int64_t ticks = 0;      // in a run, prelude included
    double simulated_s = 0; // in a run
    double best_ns = 0;     // per tick: whole runs, metrics included
    double median_ns = 0;
    double plant_ns = 0;       // the plant alone, best of the runs
    double drive_ns = 0;       // drive_step alone, best of the runs
    double real_time_best = 0; // simulated time over wall-clock time
    double real_time_median = 0;
};

// One run records what goes between drive and plant; each of the two is then timed on the
// recording, where it does exactly what it did in the run. One warm-up run is not counted.
BenchResult bench(const Config &config, int runs);

} // namespace nf
