/* SPDX-License-Identifier: MIT */
// The estimators there are, their gains, and the files that hold gains:
//
//     estimator = "luenberger"
//
//     [gain]
//     bandwidth = 0.3
//     …
#pragma once

#include "estimator.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace nf::peers
{

// All gains are numbers without a unit, by sample: they mean the same for each motor and each
// period.
struct Gain {
    const char *name;
    double min; // of a file, and where a search looks
    double max;
    const char *help;
};

using Gains = std::map<std::string, double>;

struct Peer {
    const char *name;
    const char *title;
    std::vector<Gain> gains;
    std::unique_ptr<Estimator> (*make)(const Gains &gains);
};

const std::vector<Peer> &all();

struct Tuned {
    const Peer *peer;
    std::unique_ptr<Estimator> estimator;
};

// The estimator of a file: a name in the folder peers/ of the data folder, or a path. `option` is
// for messages; throws ConfigError.
Tuned load(const std::string &option, const std::string &reference);

} // namespace nf::peers
