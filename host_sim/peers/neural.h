/* SPDX-License-Identifier: MIT */
// The drive's own observer (nn_observer.h), paper A (14) to (23) with proportional path and ρ, once
// more in double precision: the estimator that the others are compared with, at the same place.
#pragma once

#include "estimator.h"

namespace nf::peers
{

class Neural : public Estimator
{
public:
    struct Gains {
        double kappa;
        double kappa_p;
        double rho_max;
        double feedback = 0; // f, share of the current error that the network takes over
    };

    explicit Neural(const Gains &gains);

    void start(const Model &model, const Estimate &known, Complex current_a) override;
    Estimate step(const Model &model, const Sample &sample) override;
    void follow(const Model &model, const Estimate &known) override;

private:
    Gains gains_;
    Complex state_;  // (x̂ + jŷ)·exp(jθ̂), A, of the last sample
    Complex error_;  // of the last sample, in its frame
    Estimate now_{}; // θ̂ of the next instant, ω̂
    double speed_out_ = 0;
    double angle_before_ = 0; // θ̂ of the last sample
};

} // namespace nf::peers
