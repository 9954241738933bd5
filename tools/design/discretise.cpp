// SPDX-License-Identifier: MIT
#include "discretise.h"

#include <algorithm>
#include <cmath>

namespace nf::design
{

Eigen::MatrixXd exponential(const Eigen::MatrixXd &a)
{
    // Below this norm the 15th term is 0.25^15/15! < 1e-21 of the first.
    constexpr double SMALL = 0.25;
    constexpr int TERMS = 15;
    const double norm = a.cwiseAbs().rowwise().sum().maxCoeff();
    const int squarings = norm > SMALL ? static_cast<int>(std::ceil(std::log2(norm / SMALL))) : 0;
    const Eigen::MatrixXd small = a * std::ldexp(1.0, -squarings);
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(a.rows(), a.cols());
    Eigen::MatrixXd result = one;
    for (int k = TERMS; k >= 1; k--) { // Horner
        result = one + small * result / k;
    }
    for (int k = 0; k < squarings; k++) {
        result = (result * result).eval();
    }
    return result;
}

Discrete discretise(const Continuous &model, double sample_time_s)
{
    constexpr int SIZE = MOTOR_STATES + INPUT_COUNT;
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(SIZE, SIZE);
    block.topLeftCorner(MOTOR_STATES, MOTOR_STATES) = model.f;
    block.topRightCorner(MOTOR_STATES, INPUT_COUNT) = model.g;
    const Eigen::MatrixXd whole = exponential(block * sample_time_s);
    return {whole.topLeftCorner(MOTOR_STATES, MOTOR_STATES),
            whole.topRightCorner(MOTOR_STATES, INPUT_COUNT), sample_time_s};
}

} // namespace nf::design
