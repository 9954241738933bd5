// SPDX-License-Identifier: MIT
#include "numbers.h"

#include <algorithm>

namespace nf
{

double deepest_current(const MotorSettings &motor, const TuningSettings &tuning)
{
    const double share_a = tuning.weakening_pct / 100 * motor.max_current_a;
    const double bears_a = motor.demagnetising_current_a;
    if (tuning.method == ControlMethod::voltage_phase) {
        return 0; // its phase compensator holds i_d at 0
    }
    return bears_a > 0 ? std::min(share_a, bears_a) : share_a;
}

double largest_ratio(const BoardSettings &board)
{
    return (1 - board.duty_margin_pct / 100) / std::sqrt(3.0);
}

void require(double number, double lo, double hi, const Source &setting, const char *what)
{
    if (number >= lo && number <= hi) {
        return;
    }
    const double bound = number > hi ? hi : lo;
    const bool at_most = (number > hi) == (setting.power > 0);
    throw SettingError(setting.key, setting.value,
                       {at_most, setting.value * std::pow(bound / number, 1 / setting.power)},
                       what);
}

void require(const Source &setting, double lo, double hi, const char *what)
{
    require(setting.value, lo, hi, setting, what);
}

Mantissa normalise(double number, int shift_min, int shift_max, const Source &setting,
                   const char *what)
{
    require(number, 0, std::ldexp(MANTISSA_MAX, -shift_min), setting, what);
    int shift = shift_max;
    while (shift > shift_min && std::round(std::ldexp(number, shift)) > MANTISSA_MAX) {
        shift--;
    }
    return {static_cast<int32_t>(std::lround(std::ldexp(number, shift))),
            static_cast<uint32_t>(shift)};
}

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

pi_cfg_t make_pi(double kp, double ki, double ki_power, const char *key, double bandwidth)
{
    const char *const reason = "more is beyond the firmware's gains";
    const Mantissa p = normalise(kp, 1, 30, {key, bandwidth}, reason);
    const Mantissa i = normalise(std::ldexp(ki, 11), 1, 30, {key, bandwidth, ki_power}, reason);
    pi_cfg_t c{};
    c.kp = p.value;
    c.kp_shift = p.shift;
    c.ki = i.value;
    c.ki_shift = i.shift;
    return c;
}

TuningSettings for_sensor(const TuningSettings &tuning)
{
    TuningSettings t = tuning;
    if (t.angle_source == AngleSource::sensor) {
        t.startup_current_pct = 0;
        t.observer_kappa = 0;
        t.observer_kappa_p = 0;
        t.observer_momentum = 0;
        t.observer_acceleration = 0;
        t.pace_speed_pct = 0;
        t.kappa_speed_pct = 0;
    }
    return t;
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
