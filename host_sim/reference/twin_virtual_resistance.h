/* SPDX-License-Identifier: MIT */
// A resistance that only changes of the current see, in amperes and volts.
#pragma once

#include "twin_transforms.h"

namespace nf::twin
{

class VirtualResistance
{
public:
    struct Params {
        double resistance;
        double mean_rate; // share of the difference that the mean takes over in a sample
    };

    explicit VirtualResistance(const Params &params) : params_(params)
    {
    }

    void start(const Vector &mean)
    {
        mean_ = mean;
    }

    // One sample: the voltage to add.
    Vector step(const Vector &current)
    {
        const Vector change = current - mean_;
        mean_ += params_.mean_rate * change;
        return -params_.resistance * change;
    }

    Vector mean() const
    {
        return mean_;
    }

private:
    Params params_;
    Vector mean_ = Vector::Zero();
};

} // namespace nf::twin
