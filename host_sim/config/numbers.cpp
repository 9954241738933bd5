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

void fill(double &setting, double value)
{
    if (!(setting > 0)) {
        setting = value;
    }
}

} // namespace

TuningSettings for_motor(const TuningSettings &tuning, const MotorSettings &motor)
{
    const double torque = 1.5 * motor.pole_pairs * motor.flux_linkage_wb * motor.max_current_a;
    const double acceleration = torque / motor.inertia_kg_m2;
    TuningSettings t = tuning;
    fill(t.speed_bandwidth_hz,
         SPEED_PER_TORQUE * acceleration / rad_s_from_rpm(motor.rated_speed_rpm) / TWO_PI);
    fill(t.speed_ramp_rpm_s, RAMP_TORQUE * acceleration / rad_s_from_rpm(1));
    fill(t.position_bandwidth_hz, POSITION_SHARE * t.speed_bandwidth_hz);
    fill(t.position_speed_rpm, PROFILE_SPEED * motor.rated_speed_rpm);
    fill(t.position_acceleration_rad_s2, PROFILE_TORQUE * acceleration);
    fill(t.position_softness_s, SOFTNESS / (TWO_PI * t.position_bandwidth_hz));
    fill(t.voltage_kp_v_s_per_rad, VOLTAGE_PER_FLUX * motor.flux_linkage_wb);
    fill(t.voltage_ki_v_per_rad, VOLTAGE_CORNER_S * t.voltage_kp_v_s_per_rad);
    const double reactance =
        rad_s_from_rpm(motor.rated_speed_rpm) * motor.pole_pairs * motor.inductance_d_h;
    fill(t.brake_max_deg, BRAKE_SHARE * std::atan(motor.resistance_ohm / reactance) * 360 / TWO_PI);
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

double continuous_current(const MotorSettings &motor)
{
    const double rated = motor.rated_torque_nm / (1.5 * motor.pole_pairs * motor.flux_linkage_wb);
    const double current = motor.continuous_current_a > 0 ? motor.continuous_current_a : rated;
    return std::min(current, motor.max_current_a);
}

} // namespace nf
