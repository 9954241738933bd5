/* SPDX-License-Identifier: MIT */
// Clarke and Park transforms in SI units, amplitude invariant (control specification, section 1).
#pragma once

#include <Eigen/Dense>

#include <cmath>

namespace nf::twin
{

// (α, β) or (d, q).
using Vector = Eigen::Vector2d;

// Two phases of a system without zero sequence; the unit stays.
inline Vector clarke(double a, double b)
{
    const double c = -a - b;
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0, -0.5, -0.5, 0.0, std::sqrt(3.0) / 2.0, -std::sqrt(3.0) / 2.0;
    return 2.0 / 3.0 * (projection * Eigen::Vector3d(a, b, c));
}

// Stationary frame to a frame turned by `angle_rad`.
inline Vector park(const Vector &v, double angle_rad)
{
    return Eigen::Rotation2Dd(-angle_rad) * v;
}

// And back.
inline Vector park_inverse(const Vector &v, double angle_rad)
{
    return Eigen::Rotation2Dd(angle_rad) * v;
}

} // namespace nf::twin
