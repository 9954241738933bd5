/* SPDX-License-Identifier: MIT */
// Paper B (14)–(24): the motor linearised at the nominal point.
//
// One ω_r serves (6), (7), (9) and (10) in the paper: electrical speed in the first two and the
// last, mechanical in (9). Its J is then the moment of inertia over the number of pole pairs, and B
// likewise.
#pragma once

#include "matrices.h"
#include "motor_equations.h"

namespace nf::design
{

// Where the paper linearises, section 4.
struct NominalPoint {
    double speed_rad_s = 0;      // electrical
    double voltage_v = 0;        // V
    double torque_angle_deg = 0; // δ0
    double i_q_a = 0;
    double i_d_a = 0;
    double inertia_kg_m2 = 0;                 // J of (9)
    double voltage_per_speed_v_s_per_rad = 0; // K_b of (23)
    double sample_time_s = 0;                 // T of (25)
    double k2 = 1;                            // K_2 of (42): 1 where the angle's detector is true
};

// (16) with the inputs of (24).
struct Continuous {
    MotorMatrix f; // (19)
    MotorInputs g; // (24)
};

// (19), (24) by formula. (20) has the voltages as inputs; (22), (23) make them V_q = K_b·ω_s, V_d =
// 0.
Continuous linearise(const Machine &m, const NominalPoint &p);

} // namespace nf::design
