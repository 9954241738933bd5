/* SPDX-License-Identifier: MIT */
// Paper B (50)–(59): the cost of a unit step with a pair of gains, and its gradient.
#pragma once

#include "augmented.h"

namespace nf::design
{

// J = T·Σ [Q1·X² + Q2·ω_s²] over the samples before the horizon, + Q3·X² at it. X is one of the
// states, of a step of the command the speed's distance from it in place of the speed: at rest
// nothing is reached yet. The step of 1 is there from the first sample on.
struct CostSettings {
    double q1 = 1;
    double q2 = 5;
    double q3 = 1;
    int horizon_samples = 30;
    int state = SPEED; // X
    int input = LOAD;  // where the step is
};

// (50), as the last state of (51), (52) with the sum's first term at the first sample.
double cost(const Discrete &motor, const CostSettings &settings, const Gains &gains);

// dJ/d(K_p, K_i) by the adjoint recursion (54), (57)–(59). The prints of (54) and (58) lack a sign
// and a λ(n): g is the gradient itself here, and λ(n−1) = f_xᵀ·λ(n).
Eigen::Vector2d cost_gradient(const Discrete &motor, const CostSettings &settings,
                              const Gains &gains);

} // namespace nf::design
