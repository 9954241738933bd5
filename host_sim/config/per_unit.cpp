#include "per_unit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double PI = 3.14159265358979323846;
constexpr double TWO_PI = 2 * PI;
constexpr double STEPS_PER_TURN = 4294967296.0; // step_t and angle_t: 2^32
constexpr double Q12 = 4096.0;
constexpr double Q13 = 8192.0;
constexpr double Q14 = 16384.0;
constexpr double Q15 = 32768.0;
constexpr double Q27 = 134217728.0;
constexpr double Q30 = 1073741824.0;
constexpr double MANTISSA_MAX = 32767.0;

// The converter's full scale is half the current base, so that no vector of three currents overflows.
constexpr double CURRENT_BASE_RATIO = 2.0;
// The estimate may overshoot the highest speed asked for.
constexpr double ESTIMATE_HEADROOM = 1.25;
// The current PI integrates at least this much faster than the motor's own R/L would: disturbances
// (dead time, EMF error) decay within ten times the closed-loop time constant.
constexpr double INTEGRAL_RATIO = 0.1;
// The profile brakes with this share of its acceleration, so that it can follow its own curve.
constexpr double BRAKING_SHARE = 0.9;
// The bus reciprocal covers this share of the under-voltage limit.
constexpr double BUS_FLOOR = 0.8;

double rad_s_from_rpm(double rpm)
{
    return rpm * TWO_PI / 60.0;
}

// A number rounded to an integer field, refused where the field cannot hold it.
template <typename Field>
void store(Field &field, double value, double lo, double hi, const char *key, double setting,
           const char *what)
{
    const double rounded = std::round(value);
    if (std::isnan(rounded) || rounded < lo || rounded > hi) {
        throw SettingError(key, setting,
                           fmt::format("a value for which {} is within {:g}…{:g} (is {:g})", what,
                                       lo, hi, rounded));
    }
    field = static_cast<Field>(rounded);
}

struct Mantissa {
    int32_t value;
    uint32_t shift;
};

// value ≈ mantissa / 2^shift with as many significant bits as the shift range allows.
Mantissa normalise(double value, int shift_min, int shift_max, const char *key, double setting,
                   const char *what)
{
    const double largest = std::ldexp(MANTISSA_MAX, -shift_min);
    if (std::isnan(value) || value < 0 || value > largest) {
        throw SettingError(
            key, setting,
            fmt::format("a value for which {} is at most {:g} (is {:g})", what, largest, value));
    }
    int shift = shift_max;
    while (shift > shift_min && std::round(std::ldexp(value, shift)) > MANTISSA_MAX) {
        shift--;
    }
    return {static_cast<int32_t>(std::lround(std::ldexp(value, shift))),
            static_cast<uint32_t>(shift)};
}

struct Model {
    double resistance, inductance_d, inductance_q, flux, inertia;
    double flux_current;        // φ/L_d
    double torque_acceleration; // electrical rad/s² per ampere of i_q
    double max_speed_el;
};

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

// Paper A (14) by forward Euler multiplies a rotating error by |1 − T/τ − jωT| a sample.
double euler_speed_limit(double period, double resistance, double inductance)
{
    const double decay = period * resistance / inductance;
    return std::sqrt(std::max(0.0, decay * (2.0 - decay))) / period;
}

void check_euler(const MotorSettings &motor, const Model &m, double period)
{
    const double inductance = std::max(m.inductance_d, m.inductance_q);
    const double limit = euler_speed_limit(period, m.resistance, inductance);
    if (m.max_speed_el > limit) {
        const double limit_rpm = limit / motor.pole_pairs * 60.0 / TWO_PI;
        throw SettingError(
            "motor.max_speed_rpm", motor.max_speed_rpm,
            fmt::format(
                "at most {:.6g} rpm ({:.6g} rad/s electrical, √(2/(T·τ)) less the decay): the "
                "observer's forward-Euler network grows above it; a higher "
                "board.pwm_frequency_hz raises it",
                limit_rpm, limit));
    }
}

