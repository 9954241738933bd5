/* SPDX-License-Identifier: MIT */
// The same machines for each tuning: what differs between two tunings is then the tunings.
#pragma once

#include "trial.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace nf::certify
{

struct Series {
    std::string tuning;
    Config believed;
    std::string refusal; // why this drive cannot have the tuning, one line; empty: it can
    std::vector<Trial> trials;
};

struct Campaign {
    std::vector<Axis> box;
    std::vector<Point> points; // one a run
    std::vector<Series> series;
    int planned = 0; // runs
    uint64_t seed = 0;
};

struct Watcher {
    std::function<void(double)> progress; // share of the runs that is done; may be empty
    std::function<bool()> stop;           // asked between two runs; may be empty
};

// The motor, with its board, imperfections and overrides as for load_scenario(), and each of the
// tunings, without runs. Throws ConfigError for what is wrong whatever the tuning.
Campaign plan(const std::vector<std::string> &tunings, const std::vector<std::string> &with,
              const std::vector<std::string> &set);

// Runs each tuning that is not refused on the same machines. Stopped early, all tunings have the
// same number of runs.
void run(Campaign &campaign, int runs, uint64_t seed, const Watcher &watcher = {});

} // namespace nf::certify
