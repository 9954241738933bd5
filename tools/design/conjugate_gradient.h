/* SPDX-License-Identifier: MIT */
// Paper B section 3, steps 1 to 5: minimisation by conjugate gradients (55), (56), (60).
#pragma once

#include <functional>

#include <Eigen/Dense>

namespace nf::design
{

// A smooth function where `allowed`; elsewhere value and gradient are not asked for.
struct Objective {
    std::function<double(const Eigen::VectorXd &)> value;
    std::function<Eigen::VectorXd(const Eigen::VectorXd &)> gradient;
    std::function<bool(const Eigen::VectorXd &)> allowed;
};

struct DescentLimits {
    double tolerance; // done when |gradient| is below it
    int iterations;
};

struct Descent {
    Eigen::VectorXd at; // the best point, always allowed
    double value;
    double gradient_norm;
    int iterations;
    bool converged;
};

// From an allowed start. Directions by Fletcher and Reeves, started anew after as many steps as
// there are variables, and when one does not go down. `stop`, asked after each step, ends the
// search early.
Descent conjugate_gradient(const Objective &objective, const Eigen::VectorXd &start,
                           const DescentLimits &limits,
                           const std::function<bool(const Eigen::VectorXd &)> &stop = {});

} // namespace nf::design
