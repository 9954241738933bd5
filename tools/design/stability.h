/* SPDX-License-Identifier: MIT */
// Paper B section 3: poles of the closed loop, and the gains for which they are all within the unit
// circle.
#pragma once

#include "augmented.h"

#include <complex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace nf::design
{

// Largest magnitude first.
std::vector<std::complex<double>> poles(const Eigen::MatrixXd &a);

// The pole that decides: stable below a magnitude of 1.
std::complex<double> slowest_pole(const Discrete &motor, const Gains &gains);

bool is_stable(const Discrete &motor, const Gains &gains);

// Of a pole of magnitude below 1.
double time_constant_s(double magnitude, double sample_time_s);

// what() is the line for the user: the pair, the eigenvalue that says why, what is allowed.
struct UnstableError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Throws an UnstableError for an unstable pair. `what` says whose pair it is.
void require_stable(const Discrete &motor, const Gains &gains, const std::string &what);

// Where stability ends above K_i = 0, where it always begins: the integrator's pole is at 1 there
// and outside for K_i < 0. Nothing where no small K_i is stable.
std::optional<double> largest_ki_per_s(const Discrete &motor, double kp);

// The region's edge above K_i = 0, from its smallest to its largest K_p.
struct Region {
    std::vector<double> kp;
    std::vector<double> ki_per_s;
};

// `inside_kp` is a K_p with a stable K_i; the region is empty without one.
Region stable_region(const Discrete &motor, double inside_kp, int points);

} // namespace nf::design
