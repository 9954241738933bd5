// SPDX-License-Identifier: MIT
#include "specimen.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf::zoo
{
namespace
{

constexpr double PER_CENT = 0.01;

// What all classes share.
constexpr double BUS_CURRENT_MAX_A = 120; // nobody winds a motor for more of a low voltage
constexpr Range EMF_SHARE = {
    0.5, 0.8}; // at rated speed, of the voltage that an inverter makes of the bus: bus/√3
constexpr Range REACTANCE = {0.03, 0.6}; // ωLI/EMF at the rated point, L the mean of both axes
constexpr Range ACCELERATION_S = {0.005, 1};
constexpr Range SPEED_RESERVE = {1.05, 1.3};  // highest over rated speed
constexpr Range CURRENT_RESERVE = {1.3, 3};   // largest over rated current
constexpr Range CONVERTER_RESERVE = {1.3, 3}; // full scale over largest current
constexpr Range PWM_HZ = {8000, 40000};
constexpr double TURN_MAX_RAD = 0.35; // of the rotor in a PWM period, at the highest speed
// The current's ripple in a PWM period, u·T/(12·L), is at most this share of the rated current:
// nobody drives a motor with a PWM that is slower than its winding.
constexpr double RIPPLE_MAX = 0.5;
// Copper loss of 100 W, and how it falls with power: a large motor has more copper for its torque
// than a small one.
constexpr double COPPER_LOSS = 0.15;
constexpr double COPPER_POWER_W = 100;
constexpr double COPPER_EXPONENT = -0.35;
constexpr Range COPPER_SPREAD = {0.6, 1.5};
constexpr Range FRICTION = {0.005, 0.05}; // at rated speed, of the rated torque

constexpr double TRIP_MAX = 0.97; // of full scale

// A battery's or a small supply's bus has MOSFETs, a mains bus has IGBTs or slower MOSFETs of high
// voltage.
constexpr double HIGH_VOLTAGE = 400;
constexpr Range DEAD_TIME_LOW_S = {0.2e-6, 1e-6};
constexpr Range DEAD_TIME_MAINS_S = {0.8e-6, 2e-6};
constexpr Range DEAD_TIME_HIGH_S = {1e-6, 3e-6};
constexpr double DEAD_TIME_SHARE = 0.03; // of a period, at most
constexpr Range DROP_V = {0, 2};         // of an IGBT; a MOSFET has R
constexpr double ON_TIME_RESERVE = 1.02;
constexpr Range SETTLING_S = {0.3e-6, 0.8e-6}; // of a shunt's amplifier

// A motor of the file has φ, R and the bus a tenth better than a real one may have them: with half
// of the rated torque at rated speed this share of the voltage circle holds 1.1·φ on 95 % of the
// bus.
constexpr double LOADED_SHARE = 0.85;
constexpr double EMF_SHARE_MAX = 0.97; // of the circle, at the highest speed
// The ends of the keys' ranges: wires and terminals have that much too.
constexpr double RESISTANCE_MIN_OHM = 0.001;
constexpr double INDUCTANCE_MIN_H = 1e-6;
constexpr double INERTIA_MIN_KG_M2 = 1e-7;

// What a motor and its board are drawn for.
struct Frame {
    double bus_v;
    double power_w;
    int pole_pairs;
    double rated_el;      // rad/s
    double speed_reserve; // highest over rated speed
    double circle_v;      // the largest phase voltage
    double period_s;      // of the PWM
};

double draw_dead_time(const Draw &draw, double bus_v, double frequency_hz)
{
    const Range range = bus_v <= LOW_VOLTAGE    ? DEAD_TIME_LOW_S
                        : bus_v <= HIGH_VOLTAGE ? DEAD_TIME_MAINS_S
                                                : DEAD_TIME_HIGH_S;
    return std::min(draw.uniform("dead time", range), DEAD_TIME_SHARE / frequency_hz);
}

// The power stage, without what follows from the motor's current.
Board draw_stage(const Draw &draw, double bus_v, double max_el)
{
    const double slowest = std::max(PWM_HZ.low, max_el / TURN_MAX_RAD);
    Board board;
    board.pwm_frequency_hz = std::round(draw.log_uniform("PWM frequency", {slowest, PWM_HZ.high}));
    board.bus_nominal_v = bus_v;
    board.bus_full_scale_v = bus_v * draw.uniform("bus full scale", {1.3, 1.8});
    board.bus_min_v = bus_v * draw.uniform("least bus", {0.4, 0.75});
    board.bus_max_v = bus_v * draw.uniform("largest bus", {1.15, 1.28});
    board.dead_time_s = draw_dead_time(draw, bus_v, board.pwm_frequency_hz);
    board.device_drop_v = bus_v <= LOW_VOLTAGE ? 0 : draw.uniform("drop", DROP_V);
    board.settling_s = draw.uniform("settling", SETTLING_S);
    // Half of the shortest low-side on-time, a quarter of the margin, holds dead time and settling.
    const double on_time_s = ON_TIME_RESERVE * (board.dead_time_s + board.settling_s);
    board.duty_margin_pct = 4 * board.pwm_frequency_hz * on_time_s / PER_CENT;
    board.offset_samples_log2 = draw.whole("samples of an offset", 6, 10);
    return board;
}

// The comparators see the ripple of the PWM, the converter does not; their level is within its
// range.
void add_sensing(const Draw &draw, const Motor &motor, Board &board)
{
    const double max_current_a = motor.max_current_a;
    const double ripple_a = board.bus_nominal_v / board.pwm_frequency_hz /
                            (6 * (motor.inductance_d_h + motor.inductance_q_h));
    const double reserve = draw.uniform("converter", CONVERTER_RESERVE);
    const double level = draw.uniform("over-current", {1.15, 0.92 * reserve});
    board.current_full_scale_a = max_current_a * reserve;
    board.overcurrent_a = max_current_a * level;
    board.trip_a = std::min(board.overcurrent_a * draw.uniform("trip", {1.02, 1.3}) + ripple_a,
                            TRIP_MAX * board.current_full_scale_a);
    board.offset_max_a = board.current_full_scale_a * draw.uniform("largest offset", {0.02, 0.05});
    board.name = fmt::format("{} V, {:.3g} A", board.bus_nominal_v, board.current_full_scale_a);
}

// The EMF at rated speed leaves room for the highest speed, and for half of the rated torque.
double draw_emf(const Draw &draw, const Frame &frame, double copper_loss, double reactance_q)
{
    const double whole_v = frame.bus_v / std::sqrt(3.0);
    const double loaded = std::hypot(1 + copper_loss / 2, reactance_q / 2);
    const double most = std::min(EMF_SHARE_MAX / frame.speed_reserve, LOADED_SHARE / loaded) *
                        frame.circle_v / whole_v;
    const double high = std::clamp(most, EMF_SHARE.low, EMF_SHARE.high);
    return draw.uniform("EMF", {EMF_SHARE.low, high}) * whole_v;
}

double draw_copper_loss(const Draw &draw, const Class &kind, double power_w)
{
    const double loss = usual_copper_loss(power_w) * draw.log_uniform("copper loss", COPPER_SPREAD);
    return std::clamp(loss, kind.copper_loss.low, kind.copper_loss.high);
}

// u·T/(12·L) over I with the smallest EMF: ωT/(12·x)·√3/EMF_SHARE.
double draw_reactance(const Draw &draw, const Frame &frame)
{
    const double ripple = std::sqrt(3.0) / EMF_SHARE.low * frame.rated_el * frame.period_s / 12;
    return draw.log_uniform("reactance",
                            {std::max(REACTANCE.low, ripple / RIPPLE_MAX), REACTANCE.high});
}

// With rated torque the mechanical power is that of the EMF, and R·I is the copper loss's share of
// it.
Motor draw_motor(const Draw &draw, const Class &kind, const Frame &frame, double acceleration_s)
{
    const double copper_loss = draw_copper_loss(draw, kind, frame.power_w);
    const double saliency = draw.uniform("saliency", {1, kind.saliency_max});
    const double reactance = draw_reactance(draw, frame);
    const double reactance_q = reactance * 2 * saliency / (1 + saliency);
    const double emf_v = draw_emf(draw, frame, copper_loss, reactance_q);
    const double current_a = frame.power_w / (1.5 * emf_v);
    const double rated_mech = frame.rated_el / frame.pole_pairs;
    Motor motor;
    motor.pole_pairs = frame.pole_pairs;
    motor.resistance_ohm = std::max(copper_loss * emf_v / current_a, RESISTANCE_MIN_OHM);
    motor.inductance_q_h = reactance_q * emf_v / current_a / frame.rated_el;
    motor.inductance_d_h = std::max(motor.inductance_q_h / saliency, INDUCTANCE_MIN_H);
    motor.inductance_q_h = motor.inductance_d_h * saliency;
    motor.flux_linkage_wb = emf_v / frame.rated_el;
    motor.rated_torque_nm = frame.power_w / rated_mech;
    motor.rated_speed_rpm = rated_mech / RAD_S_PER_RPM;
    motor.max_speed_rpm = motor.rated_speed_rpm * frame.speed_reserve;
    motor.max_current_a = current_a * draw.uniform("largest current", CURRENT_RESERVE);
    motor.inertia_kg_m2 =
        std::max(motor.rated_torque_nm * acceleration_s / rated_mech, INERTIA_MIN_KG_M2);
    motor.viscous_friction_nm_s =
        draw.uniform("friction", FRICTION) * motor.rated_torque_nm / rated_mech;
    motor.name = fmt::format("{}, {:.3g} W, {} V", kind.name, frame.power_w, frame.bus_v);
    return motor;
}

Frame draw_frame(const Draw &draw, const Class &kind)
{
    Frame frame{};
    frame.bus_v = kind.bus_v[draw.below("bus", kind.bus_v.size())];
    frame.power_w = draw.log_uniform(
        "power", {kind.power_w.low, std::min(kind.power_w.high, BUS_CURRENT_MAX_A * frame.bus_v)});
    frame.pole_pairs = draw.whole("pole pairs", kind.pole_pairs_min, kind.pole_pairs_max);
    frame.speed_reserve = draw.uniform("highest speed", SPEED_RESERVE);
    // The fastest PWM still sees the highest speed often enough.
    const double rpm_per_el = 1 / (RAD_S_PER_RPM * frame.pole_pairs);
    const double fastest = TURN_MAX_RAD * PWM_HZ.high / frame.speed_reserve * rpm_per_el;
    const double rpm = draw.log_uniform(
        "rated speed", {kind.speed_rpm.low, std::min(kind.speed_rpm.high, fastest)});
    frame.rated_el = rpm / rpm_per_el;
    return frame;
}

} // namespace

const std::vector<Class> &classes()
{
    constexpr Range loss = {0.02, 0.15};
    static const std::vector<Class> all = {
        {"gimbal", {12, 16, 24}, {5, 50}, {300, 8000}, 4, 14, {0.02, 1}, 1.1},
        {"outrunner", {12, 16, 24, 36, 48}, {50, 2000}, {2000, 12000}, 7, 21, loss, 1.1},
        {"hub", {24, 36, 48, 60}, {150, 800}, {150, 900}, 10, 25, loss, 1.3},
        {"servo", {48, 60, 160, 310}, {50, 2000}, {1500, 6000}, 2, 8, loss, 1.3},
        {"compressor", {310}, {100, 3000}, {900, 9000}, 2, 6, loss, 2.2},
        {"industrial", {310, 560}, {1000, 15000}, {750, 4500}, 2, 8, loss, 1.5},
    };
    return all;
}

double usual_copper_loss(double power_w)
{
    return COPPER_LOSS * std::pow(power_w / COPPER_POWER_W, COPPER_EXPONENT);
}

Specimen draw_specimen(const Draw &draw, const Class &kind)
{
    Frame frame = draw_frame(draw, kind);
    Specimen specimen;
    specimen.board = draw_stage(draw, frame.bus_v, frame.rated_el * frame.speed_reserve);
    frame.circle_v = (1 - specimen.board.duty_margin_pct * PER_CENT) * frame.bus_v / std::sqrt(3.0);
    frame.period_s = 1 / specimen.board.pwm_frequency_hz;
    specimen.acceleration_s = draw.log_uniform("acceleration", ACCELERATION_S);
    specimen.motor = draw_motor(draw, kind, frame, specimen.acceleration_s);
    add_sensing(draw, specimen.motor, specimen.board);
    return specimen;
}

} // namespace nf::zoo
