// SPDX-License-Identifier: MIT
#include "linear_model.h"

#include "numbers.h"

#include <cmath>

namespace nf::design
{

Continuous linearise(const Machine &m, const NominalPoint &p)
{
    const Voltages v = voltages_at(p.voltage_v, p.torque_angle_deg * PI / 180);
    const double saliency_h = m.inductance_d_h - m.inductance_q_h;
    Continuous c;
    c.f << -m.resistance_ohm / m.inductance_q_h,
        -p.speed_rad_s * m.inductance_d_h / m.inductance_q_h,
        -(m.flux_linkage_wb + m.inductance_d_h * p.i_d_a) / m.inductance_q_h,
        -v.d_v / m.inductance_q_h, //
        p.speed_rad_s * m.inductance_q_h / m.inductance_d_h, -m.resistance_ohm / m.inductance_d_h,
        m.inductance_q_h * p.i_q_a / m.inductance_d_h, v.q_v / m.inductance_d_h, //
        m.torque_factor * (m.flux_linkage_wb + saliency_h * p.i_d_a) / m.inertia_kg_m2,
        m.torque_factor * saliency_h * p.i_q_a / m.inertia_kg_m2,
        -m.viscous_friction_nm_s / m.inertia_kg_m2, 0, //
        0, 0, 1, 0;
    c.g << 0, p.voltage_per_speed_v_s_per_rad / m.inductance_q_h, //
        0, 0,                                                     //
        -1 / m.inertia_kg_m2, 0,                                  //
        0, -1;
    return c;
}

} // namespace nf::design
