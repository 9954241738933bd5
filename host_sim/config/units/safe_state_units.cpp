// SPDX-License-Identifier: MIT
#include "safe_state_units.h"

#include "modulator_units.h"
#include "numbers.h"
#include "setting_error.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

constexpr double ROOT_3 = 1.7320508075688772;
// Half an electrical turn behind the short circuit its two parts add up.
constexpr double HALF_TURN = PI;
// Electrical angle in a span at the speed up to which opening is safe. A change over it is that of
// a faster rotor up to seven times that speed; then it is a whole turn.
constexpr double SPAN_RAD = 0.8;
constexpr double SPAN_TICKS_MAX = 1024;
// Twice in a turn a change is at least this large, of that of a healthy machine: an open wire takes
// it to √3/2 of the vector, and the spans meet its largest slope to within half a span, cos 0.4.
constexpr double CHANGE_SHARE = 0.75;
// Two of the opening speed are more than one of a rotor at 3/4 of it.
constexpr double SETTLE_TURNS = 2;
// A bus that has just been within its limit is found beyond it one tick later, and the gates follow
// at the next one.
constexpr double ACT_TICKS = 2;
// What is charged in them is at most this share of the way from the nominal bus to the highest: the
// rest is for derating.
constexpr double ROOM_SHARE = 0.5;

double least_inductance(const MotorSettings &motor)
{
    return std::min(motor.inductance_d_h, motor.inductance_q_h);
}

double largest_inductance(const MotorSettings &motor)
{
    return std::max(motor.inductance_d_h, motor.inductance_q_h);
}

// V² of the bus that the energy of the windings makes of the capacitor's: C/2·x = 3/4·L·I².
double winding_square(const MotorSettings &motor, const BoardSettings &board)
{
    return 1.5 * largest_inductance(motor) * std::pow(board.overcurrent_a, 2) /
           board.bus_capacitance_f;
}

double acting_limit_of_short(const BoardSettings &board)
{
    const double largest_a = board.trip_a > 0 ? board.trip_a : board.overcurrent_a;
    const double charge = ACT_TICKS / board.pwm_frequency_hz * largest_a;
    const double least_f = charge / (ROOM_SHARE * (board.bus_max_v - board.bus_nominal_v));
    if (board.bus_capacitance_f < least_f) {
        throw SettingError("board.bus_capacitance_f", board.bus_capacitance_f, {false, least_f},
                           "with board.safe_state = \"short\": in two control periods the largest "
                           "current may charge it by half of the way from board.bus_nominal_v to "
                           "board.bus_max_v");
    }
    return board.bus_max_v - charge / board.bus_capacitance_f;
}

// The line-to-line EMF that charges the bus from bus_v to its limit at most: C/2·(V² − v²) ≤ W +
// U·C·(V − v).
double emf_from(double bus_v, double square, double most_v)
{
    return (most_v + bus_v) / 2 - square / (2 * (most_v - bus_v));
}

// The EMF that the bus bears between its under-voltage limit and its nominal voltage.
double bearable_emf(const MotorSettings &motor, const BoardSettings &board)
{
    if (board.bus_capacitance_f <= 0) {
        return board.bus_max_v;
    }
    const double square = winding_square(motor, board);
    const double most_v = acting_bus_limit(board);
    const double room = std::pow(most_v, 2) - std::pow(board.bus_nominal_v, 2);
    require(square, 0, room, {"board.bus_capacitance_f", board.bus_capacitance_f, -1},
            "below it the energy of the motor's windings at board.overcurrent_a alone charges the "
            "bus beyond board.bus_max_v");
    return std::min(emf_from(board.bus_min_v, square, most_v),
                    emf_from(board.bus_nominal_v, square, most_v));
}

// The largest flux linkage from which a short circuit begins: that of the largest current, and no
// more than the voltage lets turn.
double largest_flux(const MotorSettings &motor, const BoardSettings &board)
{
    const double current = motor.max_current_a;
    const double along =
        std::max(motor.flux_linkage_wb, motor.inductance_d_h * current - motor.flux_linkage_wb);
    const double voltage = largest_ratio(board) * board.bus_max_v + motor.resistance_ohm * current;
    return std::min(std::hypot(along, motor.inductance_q_h * current),
                    voltage / safe_open_speed(motor, board));
}

