/* SPDX-License-Identifier: MIT */
// The motors of the zoo that are most like a user's, and how many of them a tuning holds: what may
// be expected of a configuration before its motor has turned.
#pragma once

#include "config.h"

#include <string>
#include <vector>

namespace nf::certify
{

// The `count` of the zoo's first `drawn` motors whose dimensionless numbers are nearest to those of
// a motor on a board, as scenarios of a user's motor, `zoo:servo:17@1:user`; the nearest first.
// Near is measured in standard deviations of each number's logarithm among those drawn, all with
// the default tuning: so it depends on motor and board alone. Throws ConfigError where motor and
// board cannot have the default tuning.
std::vector<std::string> most_alike(const std::string &motor, const std::string &board, int drawn,
                                    int count);

// How many of these scenarios the tuning holds: it can be computed for them, and the rotor is never
// lost.
int count_held(const std::vector<std::string> &scenarios, const std::string &tuning);

} // namespace nf::certify
