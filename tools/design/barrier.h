/* SPDX-License-Identifier: MIT */
// A smooth function of the gains that is finite where all poles are within a circle, and infinite
// on it.
#pragma once

#include "augmented.h"

namespace nf::design
{

// −log det(I − A⊗A/ρ²) of the closed loop: of all products of two poles λ, −Σ log(1 − λ_i·λ_j/ρ²).
// It is to be asked for only where all poles are within ρ.
double barrier(const Discrete &motor, const Gains &gains, double rho);

// Its derivative by K_p and K_i.
Eigen::Vector2d barrier_gradient(const Discrete &motor, const Gains &gains, double rho);

} // namespace nf::design
