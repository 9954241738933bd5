/* SPDX-License-Identifier: MIT */
// Paper B (25)–(27): exact discretisation with inputs that hold for a sample.
#pragma once

#include "linear_model.h"

namespace nf::design
{

// e^A of a square matrix: Taylor series of A/2^s, squared s times. Relative error below 1e-13 of
// the largest entry for norms up to 100.
Eigen::MatrixXd exponential(const Eigen::MatrixXd &a);

// Φ(T) and Θ(T) as blocks of e^[[F, G], [0, 0]]·T.
Discrete discretise(const Continuous &model, double sample_time_s);

} // namespace nf::design