sampling_cfg_t make_sampling(const BoardSettings &board)
{
    sampling_cfg_t c{};
    store(c.current_shift, 15 - board.adc_bits, 0, 7, "board.adc_bits", board.adc_bits,
          "15 − bits");
    store(c.bus_shift, 15 - board.adc_bits, 0, 7, "board.adc_bits", board.adc_bits, "15 − bits");
    store(c.offset_log2, board.offset_samples_log2, 0, 12, "board.offset_samples_log2",
          board.offset_samples_log2, "the exponent");
    return c;
}

protection_cfg_t make_protection(const BoardSettings &board, const Bases &b)
{
    protection_cfg_t c{};
    const double top = MANTISSA_MAX - 1;
    store(c.current_max, board.overcurrent_a / b.current_a * Q15, 1, Q14 - 2, "board.overcurrent_a",
          board.overcurrent_a, "its share of board.current_full_scale_a in Q15");
    store(c.bus_max, board.bus_max_v / b.voltage_v * Q15, 1, top, "board.bus_max_v",
          board.bus_max_v, "its share of board.bus_full_scale_v in Q15");
    store(c.bus_min, board.bus_min_v / b.voltage_v * Q15, 0, c.bus_max, "board.bus_min_v",
          board.bus_min_v, "its share of board.bus_full_scale_v in Q15");
    store(c.offset_max, board.offset_max_a / b.current_a * Q15, 0, MANTISSA_MAX,
          "board.offset_max_a", board.offset_max_a,
          "its share of board.current_full_scale_a in Q15");
    return c;
}

// The base of the observer's states, I_x = 2^s·I_b: both states of full-scale current fit.
int observer_shift(const MotorSettings &motor, const Model &m, const Bases &b)
{
    const double largest =
        std::max(1.0 + m.flux_current / b.current_a, m.inductance_q / m.inductance_d);
    int shift = 0;
    while (std::ldexp(1.0, shift) <= largest) {
        shift++;
    }
    if (shift > 10) {
        throw SettingError("motor.flux_linkage_wb", motor.flux_linkage_wb,
                           "a flux for which φ/L_d is below 1023 times board.current_full_scale_a");
    }
    return shift;
}

nn_observer_cfg_t make_observer(const MotorSettings &motor, const TuningSettings &tuning,
                                const Model &m, const Bases &b)
{
    const double period = b.control_period_s;
    const int s = observer_shift(motor, m, b);
    const double base_x = std::ldexp(b.current_a, s);
    const double decay_d = period * m.resistance / m.inductance_d;
    const double decay_q = period * m.resistance / m.inductance_q;
    // b(k) is a product in Q15 of I_b times Q15 of I_x; 4/2π turns radians in Q30 into steps.
    const double steps = b.current_a * base_x / (m.flux_current * m.flux_current) * 4.0 / TWO_PI;
    const double rate = tuning.observer_kappa * (1.0 - tuning.observer_momentum) * steps;
    nn_observer_cfg_t c{};

    const double volt_gain = period / m.inductance_d * b.voltage_v / base_x;
    const Mantissa largest = normalise(std::ldexp(std::max({decay_d, decay_q, volt_gain}), 12), 2,
                                       15, "motor.inductance_d_h", motor.inductance_d_h,
                                       "the larger of T·R/L and T/L·U_b/I_x, times 4096,");
    c.weight_shift = largest.shift;
    const double weight = std::ldexp(1.0, 12 + static_cast<int>(largest.shift));
    c.decay_d = static_cast<int32_t>(std::lround(decay_d * weight));
    c.decay_q = static_cast<int32_t>(std::lround(decay_q * weight));
    c.volt_gain = static_cast<int32_t>(std::lround(volt_gain * weight));
    store(c.flux_q27, m.flux_current / base_x * Q27, 1, Q27 - 1, "motor.flux_linkage_wb",
          motor.flux_linkage_wb, "(φ/L_d)/I_x in Q27");
    store(c.flux_drive_q27, decay_d * m.flux_current / base_x * Q27, 0, Q27 / 2,
          "motor.flux_linkage_wb", motor.flux_linkage_wb, "the constant of v_x in Q27");
    store(c.iq_gain_q14, m.inductance_d / m.inductance_q * Q14, 1, MANTISSA_MAX,
          "motor.inductance_d_h", motor.inductance_d_h, "L_d/L_q in Q14");
    c.current_shift = static_cast<uint32_t>(s);
    const Mantissa eta = normalise(std::ldexp(rate, 14), 1, 30, "observer.kappa",
                                   tuning.observer_kappa, "the learning rate");
    c.rate = eta.value;
    c.rate_shift = eta.shift;
    const Mantissa prop =
        normalise(std::ldexp(tuning.observer_kappa_p * steps, 14), 1, 30, "observer.kappa_p",
                  tuning.observer_kappa_p, "the proportional path");
    c.proportional = prop.value;
    c.proportional_shift = prop.shift;
    store(c.momentum_q15, tuning.observer_momentum * Q15, 0, MANTISSA_MAX, "observer.momentum",
          tuning.observer_momentum, "α in Q15");
    check_euler(motor, m, period);
    const double euler =
        euler_speed_limit(period, m.resistance, std::max(m.inductance_d, m.inductance_q));
    const double limit = std::min(m.max_speed_el * ESTIMATE_HEADROOM, euler);
    store(c.speed_limit, limit * period / TWO_PI * STEPS_PER_TURN, 1, Q30 / 2,
          "motor.max_speed_rpm", motor.max_speed_rpm, "the advance per tick in steps");
    return c;
}

