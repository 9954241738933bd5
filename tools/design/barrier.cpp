// SPDX-License-Identifier: MIT
#include "barrier.h"

#include <cmath>

namespace nf::design
{
namespace
{

constexpr int SQUARE = STATE_COUNT * STATE_COUNT;
using Products = Eigen::Matrix<double, SQUARE, SQUARE>;

Products kronecker(const LoopMatrix &a, const LoopMatrix &b)
{
    Products product;
    for (Eigen::Index row = 0; row < STATE_COUNT; row++) {
        for (Eigen::Index column = 0; column < STATE_COUNT; column++) {
            product.block<STATE_COUNT, STATE_COUNT>(row * STATE_COUNT, column * STATE_COUNT) =
                a(row, column) * b;
        }
    }
    return product;
}

Products distance(const LoopMatrix &a, double rho)
{
    return Products::Identity() - kronecker(a, a) / (rho * rho);
}

} // namespace

double barrier(const Discrete &motor, const Gains &gains, double rho)
{
    const Eigen::PartialPivLU<Products> lu(distance(close_loop(motor, gains).a, rho));
    return -lu.matrixLU().diagonal().cwiseAbs().array().log().sum();
}

Eigen::Vector2d barrier_gradient(const Discrete &motor, const Gains &gains, double rho)
{
    const LoopMatrix a = close_loop(motor, gains).a;
    const Products inverse = Eigen::PartialPivLU<Products>(distance(a, rho)).inverse();
    const LoopMatrix zero = close_loop(motor, {0, 0}).a;
    const Gains units[] = {{1, 0}, {0, 1}};
    Eigen::Vector2d gradient;
    for (int k = 0; k < 2; k++) {
        const LoopMatrix slope = close_loop(motor, units[k]).a - zero; // A is linear in the gains
        const Products change = kronecker(slope, a) + kronecker(a, slope);
        gradient[k] = inverse.transpose().cwiseProduct(change).sum() / (rho * rho);
    }
    return gradient;
}

} // namespace nf::design
