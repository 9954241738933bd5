/* SPDX-License-Identifier: MIT */
// Luenberger observer of current and extended EMF [Chen 2003] in the stationary frame, and a PLL on
// the EMF.
//
// The EMF is observed as a disturbance that stands still, so that the observer does not depend on
// the estimated speed. With a and b of the winding (back_emf.h), both poles of its error are p =
// exp(−bandwidth):
//     î(k+1) = a·î + b·(v − ê) + k_1·(i − î),   k_1 = a + 1 − 2p
//     ê(k+1) = ê + k_2·(i − î),                 k_2 = −(1 − p)²/b
// An EMF that turns by r = exp(jωT) in a sample shows as r^(3/2)·((1 − p)/(r − p))² of it in
// ê(k+1). The angle of this factor at the estimated speed is given back.
#pragma once

#include "estimator.h"
#include "pll.h"

namespace nf::peers
{

class Luenberger : public Estimator
{
public:
    // bandwidth: of current and EMF, rad a sample
    Luenberger(double bandwidth, const Pll &pll);

    void start(const Model &model, const Estimate &known, Complex current_a) override;
    Estimate step(const Model &model, const Sample &sample) override;
    void follow(const Model &model, const Estimate &known) override;

private:
    Complex lag(double turn_rad) const;

    double pole_;
    Pll pll_;
    Complex current_;    // predicted for the last sample
    Complex emf_;        // likewise, ê
    Complex innovation_; // of the last sample: measured less predicted current
};

} // namespace nf::peers