pi_cfg_t make_pi(double kp, double ki, const char *key, double setting)
{
    const Mantissa p = normalise(kp, 1, 30, key, setting, "the proportional gain per unit");
    const Mantissa i =
        normalise(std::ldexp(ki, 11), 1, 30, key, setting, "the integral gain per unit and period");
    pi_cfg_t c{};
    c.kp = p.value;
    c.kp_shift = p.shift;
    c.ki = i.value;
    c.ki_shift = i.shift;
    return c;
}

// Pole of the closed loop at the bandwidth, zero of the PI on the motor's R/L or INTEGRAL_RATIO above.
pi_cfg_t make_current_pi(const TuningSettings &tuning, const Model &m, const Bases &b,
                         double inductance)
{
    const double omega = TWO_PI * tuning.current_bandwidth_hz;
    const double kp = omega * inductance * b.current_a / b.voltage_v;
    const double corner = std::max(m.resistance / inductance, omega * INTEGRAL_RATIO);
    return make_pi(kp, kp * corner * b.control_period_s, "current_loop.bandwidth_hz",
                   tuning.current_bandwidth_hz);
}

current_loop_cfg_t make_current_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                     const Model &m, const Bases &b)
{
    const double reactance = b.speed_el_rad_s * b.current_a / b.voltage_v * Q13;
    current_loop_cfg_t c{};
    c.pi_d = make_current_pi(tuning, m, b, m.inductance_d);
    c.pi_q = make_current_pi(tuning, m, b, m.inductance_q);
    store(c.reactance_d_q13, reactance * m.inductance_d, 0, MANTISSA_MAX, "motor.inductance_d_h",
          motor.inductance_d_h, "Ω_b·L_d·I_b/U_b in Q13");
    store(c.reactance_q_q13, reactance * m.inductance_q, 0, MANTISSA_MAX, "motor.inductance_q_h",
          motor.inductance_q_h, "Ω_b·L_q·I_b/U_b in Q13");
    store(c.emf_q13, b.speed_el_rad_s * m.flux / b.voltage_v * Q13, 0, MANTISSA_MAX,
          "motor.flux_linkage_wb", motor.flux_linkage_wb, "Ω_b·φ/U_b in Q13");
    return c;
}

