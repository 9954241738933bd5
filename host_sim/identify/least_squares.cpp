// SPDX-License-Identifier: MIT
#include "least_squares.h"

#include <algorithm>
#include <cmath>

namespace nf::identify
{
namespace
{

constexpr int STEPS_MAX = 60;
constexpr double DAMPING_START = 1e-3;
constexpr double DAMPING_MAX = 1e12;
constexpr double DAMPING_FACTOR = 4;
constexpr double CALM = 1e-12; // of the sum of squares
constexpr double DIFFERENCE = 1e-6;

Fit fit_of(const Eigen::VectorXd &value, const Eigen::VectorXd &residuals,
           const Eigen::MatrixXd &jacobian)
{
    const auto freedom = std::max<Eigen::Index>(1, residuals.size() - value.size());
    const double variance = residuals.squaredNorm() / static_cast<double>(freedom);
    const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::MatrixXd covariance = variance * normal.colPivHouseholderQr().inverse();
    Fit fit;
    fit.value = value;
    fit.std = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    fit.residuals = residuals;
    fit.rms = std::sqrt(variance);
    return fit;
}

Eigen::MatrixXd
jacobian_of(const std::function<Eigen::VectorXd(const Eigen::VectorXd &)> &residuals,
            const Eigen::VectorXd &at, const Eigen::VectorXd &there)
{
    Eigen::MatrixXd jacobian(there.size(), at.size());
    for (Eigen::Index k = 0; k < at.size(); k++) {
        const double step = DIFFERENCE * std::max(std::abs(at[k]), DIFFERENCE);
        Eigen::VectorXd beside = at;
        beside[k] += step;
        jacobian.col(k) = (residuals(beside) - there) / step;
    }
    return jacobian;
}

} // namespace

Fit fit_linear(const Eigen::MatrixXd &rows, const Eigen::VectorXd &measured)
{
    const Eigen::VectorXd value = rows.colPivHouseholderQr().solve(measured);
    return fit_of(value, measured - rows * value, rows);
}

Fit fit_curve(const std::function<Eigen::VectorXd(const Eigen::VectorXd &)> &residuals,
              const Eigen::VectorXd &start)
{
    Eigen::VectorXd at = start;
    Eigen::VectorXd there = residuals(at);
    Eigen::MatrixXd jacobian = jacobian_of(residuals, at, there);
    double damping = DAMPING_START;
    for (int k = 0; k < STEPS_MAX && damping < DAMPING_MAX; k++) {
        const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
        Eigen::MatrixXd damped = normal;
        damped.diagonal() += damping * normal.diagonal();
        const Eigen::VectorXd next = at - damped.ldlt().solve(jacobian.transpose() * there);
        const Eigen::VectorXd after = residuals(next);
        if (!(after.squaredNorm() < there.squaredNorm())) {
            damping *= DAMPING_FACTOR;
            continue;
        }
        const bool calm = there.squaredNorm() - after.squaredNorm() < CALM * there.squaredNorm();
        at = next;
        there = after;
        if (calm) {
            break;
        }
        jacobian = jacobian_of(residuals, at, there);
        damping /= DAMPING_FACTOR;
    }
    return fit_of(at, there, jacobian);
}

} // namespace nf::identify
