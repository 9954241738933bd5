// SPDX-License-Identifier: MIT
#include "numbers.h"

#include <algorithm>

namespace nf
{

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

namespace
{

// The motion loops by what the motor can do: its largest torque T_max = 1.5·P·φ·I_max on its inertia J.
//
// Speed: full torque at an error of 1/(2·ζ·4.3) = 12 % of rated speed (ζ = 1). A faster loop turns the ripple of
// the estimate into torque: with dead time 2 % of ripple is then a fifth of the torque.
constexpr double SPEED_PER_TORQUE = 4.3;
// Ramp and profile leave the rest of the torque to the load.
constexpr double RAMP_TORQUE = 0.27;
constexpr double PROFILE_TORQUE = 0.2;
constexpr double PROFILE_SPEED = 0.5; // of rated
// The position loop below the speed loop, and the soft end of its profile in units of 1/bandwidth.
constexpr double POSITION_SHARE = 1 / 2.8;
constexpr double SOFTNESS = 0.3;
// The voltage's speed PI: share of φ, as the EMF is φ for 1 rad/s, and its corner. Chosen with motor B: the currents'
// own damping, R/L = 17…30/s, allows no faster loop.
constexpr double VOLTAGE_PER_FLUX = 1;
constexpr double VOLTAGE_CORNER_S = 8;
// The lead of a braking drive stays this share above −atan(R/(ω·L_d)), where more voltage means less torque.
constexpr double BRAKE_SHARE = 0.8;

using T = TuningSettings;

// What a tuning may leave to the motor, and the key that weighs most in the rule.
struct Rule {
    const char *key;
    double T::*value;
    const char *from;
};
constexpr Rule RULES[] = {
    {"speed_loop.bandwidth_hz", &T::speed_bandwidth_hz, "motor.inertia_kg_m2"},
    {"speed_loop.ramp_rpm_s", &T::speed_ramp_rpm_s, "motor.inertia_kg_m2"},
    {"position_loop.bandwidth_hz", &T::position_bandwidth_hz, "motor.inertia_kg_m2"},
    {"position_loop.speed_rpm", &T::position_speed_rpm, "motor.rated_speed_rpm"},
    {"position_loop.acceleration_rad_s2", &T::position_acceleration_rad_s2, "motor.inertia_kg_m2"},
    {"position_loop.softness_s", &T::position_softness_s, "motor.inertia_kg_m2"},
    {"voltage_loop.kp_v_s_per_rad", &T::voltage_kp_v_s_per_rad, "motor.flux_linkage_wb"},
    {"voltage_loop.ki_v_per_rad", &T::voltage_ki_v_per_rad, "motor.flux_linkage_wb"},
    {"phase_compensator.brake_max_deg", &T::brake_max_deg, "motor.resistance_ohm"},
};

const Rule &rule_of(double T::*value)
{
    return *std::find_if(std::begin(RULES), std::end(RULES),
                         [&](const Rule &rule) { return rule.value == value; });
}

} // namespace

const char *rule_source(const std::string &key, const TuningSettings &as_written)
{
    const auto rule = std::find_if(std::begin(RULES), std::end(RULES),
                                   [&](const Rule &any) { return any.key == key; });
    const bool is_left_open = rule != std::end(RULES) && as_written.*rule->value <= 0;
    return is_left_open ? rule->from : nullptr;
}

TuningSettings for_motor(const TuningSettings &tuning, const MotorSettings &motor,
                         const RuleRanges &ranges)
{
    const double torque = 1.5 * motor.pole_pairs * motor.flux_linkage_wb * motor.max_current_a;
    const double acceleration = torque / motor.inertia_kg_m2;
    TuningSettings t = tuning;
    const auto fill = [&](double T::*setting, double value) {
        if (!(t.*setting > 0)) {
            const auto range = ranges.find(rule_of(setting).key);
            t.*setting = range == ranges.end()
                             ? value
                             : std::clamp(value, range->second.least, range->second.most);
        }
    };
    fill(&T::speed_bandwidth_hz,
         SPEED_PER_TORQUE * acceleration / rad_s_from_rpm(motor.rated_speed_rpm) / TWO_PI);
    fill(&T::speed_ramp_rpm_s, RAMP_TORQUE * acceleration / rad_s_from_rpm(1));
    fill(&T::position_bandwidth_hz, POSITION_SHARE * t.speed_bandwidth_hz);
    fill(&T::position_speed_rpm,
         std::min(PROFILE_SPEED * motor.rated_speed_rpm, motor.max_speed_rpm));
    fill(&T::position_acceleration_rad_s2, PROFILE_TORQUE * acceleration);
    fill(&T::position_softness_s, SOFTNESS / (TWO_PI * t.position_bandwidth_hz));
    fill(&T::voltage_kp_v_s_per_rad, VOLTAGE_PER_FLUX * motor.flux_linkage_wb);
    fill(&T::voltage_ki_v_per_rad, VOLTAGE_CORNER_S * t.voltage_kp_v_s_per_rad);
    const double reactance =
        rad_s_from_rpm(motor.rated_speed_rpm) * motor.pole_pairs * motor.inductance_d_h;
    fill(&T::brake_max_deg,
         BRAKE_SHARE * std::atan(motor.resistance_ohm / reactance) * 360 / TWO_PI);
    return t;
}

TuningSettings for_sensor(const TuningSettings &tuning)
{
    TuningSettings t = tuning;
    if (t.angle_source == AngleSource::sensor) {
        t.startup_current_pct = 0;
        t.observer_kappa = 0;
        t.observer_kappa_p = 0;
        t.observer_momentum = 0;
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