// Steps by which the speed changes in a slow period at an electrical acceleration.
double ramp_steps(double acceleration_el, const TuningSettings &tuning, const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    return acceleration_el * slow_period * b.control_period_s / TWO_PI * STEPS_PER_TURN;
}

speed_loop_cfg_t make_speed_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                 const Model &m, const Bases &b)
{
    const double omega = TWO_PI * tuning.speed_bandwidth_hz;
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    // The error between full speed one way and the other fits 2·Ω_b.
    const double per_unit = 2 * b.speed_el_rad_s / b.current_a / m.torque_acceleration;
    const double one_step_ramp = ramp_steps(1.0, tuning, b); // steps for 1 rad/s²
    speed_loop_cfg_t c{};
    c.pi =
        make_pi(2 * tuning.speed_damping * omega * per_unit, omega * omega * per_unit * slow_period,
                "speed_loop.bandwidth_hz", tuning.speed_bandwidth_hz);
    store(c.ramp, rad_s_from_rpm(tuning.speed_ramp_rpm_s) * motor.pole_pairs * one_step_ramp, 1,
          Q30 / 2, "speed_loop.ramp_rpm_s", tuning.speed_ramp_rpm_s, "the ramp in steps");
    store(c.speed_max, b.step_from_rpm(motor.max_speed_rpm), 1, Q30 / 2, "motor.max_speed_rpm",
          motor.max_speed_rpm, "the advance per tick in steps");
    store(c.current_max, motor.max_current_a / b.current_a * Q15, 1, Q14, "motor.max_current_a",
          motor.max_current_a, "its share of board.current_full_scale_a in Q15");
    const double current_per_step =
        tuning.inertia_feed_forward / one_step_ramp / m.torque_acceleration / b.current_a * Q15;
    const Mantissa inertia =
        normalise(std::ldexp(current_per_step, 16), 0, 30, "motor.inertia_kg_m2",
                  motor.inertia_kg_m2, "the acceleration feed-forward");
    c.inertia = inertia.value;
    c.inertia_shift = inertia.shift;
    c.error_shift = static_cast<uint32_t>(b.speed_shift) + 1U;
    return c;
}

// The profile's braking distance in units of 2^shift Q32 turns, 2^13…2^14 of them.
void store_braking(position_loop_cfg_t &c, const TuningSettings &tuning, const Bases &b)
{
    const double speed = rad_s_from_rpm(tuning.position_speed_rpm);
    const double brake = tuning.position_acceleration_rad_s2 * BRAKING_SHARE;
    const double distance_q32 = b.turns_from_mech_rad(speed * speed / (2 * brake)) * STEPS_PER_TURN;
    int shift = 8;
    while (std::ldexp(distance_q32, -shift) >= Q14) {
        shift++;
    }
    store(c.distance_shift, shift, 8, 48, "position_loop.speed_rpm", tuning.position_speed_rpm,
          "the braking distance exponent");
    store(c.braking_inverse, Q30 / std::ldexp(distance_q32, -shift), 2 * Q15, 4 * Q15,
          "position_loop.speed_rpm", tuning.position_speed_rpm, "the inverse braking distance");
    store(c.softness_q15, brake * tuning.position_softness_s / speed * Q15, 0, 12288,
          "position_loop.softness_s", tuning.position_softness_s,
          "softness·acceleration/speed in Q15");
}

position_loop_cfg_t make_position_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b)
{
    position_loop_cfg_t c{};
    const double acceleration = tuning.position_acceleration_rad_s2 * motor.pole_pairs;
    store(c.ramp, ramp_steps(acceleration, tuning, b), 1, Q30 / 2,
          "position_loop.acceleration_rad_s2", tuning.position_acceleration_rad_s2,
          "the ramp in steps");
    store(c.speed_max, b.step_from_rpm(tuning.position_speed_rpm), 1, Q30 / 2,
          "position_loop.speed_rpm", tuning.position_speed_rpm, "the advance per tick in steps");
    store_braking(c, tuning, b);
    const double gain = TWO_PI * tuning.position_bandwidth_hz * b.control_period_s * 65536.0;
    const Mantissa g = normalise(gain, 0, 30, "position_loop.bandwidth_hz",
                                 tuning.position_bandwidth_hz, "the position gain");
    c.gain = g.value;
    c.gain_shift = g.shift;
    return c;
}

