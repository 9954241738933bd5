/* SPDX-License-Identifier: MIT */
// Phase compensator, paper B (40), (41), (43), in radians and amperes.
#pragma once

#include <algorithm>
#include <cmath>

namespace nf::twin
{

class PhaseCompensator
{
public:
    struct Params {
        double gain; // g
        double lead_max_rad;
        double brake_max_rad;
        double current_min; // unit of the currents
    };

    explicit PhaseCompensator(const Params &params) : params_(params)
    {
    }

    void start(double angle_rad)
    {
        angle_ = angle_rad;
        current_angle_ = 0;
    }

    // Where a sample begins: its firing angle, and the current's angle of the last one.
    void set(double angle_rad, double current_angle_rad)
    {
        angle_ = angle_rad;
        current_angle_ = current_angle_rad;
    }

    // One sample: the lead. `turn_rad` is T·ω, `direction` +1 or −1 with U.
    double step(double i_d, double i_q, double rotor_rad, double turn_rad, double direction)
    {
        const double wrapped = std::remainder(angle_ - rotor_rad, 2 * std::acos(-1.0));
        const double lead = direction * std::clamp(direction * wrapped, -params_.brake_max_rad,
                                                   params_.lead_max_rad);
        angle_ = rotor_rad + lead + turn_rad + direction * params_.gain * current_angle_;
        current_angle_ = std::atan2(i_d, std::max(std::abs(i_q), params_.current_min));
        return lead;
    }

    // θ_s of the next sample.
    double angle() const
    {
        return angle_;
    }

    // α_r of the last one.
    double current_angle() const
    {
        return current_angle_;
    }

private:
    Params params_;
    double angle_ = 0;
    double current_angle_ = 0;
};

} // namespace nf::twin
