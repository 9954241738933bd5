// Space-vector modulator: phase duties for a voltage on a bus, both in V.
#pragma once

#include "twin_transforms.h"

#include <Eigen/Dense>

namespace nf::twin
{

class Modulator
{
public:
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

    // The longest vector that needs no cut in any direction, V.
    static double reach(double bus_v)
    {
        return bus_v / std::sqrt(3.0);
    }
};

} // namespace nf::twin
