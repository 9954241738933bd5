// SPDX-License-Identifier: MIT
#include "optimum.h"

#include "barrier.h"
#include "conjugate_gradient.h"

#include <cmath>

#include <fmt/format.h>

namespace nf::design
{
namespace
{

constexpr int ITERATIONS = 400;
// Weights of the barrier beside a cost of 1 at the start of the descent. The optimum is off by
// about the last.
constexpr double FIRST_WEIGHT = 1e-2;
constexpr double WEIGHT_RATIO = 0.1;
constexpr int STAGES = 7;       // the last weight is 1e-8
constexpr int ENTRY_STAGES = 6; // the last weight is 1e3: the cost counts for nothing beside it
// Of that cost per unit of gain: a stage is done, the search without a barrier is.
constexpr double GRADIENT_SHARE = 1e-3;
constexpr double FREE_TOLERANCE = 1e-6;

Gains gains_of(const Eigen::VectorXd &z)
{
    return {z[0], z[1]};
}

double radius(const Discrete &motor, const Eigen::VectorXd &z)
{
    return std::abs(slowest_pole(motor, gains_of(z)));
}

// The drive takes no negative K_p. Stability alone keeps K_i above 0.
double drive_barrier(const Discrete &motor, const Eigen::VectorXd &z, double rho)
{
    return barrier(motor, gains_of(z), rho) - std::log(z[0]);
}

Eigen::VectorXd drive_barrier_gradient(const Discrete &motor, const Eigen::VectorXd &z, double rho)
{
    return barrier_gradient(motor, gains_of(z), rho) - Eigen::Vector2d(1 / z[0], 0);
}

// Cost and barrier, both weighted.
Objective weighted(const Discrete &motor, const CostSettings &settings, double cost_weight,
                   double barrier_weight, double rho)
{
    return {
        [=, &motor, &settings](const Eigen::VectorXd &z) {
            return cost_weight * cost(motor, settings, gains_of(z)) +
                   barrier_weight * drive_barrier(motor, z, rho);
        },
        [=, &motor, &settings](const Eigen::VectorXd &z) -> Eigen::VectorXd {
            return cost_weight * cost_gradient(motor, settings, gains_of(z)) +
                   barrier_weight * drive_barrier_gradient(motor, z, rho);
        },
        [=, &motor](const Eigen::VectorXd &z) { return z[0] > 0 && radius(motor, z) < rho; },
    };
}

// Down with a barrier at the edge of stability that gains weight until the demand is met: no
// further into the region than that takes, so that the start still decides between several minima.
Descent enter(const Discrete &motor, const CostSettings &settings, const Gains &start, double rho)
{
    const auto inside = [&](const Eigen::VectorXd &z) { return radius(motor, z) < rho; };
    const double scale = cost(motor, settings, start);
    Descent descent{Eigen::Vector2d(start.kp, start.ki_per_s), 0, 0, 0, true};
    int iterations = 0;
    for (int stage = 0; stage < ENTRY_STAGES && !inside(descent.at); stage++) {
        const double weight = FIRST_WEIGHT / std::pow(WEIGHT_RATIO, stage);
        descent = conjugate_gradient(weighted(motor, settings, 1 / scale, weight, 1), descent.at,
                                     {GRADIENT_SHARE, ITERATIONS}, inside);
        iterations += descent.iterations;
    }
    if (!inside(descent.at)) {
        throw std::runtime_error(fmt::format(
            "optimum.slowest_time_constant_s: no pair with K_p > 0 found whose slowest pole is within "
            "{:.7g}; the best is K_p = {:.4g}, K_i = {:.4g} 1/s with {:.4g} s; allowed: more than that",
            rho, descent.at[0], descent.at[1],
            time_constant_s(radius(motor, descent.at), motor.sample_time_s)));
    }
    descent.iterations = iterations;
    return descent;
}

} // namespace

Optimum stable_optimum(const Discrete &motor, const CostSettings &settings, const Gains &start,
                       double slowest_time_constant_s)
{
    require_stable(motor, start, "start");
    if (!(start.kp > 0)) {
        throw std::runtime_error(fmt::format(
            "start.kp = {:g}: the search is among what the drive takes; allowed: above 0",
            start.kp));
    }
    const double rho = std::exp(-motor.sample_time_s / slowest_time_constant_s);
    Descent descent = enter(motor, settings, start, rho);
    int iterations = descent.iterations;
    const double scale = cost(motor, settings, gains_of(descent.at));
    for (int stage = 0; stage < STAGES; stage++) {
        const double weight = FIRST_WEIGHT * std::pow(WEIGHT_RATIO, stage);
        descent = conjugate_gradient(weighted(motor, settings, 1 / scale, weight, rho), descent.at,
                                     {GRADIENT_SHARE, ITERATIONS});
        iterations += descent.iterations;
    }
    const Gains found = gains_of(descent.at);
    return {found, cost(motor, settings, found), iterations, descent.converged};
}

Optimum free_optimum(const Discrete &motor, const CostSettings &settings, const Gains &start)
{
    const double scale = cost(motor, settings, start);
    const Objective objective = {
        [&](const Eigen::VectorXd &z) { return cost(motor, settings, gains_of(z)) / scale; },
        [&](const Eigen::VectorXd &z) -> Eigen::VectorXd {
            return cost_gradient(motor, settings, gains_of(z)) / scale;
        },
        [](const Eigen::VectorXd &) { return true; },
    };
    const Descent descent = conjugate_gradient(objective, Eigen::Vector2d(start.kp, start.ki_per_s),
                                               {FREE_TOLERANCE, ITERATIONS});
    const Gains found = gains_of(descent.at);
    return {found, cost(motor, settings, found), descent.iterations, descent.converged};
}

} // namespace nf::design
