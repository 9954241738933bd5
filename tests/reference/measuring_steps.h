/* SPDX-License-Identifier: MIT */
// What the firmware's steps of current are beside a computation in double precision.
#pragma once

#include <cmath>

namespace nf::reference
{

// It measures with a converter and computes with 16 bits: the steps of both, A.
struct MeasuringSteps {
    MeasuringSteps(double full_scale_a, int converter_bits)
        : converter(std::ldexp(2 * full_scale_a, -converter_bits)),
          signal(std::ldexp(2 * full_scale_a, -15))
    {
    }

    double converter;
    double signal; // Q15 of twice the converter's range

    // As white noise, rms by axis: the converter's in two phases is 4/3 of it in the mean of both
    // axes; the signal's is added in Clarke, Park and the network's output.
    double noise() const
    {
        return std::sqrt((4.0 / 3 * converter * converter + 3 * signal * signal) / 12);
    }
    // As an offset: half a step of the converter, and what is rounded down after it.
    double offset() const
    {
        return converter / 2 + signal;
    }
};

// Of 10^4 normal deviates the largest is about this many times their rms.
constexpr double LARGEST_OF_MANY = 4;

} // namespace nf::reference
