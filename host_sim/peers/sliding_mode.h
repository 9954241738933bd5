/* SPDX-License-Identifier: MIT */
// Sliding-mode observer of the current in the stationary frame, a filter for its EMF, and a PLL. A
// textbook form, for instance of [Chi 2009]: the model's current is driven by z = K·sat((î − i)/δ)
// in place of the EMF; once it slides, z is the EMF with what switches; a low-pass of first order
// takes that away, and its lag is given back.
//
// Within the boundary layer the observer is linear, z(k) = (a − h)·z(k−1) + h·e with h = b·K/δ. The
// lag of that and of the low-pass at the estimated speed is known exactly and given back together.
//
// [Chi 2009] S. Chi, Z. Zhang, L. Xu: Sliding-mode sensorless control of direct-drive PM
// synchronous motors for washing machine applications. IEEE Trans. Ind. Appl. 45 (2), 2009.
#pragma once

#include "estimator.h"
#include "pll.h"

namespace nf::peers
{

class SlidingMode : public Estimator
{
public:
    struct Gains {
        double layer;     // h, a sample: 1 is as steep as a sample allows
        double amplitude; // K over the EMF at the limit of the speed; above 1 it can slide there
        double filter;    // share of the distance that the low-pass closes in a sample
    };

    SlidingMode(const Gains &gains, const Pll &pll);

    void start(const Model &model, const Estimate &known, Complex current_a) override;
    Estimate step(const Model &model, const Sample &sample) override;
    void follow(const Model &model, const Estimate &known) override;

private:
    Complex lag(double decay, double turn_rad) const;

    Gains gains_;
    Pll pll_;
    Complex current_;
    Complex switched_; // z
    Complex emf_;      // z after the low-pass
};

} // namespace nf::peers