modulator_cfg_t make_modulator(const BoardSettings &board, const Bases &b)
{
    modulator_cfg_t c{};
    store(c.timer_counts, board.timer_clock_hz / (2 * board.pwm_frequency_hz), 1, MANTISSA_MAX,
          "board.timer_clock_hz", board.timer_clock_hz, "clock/(2·board.pwm_frequency_hz)");
    store(c.ratio_max_q15, (1 - board.duty_margin_pct / 100) / std::sqrt(3.0) * Q15 - 0.5, 1, 18918,
          "board.duty_margin_pct", board.duty_margin_pct, "the largest voltage ratio in Q15");
    store(c.inverse_max_q12, b.voltage_v / (board.bus_min_v * BUS_FLOOR) * Q12, Q12, MANTISSA_MAX,
          "board.bus_min_v", board.bus_min_v, "board.bus_full_scale_v/(0.8·bus_min) in Q12");
    return c;
}

} // namespace

SettingError::SettingError(std::string key_, double value_, std::string allowed_)
    : std::runtime_error(fmt::format("{} = {:g}: allowed is {}", key_, value_, allowed_)),
      key(std::move(key_)), value(value_), allowed(std::move(allowed_))
{
}

double Bases::step_from_rpm(double rpm) const
{
    return rad_s_from_rpm(rpm) * pole_pairs * control_period_s / TWO_PI * STEPS_PER_TURN;
}

double Bases::rpm_from_step(double step) const
{
    return step / step_from_rpm(1.0);
}

double Bases::turns_from_mech_rad(double rad) const
{
    return rad * pole_pairs / TWO_PI;
}

double calibration_time(const BoardSettings &board)
{
    return (std::exp2(board.offset_samples_log2) + 1) / board.pwm_frequency_hz;
}

Bases make_bases(const MotorSettings &motor, const BoardSettings &board)
{
    Bases b{};
    b.control_period_s = 1.0 / board.pwm_frequency_hz;
    b.current_a = board.current_full_scale_a * CURRENT_BASE_RATIO;
    b.voltage_v = board.bus_full_scale_v;
    b.pole_pairs = motor.pole_pairs;
    const double largest = b.step_from_rpm(motor.max_speed_rpm) * ESTIMATE_HEADROOM;
    b.speed_shift = 1;
    while (std::ldexp(Q15, b.speed_shift) < largest && b.speed_shift < 16) {
        b.speed_shift++;
    }
    b.speed_el_rad_s =
        std::ldexp(Q15, b.speed_shift) / STEPS_PER_TURN * TWO_PI / b.control_period_s;
    return b;
}

drive_cfg_t make_drive_cfg(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &tuning, const ModelScales &scales)
{
    const Bases b = make_bases(motor, board);
    const Model m = make_model(motor, scales);
    drive_cfg_t c{};
    c.sampling = make_sampling(board);
    c.protection = make_protection(board, b);
    c.observer = make_observer(motor, tuning, m, b);
    c.current_loop = make_current_loop(motor, tuning, m, b);
    c.speed_loop = make_speed_loop(motor, tuning, m, b);
    c.position_loop = make_position_loop(motor, tuning, b);
    c.modulator = make_modulator(board, b);
    c.speed_shift = static_cast<uint32_t>(b.speed_shift);
    store(c.slow_ticks, tuning.slow_ticks, 2, 100, "speed_loop.slow_ticks", tuning.slow_ticks,
          "control ticks per slow period");
    if (const char *bad = params_check(&c)) {
        throw SettingError(bad, 0, "what params_check accepts");
    }
    return c;
}

} // namespace nf
