/* SPDX-License-Identifier: MIT */
// Space-vector modulator: phase duties for a voltage on a bus, both in V, and the compensation of
// dead time and drop by the current, in A.
#pragma once

#include "twin_transforms.h"

#include <Eigen/Dense>

#include <cmath>

namespace nf::twin
{

class Modulator
{
public:
    struct Losses {
        double dead_time_share; // of the period
        double drop_v;
        double ripple_a;     // u_bus·T/(12·L), the size of a leg's current ripple
        double edge_per_amp; // 1 / the current over which the compensation rises to all
    };

    // Phase voltages of a vector against the star point.
    static Eigen::Vector3d phases(const Vector &voltage_v)
    {
        Eigen::Matrix<double, 3, 2> projection;
        projection << 1.0, 0.0, -0.5, std::sqrt(3.0) / 2.0, -0.5, -std::sqrt(3.0) / 2.0;
        return projection * voltage_v;
    }

    // Duties 0…1: the phases centred between the rails, cut there.
    static Eigen::Vector3d duties(const Vector &voltage_v, double bus_v)
    {
        const Eigen::Vector3d share = phases(voltage_v) / bus_v;
        const double common = (share.maxCoeff() + share.minCoeff()) / 2.0;
        return (share.array() - common + 0.5).cwiseMax(0.0).cwiseMin(1.0);
    }

    // What each leg is compensated by, not cut: nothing below its ripple r = ripple·(s − 9·u²), the
    // share z·(2 − z) of it above, z = 1 at the end of the edge.
    static Eigen::Vector3d compensation(const Losses &losses, const Vector &voltage_v, double bus_v,
                                        const Vector &current_a)
    {
        const Eigen::Array3d u = phases(voltage_v).array() / bus_v;
        const Eigen::Array3d i = phases(current_a);
        const double span = u.maxCoeff() - u.minCoeff();
        const double loss = losses.dead_time_share + losses.drop_v / bus_v;
        const Eigen::Array3d ripple = losses.ripple_a * (span - 9.0 * u.square()).max(0.0).min(1.0);
        const Eigen::Array3d above = (i.abs() - ripple).max(0.0);
        const Eigen::Array3d z = (above * losses.edge_per_amp).min(1.0);
        return loss * i.sign() * z * (2.0 - z);
    }

    // The longest vector that needs no cut in any direction, V.
    static double reach(double bus_v)
    {
        return bus_v / std::sqrt(3.0);
    }
};

} // namespace nf::twin
