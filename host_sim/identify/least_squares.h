/* SPDX-License-Identifier: MIT */
// Least squares: the parameters for which the sum of the squared residuals is smallest, and how
// sure they are.
#pragma once

#include <functional>

#include <Eigen/Dense>

namespace nf::identify
{

struct Fit {
    Eigen::VectorXd value;
    Eigen::VectorXd std;       // standard deviation of each, from the residuals that are left
    Eigen::VectorXd residuals; // that are left
    double rms = 0;            // of them, over the degrees of freedom
};

// Of a linear model: rows·x against the measured. More rows than columns, of full rank; else std is
// 0 or not finite.
Fit fit_linear(const Eigen::MatrixXd &rows, const Eigen::VectorXd &measured);

// Of a model that is not linear, by Levenberg and Marquardt's method from `start` on, derivatives
// by differences.
Fit fit_curve(const std::function<Eigen::VectorXd(const Eigen::VectorXd &)> &residuals,
              const Eigen::VectorXd &start);

} // namespace nf::identify
