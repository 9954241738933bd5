/* SPDX-License-Identifier: MIT */
// Paper B (1)–(11): the motor in rotor coordinates, not linearised.
#pragma once

#include "settings.h"

#include <Eigen/Dense>

namespace nf::design
{

// What the equations need of the motor.
struct Machine {
    double resistance_ohm;
    double inductance_d_h;
    double inductance_q_h;
    double flux_linkage_wb;
    double torque_factor; // K_T = 3/2·P of (8)
    double inertia_kg_m2; // as (9) has it, see linear_model.h
    double viscous_friction_nm_s;
};

// From the motor file; `inertia_kg_m2` is the nominal point's.
Machine make_machine(const MotorSettings &motor, double inertia_kg_m2);

struct Currents {
    double q_a;
    double d_a;
};

struct Voltages {
    double q_v;
    double d_v;
};

// (1), (2), with the signs of (6), (7): the voltages that hold currents at an electrical speed.
Voltages steady_voltages(const Machine &m, const Currents &i, double speed_rad_s);

// The inverse of steady_voltages.
Currents steady_currents(const Machine &m, const Voltages &v, double speed_rad_s);

// (8), N·m, motoring positive.
double torque(const Machine &m, const Currents &i);

// (3), N·m: torque of a machine without resistance at a lead angle of its voltage. The paper's E
// and V are effective values of a phase; here they are peak values, so 3 becomes 3/2.
double torque_of_angle(const Machine &m, int pole_pairs, double voltage_v, double lead_rad,
                       double speed_rad_s);

// v_q = V·cos δ, v_d = V·sin δ: the directions that (19) has in its fourth column.
Voltages voltages_at(double voltage_v, double torque_angle_rad);

// (13) with the voltages as magnitude: the angle is a state.
struct Drive {
    double voltage_v;
    double load_nm;
    double supply_rad_s; // ω_s
};

// (11): the derivative of [i_q, i_d, ω_r, δ], (12) in the order of (46), from (4)–(7), (8), (9)
// with the motor's signs, (10).
Eigen::Vector4d derivative(const Machine &m, const Eigen::Vector4d &x, const Drive &drive);

} // namespace nf::design
