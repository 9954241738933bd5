// SPDX-License-Identifier: MIT
#include "ratings.h"

#include "modulator_units.h"
#include "motor_model.h"
#include "numbers.h"
#include "rules.h"
#include "sampling_units.h"
#include "speed_margin.h"
#include "torque_filter_units.h"

#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

// The integral law alone, κ_p = 0, is damped for κ ≳ 1.5·(ωT)²; twice as much is asked for.
constexpr double KAPPA_STABLE = 1.5;
constexpr double KAPPA_ASKED = 3;

std::string place(const Config &config, const char *key)
{
    const auto found = config.origins.find(key);
    return found == config.origins.end() ? "" : found->second.text() + ": ";
}

void note(Config &config, const char *key, double value, const std::string &what)
{
    config.scenario.notes.push_back(
        fmt::format("{}{} = {}: {}", place(config, key), key, value, what));
}

struct Currents {
    double d_a;
    double q_a;
};

// As the drive divides a current: the most torque of it, or all along q.
Currents divided(const Config &config, double current_a)
{
    const MotorSettings &m = config.motor;
    const double saliency_h = m.inductance_q_h - m.inductance_d_h;
    if (config.tuning.most_torque == 0 || saliency_h <= 0) {
        return {0, current_a};
    }
    const double flux = m.flux_linkage_wb;
    const double twice = std::sqrt(8) * saliency_h * current_a;
    const double d_a = (flux - std::hypot(flux, twice)) / (4 * saliency_h);
    return {d_a, std::sqrt(current_a * current_a - d_a * d_a)};
}

double torque_nm(const MotorSettings &m, const Currents &i)
{
    const double saliency_h = m.inductance_q_h - m.inductance_d_h;
    return 1.5 * m.pole_pairs * (m.flux_linkage_wb - saliency_h * i.d_a) * i.q_a;
}

// Of rated torque. Reluctance only saves current, so it is between none and that of the flux
// linkage alone.
Currents rated_currents(const Config &config)
{
    constexpr int HALVINGS = 50;
    double least = 0;
    double most = rated_current(config.motor);
    for (int k = 0; k < HALVINGS; k++) {
        const double middle = (least + most) / 2;
        const bool enough =
            torque_nm(config.motor, divided(config, middle)) >= config.motor.rated_torque_nm;
        (enough ? most : least) = middle;
    }
    return divided(config, most);
}

void note_torque(Config &config)
{
    const MotorSettings &m = config.motor;
    const double largest = torque_nm(m, divided(config, m.max_current_a));
    if (m.rated_torque_nm > largest) {
        note(config, "motor.rated_torque_nm", m.rated_torque_nm,
             fmt::format("motor.max_current_a = {} makes at most {:.4g} N·m", m.max_current_a,
                         largest));
    }
}

// The voltage of rated torque at rated speed against the circle that the nominal bus leaves.
void note_rated_point(Config &config)
{
    const MotorSettings &m = config.motor;
    const double omega = rad_s_from_rpm(m.rated_speed_rpm) * m.pole_pairs;
    const Currents i = rated_currents(config);
    const double along_q =
        m.resistance_ohm * i.q_a + omega * (m.flux_linkage_wb + m.inductance_d_h * i.d_a);
    const double along_d = m.resistance_ohm * i.d_a - omega * m.inductance_q_h * i.q_a;
    const double needed = std::sqrt(along_q * along_q + along_d * along_d);
    const double there = largest_ratio(config.board) * config.board.bus_nominal_v;
    if (needed > there) {
        note(config, "motor.rated_speed_rpm", m.rated_speed_rpm,
             fmt::format("with rated torque it takes {:.4g} V of phase voltage; "
                         "board.bus_nominal_v = {} and board.duty_margin_pct = {} leave {:.4g} V",
                         needed, config.board.bus_nominal_v, config.board.duty_margin_pct, there));
    }
}

// What the firmware's numbers hold of a motor on a board; it reckons with the largest then.
void note_held(Config &config, const char *key, double believed, double largest, const char *what)
{
    if (believed > largest) {
        note(config, key, believed,
             fmt::format("the firmware holds at most {:.4g} with the scales of this board and "
                         "motor.max_speed_rpm, and reckons with that: {}",
                         largest, what));
    }
}

void note_parameters(Config &config)
{
    const Bases b = make_bases(config.motor, config.board);
    const double voltage = MANTISSA_MAX / Q13 * b.voltage_v / b.speed_el_rad_s;
    const char *const coupling = "above some speed the axes are decoupled in part only";
    const double scale = config.model.inductance;
    note_held(config, "motor.inductance_d_h", config.motor.inductance_d_h * scale,
              voltage / b.current_a, coupling);
    note_held(config, "motor.inductance_q_h", config.motor.inductance_q_h * scale,
              voltage / b.current_a, coupling);
    note_held(config, "motor.flux_linkage_wb", config.motor.flux_linkage_wb * config.model.flux,
              voltage, "the EMF is fed forward in part only");
}

void note_kappa(Config &config)
{
    const TuningSettings &t = config.tuning;
    if (t.angle_source == AngleSource::sensor || t.observer_kappa_p != 0 || t.observer_kappa <= 0) {
        return;
    }
    const double turn = rad_s_from_rpm(config.motor.max_speed_rpm) * config.motor.pole_pairs /
                        config.board.pwm_frequency_hz;
    const double stable = KAPPA_STABLE * turn * turn;
    if (t.observer_kappa < KAPPA_ASKED * turn * turn) {
        note(config, "observer.kappa", t.observer_kappa,
             fmt::format("without observer.kappa_p the estimate {} at motor.max_speed_rpm = {} and "
                         "board.pwm_frequency_hz = {}; at least {:.4g} is asked for",
                         t.observer_kappa < stable ? "is not stable" : "is little damped",
                         config.motor.max_speed_rpm, config.board.pwm_frequency_hz,
                         KAPPA_ASKED * turn * turn));
    }
}

// With less a loop swings longer than it takes to settle.
constexpr double MARGIN_ASKED_DEG = 30;
constexpr double DEG_PER_RAD = 360 / TWO_PI;

void note_margin(Config &config)
{
    if (!has_torque_filter(config.tuning)) {
        return;
    }
    const TuningSettings t =
        for_sensor(by_rules(config.tuning, config.motor, config.board, config.model));
    const double period_s = 1 / config.board.pwm_frequency_hz;
    const double found =
        DEG_PER_RAD * speed_margin(t, period_s, t.speed_bandwidth_hz, TorqueFilter::as_set);
    if (found < MARGIN_ASKED_DEG) {
        const double most_hz =
            bandwidth_of_margin(t, period_s, MARGIN_ASKED_DEG / DEG_PER_RAD, t.speed_bandwidth_hz);
        note(config, "speed_loop.bandwidth_hz", t.speed_bandwidth_hz,
             fmt::format("speed_loop.notch_hz = {} and speed_loop.torque_filter_hz = {} leave {} "
                         "phase margin; up to {:.4g} Hz it is {:g}° and more",
                         t.notch_hz, t.torque_filter_hz,
                         found > 0 ? fmt::format("{:.0f}° of", found) : "no", most_hz,
                         MARGIN_ASKED_DEG));
    }
}

} // namespace

void note_ratings(Config &config)
{
    note_torque(config);
    note_rated_point(config);
    note_parameters(config);
    note_kappa(config);
    note_margin(config);
}

} // namespace nf
