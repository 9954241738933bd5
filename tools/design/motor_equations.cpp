// SPDX-License-Identifier: MIT
#include "motor_equations.h"

#include "matrices.h"

#include <cmath>

namespace nf::design
{
namespace
{

double flux_d(const Machine &m, double i_d_a) // (4)
{
    return m.flux_linkage_wb + m.inductance_d_h * i_d_a;
}

double flux_q(const Machine &m, double i_q_a) // (5)
{
    return m.inductance_q_h * i_q_a;
}

} // namespace

Machine make_machine(const MotorSettings &motor, double inertia_kg_m2)
{
    return {motor.resistance_ohm,       motor.inductance_d_h,   motor.inductance_q_h,
            motor.flux_linkage_wb,      1.5 * motor.pole_pairs, inertia_kg_m2,
            motor.viscous_friction_nm_s};
}

Voltages steady_voltages(const Machine &m, const Currents &i, double speed_rad_s)
{
    return {m.resistance_ohm * i.q_a + speed_rad_s * flux_d(m, i.d_a),
            m.resistance_ohm * i.d_a - speed_rad_s * flux_q(m, i.q_a)};
}

Currents steady_currents(const Machine &m, const Voltages &v, double speed_rad_s)
{
    Eigen::Matrix2d impedance;
    impedance << m.resistance_ohm, speed_rad_s * m.inductance_d_h, -speed_rad_s * m.inductance_q_h,
        m.resistance_ohm;
    const Eigen::Vector2d driving(v.q_v - speed_rad_s * m.flux_linkage_wb, v.d_v);
    const Eigen::Vector2d currents = impedance.inverse() * driving;
    return {currents[0], currents[1]};
}

double torque(const Machine &m, const Currents &i)
{
    return m.torque_factor *
           (m.flux_linkage_wb * i.q_a + (m.inductance_d_h - m.inductance_q_h) * i.d_a * i.q_a);
}

double torque_of_angle(const Machine &m, int pole_pairs, double voltage_v, double lead_rad,
                       double speed_rad_s)
{
    const double reactance_d = speed_rad_s * m.inductance_d_h;
    const double reactance_q = speed_rad_s * m.inductance_q_h;
    const double emf_v = speed_rad_s * m.flux_linkage_wb;
    return 1.5 * pole_pairs / speed_rad_s *
           (emf_v * voltage_v / reactance_d * std::sin(lead_rad) -
            voltage_v * voltage_v / 2 * (1 / reactance_d - 1 / reactance_q) *
                std::sin(2 * lead_rad));
}

Voltages voltages_at(double voltage_v, double torque_angle_rad)
{
    return {voltage_v * std::cos(torque_angle_rad), voltage_v * std::sin(torque_angle_rad)};
}

Eigen::Vector4d derivative(const Machine &m, const Eigen::Vector4d &x, const Drive &drive)
{
    const Voltages v = voltages_at(drive.voltage_v, x[ANGLE]);
    const Voltages held = steady_voltages(m, {x[I_Q], x[I_D]}, x[SPEED]);
    const double motor_torque = torque(m, {x[I_Q], x[I_D]});
    return {(v.q_v - held.q_v) / m.inductance_q_h, (v.d_v - held.d_v) / m.inductance_d_h,
            (motor_torque - m.viscous_friction_nm_s * x[SPEED] - drive.load_nm) / m.inertia_kg_m2,
            x[SPEED] - drive.supply_rad_s};
}

} // namespace nf::design
