/* SPDX-License-Identifier: MIT */
// The numbers without a unit that say what is hard about a drive: motors of any size that share
// them behave alike. I is the rated current, ω the rated electrical speed, T the PWM period, all of
// the files; dead time and device drop are the real board's.
#pragma once

#include "configuration.h"

#include <vector>

namespace nf
{

struct Dimensionless {
    const char *name; // as in results
    const char *meaning;
    double value;
};

// Of a configuration that build() accepts, in an order that never changes.
std::vector<Dimensionless> dimensionless(const Config &config);

} // namespace nf