// The short circuit of a rotor at the speed up to which opening is safe, as the sensors see it.
void set_change(safe_state_cfg_t &c, const MotorSettings &motor, const BoardSettings &board,
                double safe, const Bases &b)
{
    const double turn = safe * b.control_period_s;
    const double impedance = std::hypot(motor.resistance_ohm, safe * largest_inductance(motor));
    const double seen_a =
        std::min(safe * motor.flux_linkage_wb / impedance, board.current_full_scale_a);
    keep(c.span_ticks, SPAN_RAD / turn, 1, SPAN_TICKS_MAX);
    keep(c.change_min,
         CHANGE_SHARE * 2 * std::sin(c.span_ticks * turn / 2) * seen_a / b.current_a * Q15, 1,
         MANTISSA_MAX);
    keep(c.settle_ticks, SETTLE_TURNS * TWO_PI / turn, 0, std::ldexp(1.0, 20));
}

void check_short(const MotorSettings &motor, const BoardSettings &board, double fastest)
{
    const double peak_a = short_circuit_peak(motor, board, fastest);
    const double safe = safe_open_speed(motor, board);
    const Source speed = {"motor.max_speed_rpm", motor.max_speed_rpm};
    if (board.trip_a > 0 && peak_a > board.trip_a) {
        require(fastest, 0, safe, speed,
                "above it a stop or a fault shorts the motor, and the peak of that current makes "
                "the comparators open the gates: board.trip_a is too low for this motor");
    }
    if (motor.demagnetising_current_a > 0 && peak_a > motor.demagnetising_current_a) {
        require(fastest, 0, safe, speed,
                "above it a stop or a fault shorts the motor, and the peak of that current is "
                "beyond motor.demagnetising_current_a");
    }
}

} // namespace

double acting_bus_limit(const BoardSettings &board)
{
    return board.safe_state == SafeState::open ? board.bus_max_v : acting_limit_of_short(board);
}

double safe_open_speed(const MotorSettings &motor, const BoardSettings &board)
{
    const double saliency = std::abs(motor.inductance_q_h - motor.inductance_d_h);
    const double flux = motor.flux_linkage_wb +
                        (board.bus_capacitance_f > 0 ? saliency * motor.max_current_a / 2 : 0);
    return bearable_emf(motor, board) / (ROOT_3 * flux);
}

double short_circuit_current(const MotorSettings &motor, double speed_el)
{
    const double r = motor.resistance_ohm;
    const double x_d = speed_el * motor.inductance_d_h;
    const double x_q = speed_el * motor.inductance_q_h;
    return speed_el * motor.flux_linkage_wb * std::hypot(r, x_q) / (r * r + x_d * x_q);
}

double short_circuit_peak(const MotorSettings &motor, const BoardSettings &board, double speed_el)
{
    const double decay =
        std::exp(-HALF_TURN * motor.resistance_ohm / (largest_inductance(motor) * speed_el));
    return short_circuit_current(motor, speed_el) +
           largest_flux(motor, board) / least_inductance(motor) * decay;
}

safe_state_cfg_t make_safe_state(const MotorSettings &motor, const BoardSettings &board,
                                 const Bases &b)
{
    safe_state_cfg_t c{};
    const double fastest = OVERSPEED_SHARE * rad_s_from_rpm(motor.max_speed_rpm) * motor.pole_pairs;
    const double safe = safe_open_speed(motor, board);
    if (board.safe_state == SafeState::open) {
        require(fastest, 0, safe, {"motor.max_speed_rpm", motor.max_speed_rpm},
                "above it, at the limit of the over-speed fault, the EMF charges the bus beyond "
                "board.bus_max_v once the gates open; board.safe_state = \"short\" shorts the "
                "motor instead");
        return c;
    }
    if (fastest > safe) {
        check_short(motor, board, fastest);
    }
    keep(c.open_speed, safe * b.control_period_s / TWO_PI * STEPS_PER_TURN, 1, Q30 / 2);
    set_change(c, motor, board, safe, b);
    return c;
}

} // namespace nf
