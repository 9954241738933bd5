// SPDX-License-Identifier: MIT
#include "derating_units.h"

#include "motor_model.h"
#include "numbers.h"
#include "safe_state_units.h"
#include "temperature_sensor.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// i²t: derating begins at this share of the heat that the continuous current makes; the fault is
// well above what derating holds, where only a current that is imposed can get.
constexpr double HEAT_WARN = 0.9;
constexpr double HEAT_MAX = 1.2;

constexpr double TEMPERATURE_SPAN_C = 20;
constexpr double TEMPERATURE_TIME_S = 0.1;

// The line of the board ends where somebody stopped measuring, and a power stage may be colder than
// that. A sensor that is off or shorted reads an end of the converter. A quarter of the way from
// there to the line's end divides both: with an NTC of 10 kΩ and 3380 K above 4.7 kΩ, whose line
// ends at -20 °C, that is -43 °C. Where the line goes to the converter's end, nothing can be told.
constexpr double BROKEN_SHARE = 0.25;

constexpr int FADE_SHIFT_MAX = 16;

// The firmware's steps that lie between the ends of a fade at least.
constexpr double FADE_STEPS = 2;

// Where derating by the bus begins, as shares of the ways from the limit to nominal and back.
constexpr double BUS_LOW_SHARE = 0.25;
constexpr double BUS_BRAKE_SHARE = 0.5;

// Braking has faded out at this share of the way from bus_brake_v to the fault's limit: the bus
// rises on for the slow period and the current loop's delay, and no rectifier takes back what came
// too much.
constexpr double BUS_END_SHARE = 0.75;

// Share 1 at `full`, 0 at `zero`, two steps away at least; the gain is rounded up, so that nothing
// is derated at `full`.
fade_t make_fade(double full, double zero)
{
    const double span = zero - full;
    int shift = FADE_SHIFT_MAX;
    while (std::ceil(std::ldexp(Q15, shift) / std::abs(span)) > MANTISSA_MAX) {
        shift--;
    }
    fade_t fade{};
    fade.zero = static_cast<int32_t>(std::lround(zero));
    fade.gain = static_cast<int32_t>(
        std::copysign(std::ceil(std::ldexp(Q15, shift) / std::abs(span)), span));
    fade.shift = static_cast<uint32_t>(shift);
    return fade;
}

// i²t: the continuous current makes 2^24 in the end.
void set_heat(derating_cfg_t &c, const MotorSettings &motor, double period_s)
{
    const double square = std::pow(c.current_continuous, 2);
    int shift = 0;
    while (std::ldexp(square, shift + 1) <= std::ldexp(1.0, 27)) {
        shift++;
    }
    c.heat_shift = static_cast<uint32_t>(shift);
    c.heat_gain = static_cast<int32_t>(
        std::lround(std::min(MANTISSA_MAX, std::ldexp(1.0, 24 + 16 - shift) / square)));
    const Source time = {"motor.thermal_time_constant_s", motor.thermal_time_constant_s, -1};
    const Mantissa rate = normalise(std::ldexp(period_s / motor.thermal_time_constant_s, 16), 0, 30,
                                    time, "the time between two looks at the current");
    c.heat_rate = rate.value;
    c.heat_rate_shift = rate.shift;
    c.heat_max_q14 = static_cast<int32_t>(std::lround(HEAT_MAX * Q14));
    c.heat = make_fade(HEAT_WARN * Q14, Q14);
}

// Without a level of its own the bus derates a share of the way from the limit: then that limit is
// the key.
void set_bus_derating(derating_cfg_t &c, const BoardSettings &board, const Bases &b)
{
    const double step_v = FADE_STEPS * b.voltage_v / Q15;
    const double limit = acting_bus_limit(board);
    const double low =
        board.bus_low_v > 0
            ? board.bus_low_v
            : board.bus_min_v + BUS_LOW_SHARE * (board.bus_nominal_v - board.bus_min_v);
    const double brake =
        board.bus_brake_v > 0
            ? board.bus_brake_v
            : board.bus_nominal_v + BUS_BRAKE_SHARE * (limit - board.bus_nominal_v);
    if (board.bus_low_v > 0) {
        require({"board.bus_low_v", low}, board.bus_min_v + step_v, board.bus_nominal_v,
                "from board.bus_min_v to board.bus_nominal_v");
    }
    require({"board.bus_min_v", board.bus_min_v}, 0, board.bus_nominal_v - step_v / BUS_LOW_SHARE,
            "board.bus_nominal_v, and room to derate motoring before it");
    if (board.bus_brake_v > 0) {
        require({"board.bus_brake_v", brake}, board.bus_nominal_v, limit - step_v / BUS_END_SHARE,
                "from board.bus_nominal_v to where the drive acts on a high bus");
    }
    const double steps = Q15 / b.voltage_v;
    c.bus_low = make_fade(low * steps, board.bus_min_v * steps);
    const double end = brake + BUS_END_SHARE * (limit - brake);
    c.bus_high = make_fade(brake * steps, end * steps);
}

