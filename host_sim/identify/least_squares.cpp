// SPDX-License-Identifier: MIT
#include "least_squares.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace nf::identify
{
namespace
{

constexpr int STEPS_MOST = 60;
constexpr double STEP = 1e-6;
constexpr double STEP_LEAST = 1e-9;
constexpr double DAMPING_FIRST = 1e-3;
constexpr double DAMPING_MOST = 1e12;
constexpr double GAIN_LEAST = 1e-12; // a step that gains less is the last one

Eigen::MatrixXd derivatives(const Residuals &residuals, const Eigen::VectorXd &x,
                            const Eigen::VectorXd &at)
{
    Eigen::MatrixXd slope(at.size(), x.size());
    for (Eigen::Index k = 0; k < x.size(); k++) {
        Eigen::VectorXd moved = x;
        const double step = std::max(STEP * std::abs(x[k]), STEP_LEAST);
        moved[k] += step;
        slope.col(k) = (residuals(moved) - at) / step;
    }
    return slope;
}

Fit with_covariance(const Eigen::VectorXd &x, const Eigen::MatrixXd &slope,
                    const Eigen::VectorXd &left)
{
    const double freedom = std::max<double>(1, static_cast<double>(left.size() - x.size()));
    const double variance = left.squaredNorm() / freedom;
    const Eigen::MatrixXd square = slope.transpose() * slope;
    return {x, variance * square.completeOrthogonalDecomposition().pseudoInverse(),
            std::sqrt(variance)};
}

} // namespace

double Fit::std(int parameter) const
{
    return std::sqrt(std::max(0.0, covariance(parameter, parameter)));
}

Fit least_squares(const Residuals &residuals, const Eigen::VectorXd &start)
{
    Eigen::VectorXd x = start;
    Eigen::VectorXd left = residuals(x);
    double damping = DAMPING_FIRST;
    bool ends = false;
    for (int step = 0; step < STEPS_MOST && !ends; step++) {
        const Eigen::MatrixXd slope = derivatives(residuals, x, left);
        const Eigen::MatrixXd square = slope.transpose() * slope;
        ends = true;
        for (; damping < DAMPING_MOST && ends; damping *= 4) {
            Eigen::MatrixXd damped = square;
            damped.diagonal() *= 1 + damping;
            const Eigen::VectorXd next = x - damped.ldlt().solve(slope.transpose() * left);
            const Eigen::VectorXd then = residuals(next);
            if (then.squaredNorm() < left.squaredNorm()) {
                step = left.squaredNorm() - then.squaredNorm() < GAIN_LEAST * left.squaredNorm()
                           ? STEPS_MOST
                           : step;
                x = next;
                left = then;
                damping /= 64;
                ends = false;
            }
        }
    }
    return with_covariance(x, derivatives(residuals, x, left), left);
}

Fit linear_least_squares(const Eigen::MatrixXd &a, const Eigen::VectorXd &y)
{
    const Eigen::VectorXd x = a.colPivHouseholderQr().solve(y);
    return with_covariance(x, a, y - a * x);
}

} // namespace nf::identify
