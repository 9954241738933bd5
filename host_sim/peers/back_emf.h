/* SPDX-License-Identifier: MIT */
// The winding with its extended EMF [Chen 2003], and the angle that this EMF shows:
//     v = R·i + L_d·di/dt − jω(L_d − L_q)·i + e,
//     e = j·E·exp(jθ),  E = ωφ + (L_d − L_q)·(ω·i_d − di_q/dt)
// The inductance is L_d in every direction, so saliency needs no angle here.
//
// [Chen 2003] Z. Chen, M. Tomita, S. Doki, S. Okuma: An extended electromotive force model for
// sensorless control of interior permanent-magnet synchronous motors. IEEE Trans. Ind. Electron. 50
// (2), 2003.
#pragma once

#include "estimator.h"

#include <algorithm>
#include <cmath>

namespace nf::peers
{

// i(k+1) = decay·i(k) + gain·(v − e), v and e constant in the period: exact.
struct Winding {
    explicit Winding(const Model &m)
        : decay(std::exp(-m.resistance_ohm / m.inductance_d_h * m.period_s)),
          gain(m.resistance_ohm > 0 ? (1 - decay) / m.resistance_ohm
                                    : m.period_s / m.inductance_d_h)
    {
    }

    double decay;
    double gain; // A per V
};

// What the saliency adds to the voltage on R and L_d.
inline Complex saliency_voltage(const Model &m, double speed_rad_s, Complex current_a)
{
    return J * speed_rad_s * (m.inductance_d_h - m.inductance_q_h) * current_a;
}

// sin(θ − θ̂) by an EMF, whose sign is that of the speed: the course's, where that is not about to
// change. An EMF too small to show the angle shows less.
inline double emf_angle_error(const Model &m, Complex emf_v, const Estimate &now,
                              double course_rad_s)
{
    const double across = (emf_v * std::conj(J * turn(now.angle_rad))).imag();
    const double least = m.flux_wb * m.speed_min_rad_s;
    const bool steady = std::abs(course_rad_s) >= m.speed_min_rad_s;
    const double direction = std::copysign(1.0, steady ? course_rad_s : now.speed_rad_s);
    return direction * across / std::max(std::abs(emf_v), least);
}

} // namespace nf::peers
