/* SPDX-License-Identifier: MIT */
// A measured value and how far it may be wrong.
#pragma once

#include <cmath>

namespace nf::identify
{

// All in the unit of the value.
struct Estimate {
    double value = 0;
    double std = 0;   // standard deviation: what a repetition would change
    double bound = 0; // of a systematic error, which no repetition shows

    // The truth is within value ± bar() in 95 of 100 measurements.
    double bar() const
    {
        return 2 * std + bound;
    }

    double std_pct() const
    {
        return 100 * std / std::abs(value);
    }

    double bound_pct() const
    {
        return 100 * bound / std::abs(value);
    }
};

} // namespace nf::identify
