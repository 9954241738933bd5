/* SPDX-License-Identifier: MIT */
// Phase-locked loop of second order: angle and speed that follow a measured angle.
#pragma once

#include "estimator.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{

class Pll
{
public:
    // bandwidth: ω_n·T
    Pll(double bandwidth, double damping)
        : proportional_(2 * damping * bandwidth), integral_(bandwidth * bandwidth)
    {
    }

    void set(const Estimate &known)
    {
        now_ = known;
    }

    // `error_rad`: the measured angle less now().angle_rad. Returns the estimate of the next
    // instant.
    Estimate step(const Model &model, double error_rad)
    {
        now_.speed_rad_s = std::clamp(now_.speed_rad_s + integral_ / model.period_s * error_rad,
                                      -model.speed_limit_rad_s, model.speed_limit_rad_s);
        const double angle =
            now_.angle_rad + model.period_s * now_.speed_rad_s + proportional_ * error_rad;
        now_.angle_rad = std::remainder(angle, TURN);
        return now_;
    }

    const Estimate &now() const
    {
        return now_;
    }

private:
    static constexpr double TURN = 6.283185307179586476925;

    double proportional_;
    double integral_;
    Estimate now_{};
};

} // namespace nf::peers
