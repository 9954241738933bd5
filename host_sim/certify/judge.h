/* SPDX-License-Identifier: MIT */
// What the runs of a campaign say: which tuning to take, how much room is left, and what it depends
// on.
#pragma once

#include "campaign.h"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace nf::certify
{

// How a margin goes with one axis.
struct Influence {
    std::size_t axis;               // of the box
    double share;                   // of the variance of the margin, alone
    std::array<double, 4> margin{}; // mean of the margin in each fourth of the range
    std::array<int, 4> failed{};    // runs there that did not hold the rotor

    // Between the best and the worst fourth.
    double effect() const;
};

// A margin over the runs of a tuning.
struct Spread {
    double least;
    double low; // 5 of 100 runs have less
    double middle;
    std::optional<Influence> most; // the axis that it depends on most, if more than by chance
};

// Up to where nothing failed: the load or its inertia, which the user can limit.
struct Bound {
    std::size_t axis;
    double up_to; // the least value of a run that failed
    int runs;     // below it
};

// What chance alone may make of the largest share: with 20 axes more than that in one of 20
// campaigns.
double share_by_chance(int runs);

struct Summary {
    std::string tuning;
    std::string refusal;
    int runs = 0;
    int locked = 0;
    int slow = 0; // of the locked ones
    int stopped = 0;
    int lost = 0;
    int swings = 0;
    std::map<std::string, int> faults;
    Spread current; // of the locked runs, as the four below; 0 without one
    Spread voltage;
    Spread speed;
    Spread angle;
    Spread reached;
    Spread worst{};                    // of all runs
    double highest_rpm = 0;            // of the locked ones
    std::vector<Influence> influences; // the largest share first

    // Those that explain more of the margin than chance.
    std::vector<Influence> outstanding() const;

    // With 95 % confidence at least this share of all such machines is locked.
    double least_locked() const;
};

struct Judgement {
    std::vector<Summary> summaries; // one a tuning, in the order of the campaign
    std::size_t best = 0;           // the recommended one
    std::string why;                // against each of the others
    // Of the values that can be known better the one that the worst margin of the best tuning
    // depends on most. Empty where none stands out: chance may explain as much of the margin, or
    // the margin hardly changes.
    std::optional<std::size_t> limiting;
    // Where the failures of the best tuning depend on what the machine is used for.
    std::optional<Bound> bound;
};

// With at least one run.
Judgement judge(const Campaign &campaign);

} // namespace nf::certify
