/* SPDX-License-Identifier: MIT */
// Paper B section 3: the gains of least cost (50), among those that are stable.
#pragma once

#include "cost.h"
#include "stability.h"

namespace nf::design
{

struct Optimum {
    Gains gains;
    double cost;
    int iterations; // steps of the conjugate gradients
    bool converged;
};

// Least cost among pairs with K_p > 0 whose slowest pole has at most this time constant. Within the
// region the cost falls towards K_i = 0, where the integrator does nothing, so without the demand
// there is no optimum but a limit. From a stable start, first to the demanded region, then down
// with a barrier at its edge that is lowered in stages: no pair on the way is unstable. Throws
// UnstableError for an unstable start and std::runtime_error for a start with K_p ≤ 0 and where no
// pair meets the demand.
Optimum stable_optimum(const Discrete &motor, const CostSettings &settings, const Gains &start,
                       double slowest_time_constant_s);

// Least cost as the paper looks for it, with no regard to stability on the way.
Optimum free_optimum(const Discrete &motor, const CostSettings &settings, const Gains &start);

} // namespace nf::design
