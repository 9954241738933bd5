/* SPDX-License-Identifier: MIT */
// The motor as the conversion knows it: what the controller believes of it, and the currents of its
// name plate.
#pragma once

#include "numbers.h"
#include "settings.h"

namespace nf
{

// Slower than this share of the highest speed is standing: what a motor can feed back there is lost
// in its own resistance but for a watt.
constexpr double STANDSTILL = 1.0 / 64;

// What the controller believes of the motor, in SI units.
struct Model {
    double resistance, inductance_d, inductance_q, flux, inertia;
    double flux_current;        // φ/L_d
    double torque_acceleration; // electrical rad/s² per ampere of i_q
    double max_speed_el;
};

Model make_model(const MotorSettings &motor, const ModelScales &scale);

// Peak phase current of rated torque, i_d = 0.
double rated_current(const MotorSettings &motor);

// Peak phase current for ever: the motor file's, else that of rated torque; and the key that says
// so.
double continuous_current(const MotorSettings &motor);
Source continuous_source(const MotorSettings &motor);

} // namespace nf
