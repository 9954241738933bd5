/* SPDX-License-Identifier: MIT */
// Current control in the rotor frame, in A, V and rad/s: PI an axis, decoupling by the motor
// equations (1), (2) of paper A (the resistance by the reference), voltage limited to a circle with
// the d axis first.
#pragma once

#include "twin_pi.h"
#include "twin_transforms.h"

#include <algorithm>
#include <cmath>

namespace nf::twin
{

class CurrentLoop
{
public:
    struct Params {
        Pi::Params pi_d; // V per A
        Pi::Params pi_q;
        double inductance_d_h;
        double inductance_q_h;
        double flux_wb;
        double resistance_ohm;
    };

    explicit CurrentLoop(const Params &params) : p_(params), pi_d_(params.pi_d), pi_q_(params.pi_q)
    {
    }

    // Both integrals, V.
    void reset(const Vector &integral_v)
    {
        pi_d_.reset(integral_v.x());
        pi_q_.reset(integral_v.y());
    }

    // What holds for a slow period: ω·L along d and q, and R·i* with the EMF of the flux along q.
    struct Plan {
        Vector reactance_ohm = Vector::Zero();
        Vector constant_v = Vector::Zero();
    };

    Plan plan(const Vector &reference_a, double speed_rad_s) const
    {
        return {speed_rad_s * Vector(p_.inductance_d_h, p_.inductance_q_h),
                p_.resistance_ohm * reference_a + Vector(0, speed_rad_s * p_.flux_wb)};
    }

    // The voltage that the model needs for this current, V.
    static Vector model(const Plan &plan, const Vector &measured_a)
    {
        return plan.constant_v + Vector(-plan.reactance_ohm.y() * measured_a.y(),
                                        plan.reactance_ohm.x() * measured_a.x());
    }

    // One tick: the voltage to apply, V; limit_v is the radius of the circle.
    Vector step(const Plan &plan, const Vector &reference_a, const Vector &measured_a,
                double limit_v)
    {
        const Vector error = reference_a - measured_a;
        const Vector known = model(plan, measured_a);
        Vector v(pi_d_.step(error.x(), known.x(), limit_v),
                 pi_q_.step(error.y(), known.y(), limit_v));
        // Braking, v_d comes second, see current_loop.c.
        second_ = plan.reactance_ohm.y() * reference_a.y() < 0.0 ? 0 : 1;
        v(second_) = within(v(second_), v(1 - second_), limit_v, second_ == 0 ? pi_d_ : pi_q_);
        return v;
    }

    // The circle has cut an axis in the last tick.
    bool cut() const
    {
        return cut_;
    }

    // The axis that came second in the last tick, 0 or 1.
    int second() const
    {
        return second_;
    }

    const Pi &pi_d() const
    {
        return pi_d_;
    }

    const Pi &pi_q() const
    {
        return pi_q_;
    }

private:
    double within(double voltage, double other, double limit_v, Pi &pi)
    {
        const double room = std::sqrt(std::max(0.0, limit_v * limit_v - other * other));

        cut_ = std::abs(voltage) > room;
        if (!cut_) {
            return voltage;
        }
        const double allowed = std::copysign(room, voltage);
        pi.unwind(voltage - allowed);
        return allowed;
    }

    Params p_;
    Pi pi_d_;
    Pi pi_q_;
    bool cut_ = false;
    int second_ = 1;
};

} // namespace nf::twin
