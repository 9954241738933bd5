/* SPDX-License-Identifier: MIT */
// Rotor position, paper A (23), in radians.
#pragma once

#include <cmath>
#include <cstdint>

namespace nf::twin
{

class RotorPosition
{
public:
    explicit RotorPosition(double period_s) : period_s_(period_s)
    {
    }

    void reset(double angle_rad)
    {
        angle_rad_ = angle_rad;
        turns_ = 0;
        wrap();
    }

    // θ̂(k+1) = θ̂(k) + T·ω̂(k)
    void step(double speed_rad_s)
    {
        angle_rad_ += period_s_ * speed_rad_s;
        wrap();
    }

    // Within 0…2π.
    double angle_rad() const
    {
        return angle_rad_;
    }

    int64_t turns() const
    {
        return turns_;
    }

private:
    void wrap()
    {
        constexpr double TURN = 6.283185307179586476925;
        const double whole = std::floor(angle_rad_ / TURN);
        turns_ += static_cast<int64_t>(whole);
        angle_rad_ -= whole * TURN;
    }

    double period_s_;
    double angle_rad_ = 0;
    int64_t turns_ = 0;
};

} // namespace nf::twin
