/* SPDX-License-Identifier: MIT */
// Speed and position control at the slow rate, in electrical rad, rad/s and A.
#pragma once

#include "twin_pi.h"

#include <algorithm>
#include <cmath>

namespace nf::twin
{

class SpeedLoop
{
public:
    struct Params {
        Pi::Params pi;          // A per rad/s
        double ramp_rad_s;      // largest change of the reference in a slow period
        double speed_max_rad_s; // of the reference
        double current_min_a;   // of the demand
        double current_max_a;
        double current_per_change; // A for a change of the reference by 1 rad/s in a slow period
    };

    explicit SpeedLoop(const Params &params) : p_(params), pi_(params.pi)
    {
    }

    // Where a slow period begins: the last reference, and the integral, A.
    void reset(double reference_rad_s, double integral_a)
    {
        reference_ = reference_rad_s;
        pi_.reset(integral_a);
    }

    double ramp(double target_rad_s) const
    {
        const double wanted = std::clamp(target_rad_s, -p_.speed_max_rad_s, p_.speed_max_rad_s);
        return reference_ + std::clamp(wanted - reference_, -p_.ramp_rad_s, p_.ramp_rad_s);
    }

    // One slow period: i_q*, A.
    double step(double reference_rad_s, double measured_rad_s)
    {
        const double torque = accelerate(reference_rad_s);
        const double middle = (p_.current_min_a + p_.current_max_a) / 2;
        return middle +
               pi_.step(reference_ - measured_rad_s, torque - middle, p_.current_max_a - middle);
    }

    // The same without a PI: the current that the reference's change takes, A.
    double accelerate(double reference_rad_s)
    {
        const double limited = std::clamp(reference_rad_s, -p_.speed_max_rad_s, p_.speed_max_rad_s);
        const double torque = std::clamp((limited - reference_) * p_.current_per_change,
                                         p_.current_min_a, p_.current_max_a);
        reference_ = limited;
        return torque;
    }

    double reference() const
    {
        return reference_;
    }

    const Pi &pi() const
    {
        return pi_;
    }

private:
    Params p_;
    Pi pi_;
    double reference_ = 0;
};

class PositionLoop
{
public:
    struct Params {
        double slow_period_s;
        double ramp_rad_s;           // largest change of the profile's speed in a slow period
        double speed_max_rad_s;      // of the profile
        double braking_distance_rad; // B
        double softness;             // c
        double gain_1_s;             // of the position lag
        double lag_max_rad;          // the lag saturates here
    };

    explicit PositionLoop(const Params &params) : p_(params)
    {
    }

    void reset(double position_rad, double speed_rad_s)
    {
        position_ = position_rad;
        speed_ = speed_rad_s;
    }

    // v(d) = v_max·(√(d/B + c²) − c), at most v_max: the speed from which the profile still stops.
    double braking_speed(double distance_rad) const
    {
        const double root =
            std::sqrt(distance_rad / p_.braking_distance_rad + p_.softness * p_.softness);
        return p_.speed_max_rad_s * std::min(root - p_.softness, 1.0);
    }

    // One slow period: the speed reference, rad/s.
    double step(double target_rad, double measured_rad)
    {
        const double lag = std::clamp(position_ - measured_rad, -p_.lag_max_rad, p_.lag_max_rad);
        const double correction =
            std::clamp(p_.gain_1_s * lag, -p_.speed_max_rad_s, p_.speed_max_rad_s);
        const double distance = target_rad - position_;
        const double wanted = std::copysign(braking_speed(std::abs(distance)), distance);

        speed_ += std::clamp(wanted - speed_, -p_.ramp_rad_s, p_.ramp_rad_s);
        position_ += speed_ * p_.slow_period_s;
        return speed_ + correction;
    }

    double position() const
    {
        return position_;
    }

    double speed() const
    {
        return speed_;
    }

private:
    Params p_;
    double position_ = 0;
    double speed_ = 0;
};

} // namespace nf::twin
