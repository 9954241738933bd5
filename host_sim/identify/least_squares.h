/* SPDX-License-Identifier: MIT */
// Parameters that make residuals small, and how well they are known.
#pragma once

#include <functional>

#include <Eigen/Core>

namespace nf::identify
{

struct Fit {
    Eigen::VectorXd parameters;
    Eigen::MatrixXd covariance; // of the parameters, from the residuals that are left
    double rms = 0;             // of these, with the number of parameters taken off

    double std(int parameter) const;
};

using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd &)>;

// Levenberg-Marquardt from `start`, with derivatives by small steps. Total for finite residuals: where it gets no further
// it stops. There have to be more residuals than parameters.
Fit least_squares(const Residuals &residuals, const Eigen::VectorXd &start);

// x of least |A·x − y|. Rows have the weights that are multiplied into them. More rows than columns.
Fit linear_least_squares(const Eigen::MatrixXd &a, const Eigen::VectorXd &y);

} // namespace nf::identify
