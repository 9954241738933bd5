// SPDX-License-Identifier: MIT
#include "motor_model.h"

namespace nf
{

Model make_model(const MotorSettings &motor, const ModelScales &scale)
{
    Model m{};
    const double p = motor.pole_pairs;
    m.resistance = motor.resistance_ohm * scale.resistance;
    m.inductance_d = motor.inductance_d_h * scale.inductance;
    m.inductance_q = motor.inductance_q_h * scale.inductance;
    m.flux = motor.flux_linkage_wb * scale.flux;
    m.inertia = motor.inertia_kg_m2 * scale.inertia;
    m.flux_current = m.flux / m.inductance_d;
    m.torque_acceleration = 1.5 * p * p * m.flux / m.inertia;
    m.max_speed_el = rad_s_from_rpm(motor.max_speed_rpm) * p;
    return m;
}

double rated_current(const MotorSettings &motor)
{
    return motor.rated_torque_nm / (1.5 * motor.pole_pairs * motor.flux_linkage_wb);
}

double continuous_current(const MotorSettings &motor)
{
    const double rated = rated_current(motor);
    const double current = motor.continuous_current_a > 0 ? motor.continuous_current_a : rated;
    return std::min(current, motor.max_current_a);
}

Source continuous_source(const MotorSettings &motor)
{
    return motor.continuous_current_a > 0
               ? Source{"motor.continuous_current_a", motor.continuous_current_a}
               : Source{"motor.rated_torque_nm", motor.rated_torque_nm};
}

} // namespace nf