void set_temperature_ends(derating_cfg_t &c, const BoardSettings &board)
{
    const auto [least, most] =
        std::minmax(board.temperature_points_pct.front(), board.temperature_points_pct.back());
    const double full = std::ldexp(1.0, board.adc_bits);
    const double lowest = BROKEN_SHARE * least / 100;
    const double highest = 1 - BROKEN_SHARE * (1 - most / 100);
    keep(c.temperature_lowest, full * lowest, 0, full - 1);
    keep(c.temperature_highest, full * highest, 0, full - 1);
}

// The fault needs the share to be gone for a while: the sensor is slow, its converter noisy.
void set_temperature_derating(derating_cfg_t &c, const BoardSettings &board, double period_s)
{
    const auto ends = std::minmax(
        {temperature_at(board, 1), temperature_at(board, std::ldexp(1.0, board.adc_bits) - 2)});
    require({"board.temperature_max_c", board.temperature_max_c}, ends.first, ends.second,
            "what the sensor can measure");
    const double warn = board.temperature_warn_c > 0 ? board.temperature_warn_c
                                                     : board.temperature_max_c - TEMPERATURE_SPAN_C;
    const double limit = temperature_count(board, board.temperature_max_c);
    const bool rises = board.temperature_points_pct.back() > board.temperature_points_pct.front();
    const double steps = rises ? -FADE_STEPS : FADE_STEPS;
    require({"board.temperature_warn_c", warn}, -TEMPERATURE_SPAN_C,
            std::min(board.temperature_max_c, temperature_at(board, limit + steps)),
            "two counts of the sensor below board.temperature_max_c");
    c.temperature = make_fade(temperature_count(board, warn), limit);
    set_temperature_ends(c, board);
    c.temperature_periods = static_cast<uint32_t>(std::ceil(TEMPERATURE_TIME_S / period_s));
}

// A limit beyond the field is beyond all that can flow: the voltage circle is within 1/√3 of the
// bus.
int32_t bus_current(double limit_a, const Source &setting, const Bases &b)
{
    int32_t c = 0;
    if (limit_a > 0) {
        const double number = limit_a / BUS_CURRENT_FACTOR / b.current_a * Q15;
        store(c, std::min(number, MANTISSA_MAX), 1, MANTISSA_MAX, setting,
              "a step of the current that the firmware measures");
    }
    return c;
}

// A supply that takes nothing back gets the least that the firmware can tell from 0, which is its
// word for no limit.
int32_t regeneration(const BoardSettings &board, const Bases &b)
{
    const double limit_a = board.bus_regeneration_max_a;
    if (limit_a != -1) {
        require({"board.bus_regeneration_max_a", limit_a}, 0, HUGE_VAL,
                "a current; -1 is no limit");
    }
    return limit_a == 0 ? 1 : bus_current(limit_a, {"board.bus_regeneration_max_a", limit_a}, b);
}

} // namespace

double braking_room_v(const Bases &b)
{
    return FADE_STEPS * b.voltage_v / Q15 / BUS_END_SHARE / (1 - BUS_BRAKE_SHARE);
}

derating_cfg_t make_derating(const MotorSettings &motor, const BoardSettings &board,
                             double period_s, const Bases &b)
{
    const double continuous = continuous_current(motor);
    derating_cfg_t c{};
    store(c.current_max, motor.max_current_a / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, CURRENT_REASON);
    store(c.current_continuous, continuous / b.current_a * Q15, 1, Q14, continuous_source(motor),
          CURRENT_REASON);
    set_heat(c, motor, period_s);
    set_temperature_derating(c, board, period_s);
    set_bus_derating(c, board, b);
    keep(c.regeneration_speed, b.step_from_rpm(motor.max_speed_rpm) * STANDSTILL, 0, Q30 / 2);
    c.bus_current_max = bus_current(board.bus_current_max_a,
                                    {"board.bus_current_max_a", board.bus_current_max_a}, b);
    c.bus_regeneration_max = regeneration(board, b);
    return c;
}

} // namespace nf
