// SPDX-License-Identifier: MIT
#include "per_unit.h"

#include "low_speed_units.h"
#include "numbers.h"
#include "rules.h"
#include "safe_state_units.h"
#include "speed_margin.h"
#include "torque_filter_units.h"
#include "torque_units.h"

extern "C" {
#include "config_check.h"
}

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

// The converter's full scale is half the current base, so that no vector of three currents overflows.
constexpr double CURRENT_BASE_RATIO = 2.0;
// Electrical angle in a PWM period up to which the middle current of the observer and the lead of the voltage hold.
constexpr double TURN_MAX_RAD = 0.7;
// What the firmware keeps of the voltage for the current control, and the largest EMF, of U_b: weakening.c.
constexpr double WEAKENING_RESERVE = 3.0 / 256;
constexpr double EMF_MOST = 1.9;
// The estimate may overshoot the highest speed asked for.
constexpr double ESTIMATE_HEADROOM = 1.25;
// The current PI integrates at least this much faster than the motor's own R/L would: disturbances
// (dead time, EMF error) decay within ten times the closed-loop time constant.
constexpr double INTEGRAL_RATIO = 0.1;
// The profile brakes with this share of its acceleration, so that it can follow its own curve.
constexpr double BRAKING_SHARE = 0.9;
// The bus reciprocal covers this share of the under-voltage limit.
constexpr double BUS_FLOOR = 0.8;

// i²t: derating begins at this share of the heat that the continuous current makes; the fault is well
// above what derating holds, where only a current that is imposed can get.
constexpr double HEAT_WARN = 0.9;
constexpr double HEAT_MAX = 1.2;
constexpr double TEMPERATURE_SPAN_C = 20;
constexpr double TEMPERATURE_TIME_S = 0.1;
constexpr int FADE_SHIFT_MAX = 16;
// Where derating by the bus begins, as shares of the ways from the limit to nominal and back.
constexpr double BUS_LOW_SHARE = 0.25;
constexpr double BUS_BRAKE_SHARE = 0.5;
// Braking has faded out at this share of the way from bus_brake_v to the fault's limit: the bus rises on for the
// slow period and the current loop's delay, and no rectifier takes back what came too much.
constexpr double BUS_END_SHARE = 0.75;
// The firmware's steps that lie between the ends of a fade at least.
constexpr double FADE_STEPS = 2;
// Slower than this share of the highest speed is standing: what a motor can feed back there is lost in
// its own resistance but for a watt.
constexpr double STANDSTILL = 1.0 / 64;

// Supervision. Currents are shares of the continuous current; docs/protection.md says what each must not see.
// Half a turn is judged from a fifth of the continuous current's amplitude on, which a phase then moves by at
// least; an eighth of it is above the noise of 1 LSB rms, which spans 8 LSB in a turn.
constexpr double PHASE_RANGE_SHARE = 0.2;
constexpr double PHASE_RANGE_LSB = 64 + 1;
constexpr double PHASE_TURNS = 0.4; // in a slow period: beyond, two samples a turn can miss a phase
constexpr double FOLLOW_SHARE = 0.2;
constexpr double FOLLOW_LSB = 16;
constexpr double RESIDUAL_SHARE = 0.75;
// The sum of the currents: two sensors at opposite ends of their tolerance, and half as much beside it; drift of their zeros.
constexpr double SUM_TOLERANCES = 3;
constexpr double SUM_SHARE = 0.01; // of full scale, and …
constexpr double SUM_LSB = 8;      // … noise of three converters
constexpr int32_t SUM_END = 65535;
constexpr int32_t RESIDUAL_END = 8000; // the observer's error ends at 8191
constexpr double MEAN_TIME_S = 0.05;
constexpr double SPEED_ERROR_SHARE = 0.25;
constexpr double SPEED_ERROR_TIME_S = 0.5;
constexpr double SPEED_ERROR_TIME_SHARE = 5; // over the bandwidth in Hz
constexpr double RUNAWAY_TIME_S = 0.01;
constexpr double SOFT_SPEED_MOST = 0.5; // of rated speed
constexpr double OVERSPEED_TIME_S = 0.02;
constexpr double STALL_SHARE = 0.5;
constexpr double STALL_TIME_S = 1;
constexpr uint32_t LATE_MAX = 10;
constexpr double LATE_WINDOW_S = 1;
// The longest half-wave of a swing: what is slower is the load's or a position that hunts.
constexpr double HALF_WAVE_S = 0.5;
constexpr double HALF_WAVE_PERIODS = 60000; // what the firmware counts to
constexpr double PERIODS_MAX = 1e6;         // what a counter of periods is set to at most

// What the field is weakened by, with i_d down to −deepest_a.
const char *weakened_by(const MotorSettings &motor, double deepest_a)
{
    if (deepest_a <= 0) {
        return "and current_loop.weakening_pct = 0 or drive.method = \"voltage_phase\" does not "
               "weaken the field";
    }
    return deepest_a == motor.demagnetising_current_a
               ? "even with the field weakened by motor.demagnetising_current_a"
               : "even with the field weakened by current_loop.weakening_pct of "
                 "motor.max_current_a";
}

// The voltage that is left of the EMF at the highest speed when i_d weakens the field as far as it may, within the circle of the
// nominal bus. And the observer turns its currents by the small angle of a PWM period.
void check_speed(const MotorSettings &motor, const BoardSettings &board,
                 const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const double speed = rad_s_from_rpm(motor.max_speed_rpm) * motor.pole_pairs;
    const double deepest_a = deepest_current(motor, tuning);
    const double least_flux = motor.flux_linkage_wb - motor.inductance_d_h * deepest_a;
    const Source setting = {"motor.max_speed_rpm", motor.max_speed_rpm};
    require(speed * std::max(least_flux, 0.0), 0,
            largest_ratio(board) * board.bus_nominal_v * (1 - WEAKENING_RESERVE), setting,
            fmt::format("above it the motor's EMF exceeds what board.bus_nominal_v and "
                        "board.duty_margin_pct leave, {}",
                        weakened_by(motor, deepest_a))
                .c_str());
    require(
        speed * motor.flux_linkage_wb, 0, EMF_MOST * b.voltage_v, setting,
        "above it the motor's EMF exceeds 1.9 times board.bus_full_scale_v, which the firmware's "
        "numbers end with");
    require(m.max_speed_el * b.control_period_s, 0, TURN_MAX_RAD,
            {"motor.max_speed_rpm", motor.max_speed_rpm},
            "above it the rotor turns more than 0.7 rad in a PWM period; a higher "
            "board.pwm_frequency_hz raises it");
}

// Nothing to refuse: the ranges of the keys are those of the fields.
sampling_cfg_t make_sampling(const MotorSettings &motor, const BoardSettings &board,
                             const TuningSettings &tuning)
{
    sampling_cfg_t c{};
    if (tuning.angle_source == AngleSource::sensor) {
        c.sensor_pole_pairs = static_cast<uint32_t>(motor.pole_pairs);
    }
    c.current_shift = static_cast<uint32_t>(15 - board.adc_bits);
    c.bus_shift = c.current_shift;
    c.offset_log2 = static_cast<uint32_t>(board.offset_samples_log2);
    return c;
}

protection_cfg_t make_protection(const BoardSettings &board, const Bases &b)
{
    const char *const reason = "what the firmware can measure";
    protection_cfg_t c{};
    const double rail = Q14 - 1 - std::ldexp(1.0, 15 - board.adc_bits);
    store(c.current_max, board.overcurrent_a / b.current_a * Q15, 1, rail,
          {"board.overcurrent_a", board.overcurrent_a}, reason);
    if (board.trip_a > 0) {
        require(board.trip_a, board.overcurrent_a, HUGE_VAL, {"board.trip_a", board.trip_a},
                "board.overcurrent_a: the comparators must not trip before the drive's own limit");
    }
    const double step_v = FADE_STEPS * b.voltage_v / Q15;
    require({"board.bus_max_v", board.bus_max_v},
            board.bus_nominal_v + step_v / BUS_END_SHARE / (1 - BUS_BRAKE_SHARE), HUGE_VAL,
            "board.bus_nominal_v, and room to derate braking before it");
    store(c.bus_max, acting_bus_limit(board) / b.voltage_v * Q15, 1, MANTISSA_MAX - 1,
          {"board.bus_max_v", board.bus_max_v}, reason);
    store(c.bus_min, board.bus_min_v / b.voltage_v * Q15, 0, MANTISSA_MAX - 1,
          {"board.bus_min_v", board.bus_min_v}, reason);
    store(c.offset_max, board.offset_max_a / b.current_a * Q15, 0, MANTISSA_MAX,
          {"board.offset_max_a", board.offset_max_a}, reason);
    require(c.offset_max, 0, rail - c.current_max, {"board.offset_max_a", board.offset_max_a},
            "a sample at the end of the converter has to exceed board.overcurrent_a whatever the "
            "offset");
    return c;
}

// Share 1 at `full`, 0 at `zero`, two steps away at least; the gain is rounded up, so that nothing is derated at `full`.
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

// Without a level of its own the bus derates a share of the way from the limit: then that limit is the key.
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

// The line of the board ends where somebody stopped measuring, and a power stage may be colder than that. A sensor that is off
// or shorted reads an end of the converter. A quarter of the way from there to the line's end divides both: with an NTC of
// 10 kΩ and 3380 K above 4.7 kΩ, whose line ends at -20 °C, that is -43 °C. Where the line goes to the converter's end,
// nothing can be told.
constexpr double BROKEN_SHARE = 0.25;

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

// A limit beyond the field is beyond all that can flow: the voltage circle is within 1/√3 of the bus.
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

// A supply that takes nothing back gets the least that the firmware can tell from 0, which is its word for no limit.
int32_t regeneration(const BoardSettings &board, const Bases &b)
{
    const double limit_a = board.bus_regeneration_max_a;
    if (limit_a != -1) {
        require({"board.bus_regeneration_max_a", limit_a}, 0, HUGE_VAL,
                "a current; -1 is no limit");
    }
    return limit_a == 0 ? 1 : bus_current(limit_a, {"board.bus_regeneration_max_a", limit_a}, b);
}

// A start imposes its current whatever the bus gives: what that takes at standstill has to be allowed.
void check_imposed_power(const startup_cfg_t &c, const BoardSettings &board, const Model &m,
                         const Bases &b)
{
    if (board.bus_current_max_a > 0 && c.current_hold > 0) {
        const double imposed = std::max(c.current_move, c.align.current_high) / Q15 * b.current_a;
        require({"board.bus_current_max_a", board.bus_current_max_a},
                BUS_CURRENT_FACTOR * m.resistance * imposed * imposed / board.bus_nominal_v,
                HUGE_VAL, "what the current that a start imposes takes from board.bus_nominal_v");
    }
}

derating_cfg_t make_derating(const MotorSettings &motor, const BoardSettings &board,
                             double period_s, const Bases &b)
{
    const char *const reason = "the firmware's steps of current";
    const double continuous = continuous_current(motor);
    derating_cfg_t c{};
    store(c.current_max, motor.max_current_a / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, reason);
    store(c.current_continuous, continuous / b.current_a * Q15, 1, Q14, continuous_source(motor),
          reason);
    set_heat(c, motor, period_s);
    set_temperature_derating(c, board, period_s);
    set_bus_derating(c, board, b);
    keep(c.regeneration_speed, b.step_from_rpm(motor.max_speed_rpm) * STANDSTILL, 0, Q30 / 2);
    c.bus_current_max = bus_current(board.bus_current_max_a,
                                    {"board.bus_current_max_a", board.bus_current_max_a}, b);
    c.bus_regeneration_max = regeneration(board, b);
    return c;
}

supervision_cfg_t make_supervision(const MotorSettings &motor, const BoardSettings &board,
                                   const TuningSettings &tuning, double period_s, const Bases &b)
{
    const auto periods = [&](double seconds) {
        return static_cast<uint32_t>(std::min(std::ceil(seconds / period_s), PERIODS_MAX));
    };
    // A share of the continuous current, not less than what converter noise can look like.
    const auto current = [&](double share, double lsb) {
        const double number = share * continuous_current(motor) / b.current_a * Q15;
        return static_cast<int32_t>(
            std::lround(std::max(number, std::ldexp(lsb, 15 - board.adc_bits))));
    };
    const auto speed = [&](double share) {
        return static_cast<step_t>(
            std::lround(std::clamp(share * b.step_from_rpm(motor.max_speed_rpm), 1.0, Q30)));
    };
    supervision_cfg_t c{};
    c.phase_range_min = current(PHASE_RANGE_SHARE, PHASE_RANGE_LSB);
    c.phase_zero_max = c.phase_range_min / 4;
    c.phase_speed_max = static_cast<step_t>(
        std::lround(std::min(Q30, PHASE_TURNS * STEPS_PER_TURN / tuning.slow_ticks)));
    c.follow_error_max = current(FOLLOW_SHARE, FOLLOW_LSB);
    c.residual_max = std::min(current(RESIDUAL_SHARE, FOLLOW_LSB), RESIDUAL_END);
    c.sum_max = std::min(
        current(0, SUM_LSB) + static_cast<int32_t>(std::lround(SUM_SHARE * Q15 / 2)), SUM_END);
    c.sum_share_q15 = static_cast<int32_t>(
        std::lround(SUM_TOLERANCES * board.current_gain_tolerance_pct / 100 * (Q15 - 1)));
    while (c.mean_shift < 14 &&
           std::ldexp(period_s, static_cast<int>(c.mean_shift)) < MEAN_TIME_S) {
        c.mean_shift++;
    }
    c.speed_error_max = speed(SPEED_ERROR_SHARE);
    c.speed_error_periods =
        periods(std::max(SPEED_ERROR_TIME_S, SPEED_ERROR_TIME_SHARE / tuning.speed_bandwidth_hz));
    // An estimate may run away without its rotor. The speed of a sensor is the rotor's, so OVERSPEED names it, which is as soon.
    const bool is_sensed = tuning.angle_source == AngleSource::sensor;
    c.runaway_periods = periods(is_sensed ? OVERSPEED_TIME_S : RUNAWAY_TIME_S);
    c.overspeed = speed(OVERSPEED_SHARE);
    c.overspeed_periods = periods(OVERSPEED_TIME_S);
    c.stall_current = current(STALL_SHARE, FOLLOW_LSB);
    c.stall_speed = std::min(speed(STANDSTILL), 1 << 29);
    c.stall_periods = periods(STALL_TIME_S);
    c.late_max = LATE_MAX;
    c.late_window = periods(LATE_WINDOW_S);
    return c;
}

oscillation_cfg_t make_oscillation(const MotorSettings &motor, const TuningSettings &tuning,
                                   const Bases &b)
{
    const double slow_period_s = b.control_period_s * tuning.slow_ticks;
    oscillation_cfg_t c{};
    c.act = static_cast<uint32_t>(tuning.oscillation);
    c.halves_max = static_cast<uint32_t>(tuning.oscillation_half_waves);
    c.periods_max =
        static_cast<uint32_t>(std::clamp(HALF_WAVE_S / slow_period_s, 2.0, HALF_WAVE_PERIODS));
    const double amplitude = tuning.oscillation_amplitude_pct / 100 * continuous_current(motor);
    if (tuning.oscillation != OscillationAct::off) {
        require(amplitude, 0, motor.max_current_a,
                {"supervision.oscillation_amplitude_pct", tuning.oscillation_amplitude_pct},
                "motor.max_current_a: the torque current does not swing further");
    }
    keep(c.lag_periods_q4, 16 / (speed_lag_hz(tuning, b.control_period_s) * slow_period_s), 1, 1e6);
    keep(c.amplitude_max, amplitude / b.current_a * Q15, 1, Q14 - 1);
    return c;
}

// Rounded up: a time that is not 0 is not "never".
uint32_t command_timeout(const TuningSettings &tuning, const Bases &b)
{
    return static_cast<uint32_t>(std::ceil(tuning.command_timeout_s / b.control_period_s));
}

// The base of the observer's states, I_x = 2^s·I_b: both states fit for every current that the
// over-current protection lets through (three phases within it make a vector of 2/√3 of it). Not
// larger than that, for the adaptation's gains per unit grow with it.
int observer_shift(const MotorSettings &motor, const BoardSettings &board,
                   const ModelHeadroom &headroom, const Model &m, const Bases &b)
{
    constexpr double largest_base = 1 << 9;
    const double current = 2 / std::sqrt(3.0) * board.overcurrent_a / b.current_a;
    const double flux = headroom.flux * m.flux_current / b.current_a;
    const double x = current + flux;
    const double y = current * headroom.saliency * m.inductance_q / m.inductance_d;
    require(flux, 0, largest_base - 1, {"motor.flux_linkage_wb", motor.flux_linkage_wb},
            "φ/L_d below 511 times twice board.current_full_scale_a");
    require(y, 0, largest_base, {"motor.inductance_q_h", motor.inductance_q_h},
            "L_q/L_d within the observer's base");
    int shift = 0;
    while (std::ldexp(1.0, shift) <= std::max(x, y)) {
        shift++;
    }
    return shift;
}

// D: what an error of the network loses in a period.
double error_decay(const TuningSettings &tuning, const Model &m, const Bases &b)
{
    return b.control_period_s * m.resistance / m.inductance_d + tuning.observer_feedback;
}

// D, W3, f/D and the shift of (7). A faster PWM makes the winding's decay and W3 smaller.
void set_network(nn_observer_cfg_t &c, const MotorSettings &motor, const BoardSettings &board,
                 const TuningSettings &tuning, const ModelHeadroom &headroom, const Model &m,
                 const Bases &b)
{
    const double period = b.control_period_s;
    const double base_x = std::ldexp(b.current_a, static_cast<int>(c.current_shift));
    const double decay = error_decay(tuning, m, b) * b.current_a / base_x;
    const double volt_gain = period / m.inductance_d * b.voltage_v / base_x;
    const Source frequency = {"board.pwm_frequency_hz", board.pwm_frequency_hz, -1};
    const Mantissa largest =
        normalise(std::ldexp(headroom.weight * std::max(decay, volt_gain), 12), 2, 15, frequency,
                  "the current of this motor changes too much in a PWM period");
    c.weight_shift = largest.shift;
    const double weight = std::ldexp(1.0, 12 + static_cast<int>(largest.shift));
    c.decay = static_cast<int32_t>(std::lround(decay * weight));
    c.volt_gain = static_cast<int32_t>(std::lround(volt_gain * weight));
    // As whole units of the decay: the model in force takes them apart again, firmware/control/model.c.
    const double feedback = std::round(tuning.observer_feedback * b.current_a / base_x * weight);
    keep(c.feedback_q15, feedback / std::max(c.decay, 1) * Q15, 0, MANTISSA_MAX);
    store(c.flux_q27, m.flux_current / base_x * Q27, 1, Q27 - 1,
          {"motor.flux_linkage_wb", motor.flux_linkage_wb}, "φ/L_d in the observer's numbers");
    store(c.iq_gain_q14, m.inductance_d / m.inductance_q * Q14, 1, MANTISSA_MAX,
          {"motor.inductance_d_h", motor.inductance_d_h}, "twice motor.inductance_q_h");
    store(c.saliency_q13, m.inductance_q / m.inductance_d * Q13, 1, MANTISSA_MAX,
          {"motor.inductance_q_h", motor.inductance_q_h}, "four times motor.inductance_d_h");
}

// A mantissa that can still grow by `headroom`, as far as there is room: the correction ends there.
Mantissa with_headroom(double number, double headroom, const Source &source, const char *what)
{
    const Mantissa full = normalise(number, 0, 30, source, what);
    const int shift = std::max(0, static_cast<int>(full.shift) -
                                      static_cast<int>(std::ceil(std::log2(headroom))));
    return {static_cast<int32_t>(std::lround(std::ldexp(number, shift))),
            static_cast<uint32_t>(shift)};
}

// Bits that b loses: as many as leave room for the largest error, fewer where the states are small and the gains large.
constexpr int GRADIENT_SHIFT_MAX = 12;
constexpr int GRADIENT_SHIFT_MIN = 4;

// κ, κ_p, α: (19)–(22), and the limit of ρ.
void set_adaptation(nn_observer_cfg_t &c, const TuningSettings &tuning, double headroom,
                    const Model &m, const Bases &b)
{
    const char *const reason =
        "more is beyond the observer's numbers, for φ/L_d is small against the current range; a "
        "board with a smaller board.current_full_scale_a allows more";
    const double base_x = std::ldexp(b.current_a, static_cast<int>(c.current_shift));
    // b(k) is a product in Q15 of I_b times Q15 of I_x; 4/2π turns radians in Q30 into steps.
    const double steps = b.current_a * base_x / (m.flux_current * m.flux_current) * 4.0 / TWO_PI;
    const double eta_steps = tuning.observer_kappa * (1.0 - tuning.observer_momentum) * steps;
    const double kappa_p_steps = tuning.observer_kappa_p * steps;
    int shift = GRADIENT_SHIFT_MAX;
    while (shift > GRADIENT_SHIFT_MIN &&
           std::ldexp(headroom * std::max(eta_steps, kappa_p_steps), shift) > MANTISSA_MAX) {
        shift--;
    }
    c.gradient_shift = static_cast<uint32_t>(shift);
    const Mantissa eta = with_headroom(std::ldexp(eta_steps, shift), headroom,
                                       {"observer.kappa", tuning.observer_kappa}, reason);
    c.eta = eta.value;
    c.eta_shift = eta.shift;
    const Mantissa kappa_p = with_headroom(std::ldexp(kappa_p_steps, shift), headroom,
                                           {"observer.kappa_p", tuning.observer_kappa_p}, reason);
    c.kappa_p = kappa_p.value;
    c.kappa_p_shift = kappa_p.shift;
    c.momentum_q15 = static_cast<int32_t>(std::lround(tuning.observer_momentum * Q15));
    c.frame_share_q13 = static_cast<int32_t>(std::lround(tuning.observer_frame_share * Q13));
    const double corner = error_decay(tuning, m, b) / TWO_PI;
    c.corner = static_cast<step_t>(std::lround(std::min(corner * STEPS_PER_TURN, Q27)));
    c.rho_max_q13 = static_cast<int32_t>(std::lround(tuning.observer_rho_max * Q13));
}

nn_observer_cfg_t make_observer(const MotorSettings &motor, const BoardSettings &board,
                                const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const ModelHeadroom headroom = model_headroom(tuning);
    nn_observer_cfg_t c{};
    c.current_shift = static_cast<uint32_t>(observer_shift(motor, board, headroom, m, b));
    set_network(c, motor, board, tuning, headroom, m, b);
    set_adaptation(c, tuning, headroom.rate, m, b);
    c.speed_limit = b.speed_limit;
    const double slowest_pct =
        tuning.loaded_speed_pct > 0 ? tuning.loaded_speed_pct : tuning.handover_speed_pct;
    keep(c.rho_speed_min, b.step_from_rpm(motor.rated_speed_rpm) * slowest_pct / 200, 1, Q30 / 2);
    return c;
}

// A gain that can still grow by `headroom`, as far as there is room.
void leave_room(int32_t &mantissa, uint32_t &shift, double headroom)
{
    int bits = 0;
    while (static_cast<int>(shift) - bits > 1 &&
           std::ldexp(mantissa * headroom, -bits) > MANTISSA_MAX) {
        bits++;
    }
    mantissa = static_cast<int32_t>(std::lround(std::ldexp(mantissa, -bits)));
    shift -= static_cast<uint32_t>(bits);
}

// Pole of the closed loop at the bandwidth, zero of the PI on the motor's R/L or INTEGRAL_RATIO above.
pi_cfg_t make_current_pi(const TuningSettings &tuning, const Model &m, const Bases &b,
                         double inductance)
{
    const double omega = TWO_PI * tuning.current_bandwidth_hz;
    const double kp = omega * inductance * b.current_a / b.voltage_v;
    const double own = m.resistance / inductance;
    const double corner = std::max(own, omega * INTEGRAL_RATIO);
    pi_cfg_t c = make_pi(kp, kp * corner * b.control_period_s, corner > own ? 2 : 1,
                         "current_loop.bandwidth_hz", tuning.current_bandwidth_hz);
    const double headroom = model_headroom(tuning).inductance;
    leave_room(c.kp, c.kp_shift, headroom);
    leave_room(c.ki, c.ki_shift, headroom);
    return c;
}

current_loop_cfg_t make_current_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                     const Model &m, const Bases &b)
{
    const double reactance = b.speed_el_rad_s * b.current_a / b.voltage_v * Q13;
    current_loop_cfg_t c{};
    c.pi_d = make_current_pi(tuning, m, b, m.inductance_d);
    c.pi_q = make_current_pi(tuning, m, b, m.inductance_q);
    keep(c.reactance_d_q13, reactance * m.inductance_d, 0, MANTISSA_MAX);
    keep(c.reactance_q_q13, reactance * m.inductance_q, 0, MANTISSA_MAX);
    keep(c.emf_q13, b.speed_el_rad_s * m.flux / b.voltage_v * Q13, 0, MANTISSA_MAX);
    store(c.resistance_q13, m.resistance * b.current_a / b.voltage_v * Q13, 0, MANTISSA_MAX,
          {"motor.resistance_ohm", motor.resistance_ohm},
          "twice board.bus_full_scale_v over board.current_full_scale_a; a board for smaller "
          "currents takes this motor");
    return c;
}

// Steps by which the speed changes in a slow period at an electrical acceleration.
double ramp_steps(double acceleration_el, const TuningSettings &tuning, const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    return acceleration_el * slow_period * b.control_period_s / TWO_PI * STEPS_PER_TURN;
}

constexpr int LIFT_MAX = 14; // of inertia_lift

pi_cfg_t make_speed_pi(const TuningSettings &tuning, const Model &m, const Bases &b,
                       const char *key, double bandwidth_hz)
{
    const double omega = TWO_PI * bandwidth_hz;
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    // The error between full speed one way and the other fits 2·Ω_b.
    const double per_unit = 2 * b.speed_el_rad_s / b.current_a / m.torque_acceleration;
    return make_pi(2 * tuning.speed_damping * omega * per_unit,
                   omega * omega * per_unit * slow_period, 2, key, bandwidth_hz);
}

// The ripple of the estimate falls with the speed: where it allows the whole bandwidth, the loop has it.
double soft_speed_rpm(const MotorSettings &motor, const TuningSettings &tuning)
{
    const double share = std::max(1.0, tuning.speed_bandwidth_hz / tuning.low_speed_bandwidth_hz);
    return std::min(tuning.handover_speed_pct / 100 * share, SOFT_SPEED_MOST) *
           motor.rated_speed_rpm;
}

constexpr double RATE_MAX = 0.49; // of a ramp with less torque than 131 LSB: learned more slowly
const char *const CORRECTION_REASON = "the firmware's correction of J";

// current_per_step: i_q, Q15 of I_b, for a change of the reference by a step in a slow period.
void set_inertia_correction(speed_loop_cfg_t &c, const TuningSettings &tuning,
                            double current_per_step)
{
    constexpr double INTEGRAL_PER_LSB = 2048; // Q26 of Q15
    constexpr double Q17 = 131072;
    const double factor = 1 + tuning.adapt_inertia_pct / 100;
    const double ramp_q26 = current_per_step * c.ramp * INTEGRAL_PER_LSB;
    keep(c.inertia_least_q13, Q13 / factor, Q13 / 4, Q13);
    keep(c.inertia_most_q13, Q13 * factor, Q13, MANTISSA_MAX);
    if (tuning.adapt_inertia_pct > 0) {
        require(tuning.inertia_feed_forward, 1, 1,
                {"speed_loop.inertia_feed_forward", tuning.inertia_feed_forward},
                "adaptation.inertia_pct needs the whole of J fed forward");
        const double rate = std::min(Q17 / ramp_q26, RATE_MAX);
        const Mantissa mantissa =
            normalise(std::ldexp(rate, 16), 0, 30,
                      {"adaptation.inertia_pct", tuning.adapt_inertia_pct}, CORRECTION_REASON);
        c.inertia_rate = mantissa.value;
        c.inertia_rate_shift = mantissa.shift;
    }
}

speed_loop_cfg_t make_speed_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                 const Model &m, const Bases &b)
{
    const double one_step_ramp = ramp_steps(1.0, tuning, b); // steps for 1 rad/s²
    speed_loop_cfg_t c{};
    c.pi = make_speed_pi(tuning, m, b, "speed_loop.bandwidth_hz", tuning.speed_bandwidth_hz);
    const double slow_hz = tuning.low_speed_bandwidth_hz;
    const bool has_own = slow_hz > 0 && std::abs(slow_hz - tuning.speed_bandwidth_hz) > 0;
    c.soft = c.pi;
    if (has_own) {
        c.soft = make_speed_pi(tuning, m, b, "speed_loop.low_speed_bandwidth_hz", slow_hz);
        keep(c.soft_speed, b.step_from_rpm(soft_speed_rpm(motor, tuning)), 0, Q30 / 2);
    }
    store(c.ramp, rad_s_from_rpm(tuning.speed_ramp_rpm_s) * motor.pole_pairs * one_step_ramp, 1,
          Q30 / 2, {"speed_loop.ramp_rpm_s", tuning.speed_ramp_rpm_s},
          "the firmware's steps of speed in a slow period");
    store(c.speed_max, b.step_from_rpm(motor.max_speed_rpm), 1, Q30 / 2,
          {"motor.max_speed_rpm", motor.max_speed_rpm},
          "an eighth of an electrical turn in a PWM period");
    const double current_per_step =
        tuning.inertia_feed_forward / one_step_ramp / m.torque_acceleration / b.current_a * Q15;
    const Mantissa inertia =
        normalise(std::ldexp(current_per_step, 16 - LIFT_MAX), 0, 30 + LIFT_MAX,
                  {"speed_loop.inertia_feed_forward", tuning.inertia_feed_forward},
                  "more is beyond the firmware's numbers for this inertia");
    const int shift = static_cast<int>(inertia.shift) - LIFT_MAX;
    c.inertia = inertia.value;
    c.inertia_shift = static_cast<uint32_t>(std::max(shift, 0));
    c.inertia_lift = static_cast<uint32_t>(std::max(-shift, 0));
    set_inertia_correction(c, tuning, current_per_step);
    c.error_shift = static_cast<uint32_t>(b.speed_shift) + 1U;
    return c;
}

// The profile's braking distance in units of 2^shift Q32 turns, 2^13…2^14 of them.
void store_braking(position_loop_cfg_t &c, const TuningSettings &tuning, const Bases &b)
{
    const double speed = rad_s_from_rpm(tuning.position_speed_rpm);
    const double brake = tuning.position_acceleration_rad_s2 * BRAKING_SHARE;
    const double distance_q32 = b.turns_from_mech_rad(speed * speed / (2 * brake)) * STEPS_PER_TURN;
    require(distance_q32, std::ldexp(Q13, 8), std::ldexp(Q13, 48),
            {"position_loop.speed_rpm", tuning.position_speed_rpm, 2},
            "the braking distance at position_loop.acceleration_rad_s2 in the firmware's numbers");
    int shift = 8;
    while (std::ldexp(distance_q32, -shift) >= Q14) {
        shift++;
    }
    c.distance_shift = static_cast<uint32_t>(shift);
    c.braking_inverse = static_cast<int32_t>(std::lround(Q30 / std::ldexp(distance_q32, -shift)));
    store(c.softness_q15, brake * tuning.position_softness_s / speed * Q15, 0, 12288,
          {"position_loop.softness_s", tuning.position_softness_s},
          "a share of the time to brake from full speed");
}

position_loop_cfg_t make_position_loop(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b)
{
    position_loop_cfg_t c{};
    const double acceleration = tuning.position_acceleration_rad_s2 * motor.pole_pairs;
    store(c.ramp, ramp_steps(acceleration, tuning, b), 1, Q30 / 2,
          {"position_loop.acceleration_rad_s2", tuning.position_acceleration_rad_s2},
          "the firmware's steps of speed in a slow period");
    store(c.speed_max, b.step_from_rpm(tuning.position_speed_rpm), 1, Q30 / 2,
          {"position_loop.speed_rpm", tuning.position_speed_rpm},
          "an eighth of an electrical turn in a PWM period");
    store_braking(c, tuning, b);
    const double gain = TWO_PI * tuning.position_bandwidth_hz * b.control_period_s * 65536.0;
    const Mantissa g =
        normalise(gain, 0, 30, {"position_loop.bandwidth_hz", tuning.position_bandwidth_hz},
                  "half the PWM frequency in rad/s");
    c.gain = g.value;
    c.gain_shift = g.shift;
    c.pole_pairs = static_cast<uint32_t>(motor.pole_pairs);
    return c;
}

phase_compensator_cfg_t make_compensator(const MotorSettings &motor, const TuningSettings &tuning,
                                         const Bases &b)
{
    const Mantissa g = normalise(std::ldexp(tuning.compensator_gain, 16), 0, 15,
                                 {"phase_compensator.gain", tuning.compensator_gain},
                                 "half of the angle in a sample");
    const auto angle = [](double degrees) {
        return static_cast<int32_t>(std::lround(degrees / 360 * STEPS_PER_TURN));
    };
    const double current = tuning.compensator_current_pct / 100 * continuous_current(motor);
    phase_compensator_cfg_t c{};
    c.gain = g.value;
    c.gain_shift = g.shift;
    c.lead_max = angle(tuning.lead_max_deg);
    c.brake_max = angle(tuning.brake_max_deg);
    c.current_min = static_cast<int32_t>(
        std::lround(std::clamp(current / b.current_a * Q15, 1.0, MANTISSA_MAX)));
    return c;
}

virtual_resistance_cfg_t make_virtual_resistance(const TuningSettings &tuning, const Bases &b)
{
    virtual_resistance_cfg_t c{};
    store(c.resistance_q15, tuning.virtual_resistance_ohm * b.current_a / b.voltage_v * Q15, 0, Q14,
          {"voltage_loop.virtual_resistance_ohm", tuning.virtual_resistance_ohm},
          "a quarter of board.bus_full_scale_v over board.current_full_scale_a");
    store(c.mean_rate_q15, b.control_period_s / tuning.virtual_mean_s * Q15, 1, Q14,
          {"voltage_loop.virtual_mean_s", tuning.virtual_mean_s, -1},
          "2 to 32768 periods of the PWM");
    return c;
}

voltage_drive_cfg_t make_voltage_drive(const MotorSettings &motor, const TuningSettings &tuning,
                                       const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    const double base = 2 * b.speed_el_rad_s / b.voltage_v; // of the speed error, in U_b
    const char *const reason = "more is beyond the firmware's gains";
    voltage_drive_cfg_t c{};
    if (tuning.method != ControlMethod::voltage_phase) {
        return c;
    }
    const Source kp = {"voltage_loop.kp_v_s_per_rad", tuning.voltage_kp_v_s_per_rad};
    const Source ki = {"voltage_loop.ki_v_per_rad", tuning.voltage_ki_v_per_rad};
    const Mantissa p = normalise(tuning.voltage_kp_v_s_per_rad * base, 1, 30, kp, reason);
    const Mantissa i = normalise(std::ldexp(tuning.voltage_ki_v_per_rad * base * slow_period, 11),
                                 1, 30, ki, reason);
    c.enabled = 1;
    c.pi.kp = p.value;
    c.pi.kp_shift = p.shift;
    c.pi.ki = i.value;
    c.pi.ki_shift = i.shift;
    const double slowest_pct =
        std::max(tuning.voltage_speed_pct, ABOVE_HANDOVER * tuning.handover_speed_pct);
    require(slowest_pct / 100 * motor.rated_speed_rpm, 0, motor.max_speed_rpm,
            {"motor.rated_speed_rpm", motor.rated_speed_rpm},
            "the share voltage_loop.speed_min_pct of it is within motor.max_speed_rpm");
    keep(c.speed_min, b.step_from_rpm(slowest_pct / 100 * motor.rated_speed_rpm), 0, Q30 / 2);
    store(c.settle_periods, tuning.voltage_settle_s / slow_period, 1, 10000,
          {"voltage_loop.settle_s", tuning.voltage_settle_s}, "10000 periods of the speed loop");
    c.compensator = make_compensator(motor, tuning, b);
    c.damping = make_virtual_resistance(tuning, b);
    return c;
}

// Current from which on a leg's sign is certain: so many counts of the converter.
constexpr double EDGE_LSB = 8;
constexpr double EDGE_KNEES = 3.5; // fits the loss of a leg that commutates softly: modulator.h

// What a leg holds where the board file does not say: half a metre of wire and the devices' own for each ampere, or at
// mains voltage a motor cable and IGBTs. Real ones are within a factor of three, and half to twice of it is near enough.
struct LegCapacitance {
    double cable_f;
    double device_f_per_a;
};
constexpr double MAINS_V = 100;
constexpr LegCapacitance LOW_VOLTAGE_LEG = {45e-12, 45e-12};
constexpr LegCapacitance MAINS_LEG = {320e-12, 17e-12};

} // namespace

double commutation_knee_a(const BoardSettings &board, const ModelScales &model)
{
    const LegCapacitance &typical = board.bus_nominal_v < MAINS_V ? LOW_VOLTAGE_LEG : MAINS_LEG;
    const double capacitance_f =
        model.output_capacitance_f >= 0
            ? model.output_capacitance_f
            : typical.cable_f + typical.device_f_per_a * board.overcurrent_a;
    return model.dead_time_s > 0 ? capacitance_f * board.bus_nominal_v / model.dead_time_s : 0;
}

namespace
{

void set_dead_time(modulator_cfg_t &c, const BoardSettings &board, const TuningSettings &tuning,
                   const ModelScales &model, const Model &m, const Bases &b)
{
    const double ripple =
        board.bus_nominal_v * b.control_period_s / (6 * (m.inductance_d + m.inductance_q));
    store(c.dead_time_q15, model.dead_time_s / b.control_period_s * Q15, 0, Q13,
          {"model.dead_time_s", model.dead_time_s}, "a quarter of the PWM period");
    c.dead_time_band_q15 =
        static_cast<int32_t>(std::lround(c.dead_time_q15 * tuning.adapt_dead_time_pct / 100));
    store(c.drop_q15, model.device_drop_v / b.voltage_v * Q15, 0, Q15 / 16,
          {"model.device_drop_v", model.device_drop_v}, "a sixteenth of board.bus_full_scale_v");
    c.ripple_q15 = static_cast<int32_t>(std::lround(std::min(ripple / b.current_a * Q15, Q14)));
    const double edge_a = std::max(EDGE_LSB * b.current_a / std::ldexp(1.0, board.adc_bits),
                                   EDGE_KNEES * commutation_knee_a(board, model));
    c.edge_slope = static_cast<int32_t>(std::max(1L, std::lround(b.current_a / edge_a)));
}

modulator_cfg_t make_modulator(const BoardSettings &board, const TuningSettings &tuning,
                               const ModelScales &model, const Model &m, const Bases &b)
{
    modulator_cfg_t c{};
    store(c.timer_counts, board.timer_clock_hz / (2 * board.pwm_frequency_hz), 1, MANTISSA_MAX,
          {"board.timer_clock_hz", board.timer_clock_hz},
          "65534 periods of the clock in one of the PWM");
    c.ratio_max_q15 = static_cast<int32_t>(std::lround(largest_ratio(board) * Q15 - 0.5));
    require(b.voltage_v / (board.bus_min_v * BUS_FLOOR), 0, Q15 / Q12,
            {"board.bus_min_v", board.bus_min_v, -1},
            "the modulator divides by no less than 0.8 of it, an eighth of board.bus_full_scale_v");
    set_dead_time(c, board, tuning, model, m, b);
    return c;
}

} // namespace

SettingError::SettingError(const char *key_, double value_, SettingLimit limit_,
                           const char *reason_)
    : std::runtime_error(fmt::format("{} = {:g}: {}", key_, value_, reason_)), key(key_),
      value(value_), limit(limit_), reason(reason_)
{
}

double Bases::torque_nm() const
{
    return BUS_CURRENT_FACTOR * pole_pairs * voltage_v * current_a / speed_el_rad_s;
}

double Bases::step_from_rpm(double rpm) const
{
    return rad_s_from_rpm(rpm) * pole_pairs * control_period_s / TWO_PI * STEPS_PER_TURN;
}

double Bases::rpm_from_step(double step) const
{
    return step / step_from_rpm(1.0);
}

double Bases::position_max_turns() const
{
    constexpr double ELECTRICAL = 32767; // Q16 in 32 bits
    return std::floor(ELECTRICAL / pole_pairs);
}

double Bases::turns_from_mech_rad(double rad) const
{
    return rad * pole_pairs / TWO_PI;
}

double calibration_time(const BoardSettings &board, const TuningSettings &tuning)
{
    return (std::exp2(board.offset_samples_log2) + 1 + tuning.slow_ticks) / board.pwm_frequency_hz;
}

double temperature_count(const BoardSettings &board, double temperature_c)
{
    const std::vector<double> &points = board.temperature_points_c;
    const std::vector<double> &pct = board.temperature_points_pct;
    const auto above = std::upper_bound(points.begin() + 1, points.end() - 1, temperature_c);
    const auto k = static_cast<std::size_t>(above - points.begin());
    const double share = (temperature_c - points[k - 1]) / (points[k] - points[k - 1]);
    return std::ldexp((pct[k - 1] + share * (pct[k] - pct[k - 1])) / 100, board.adc_bits);
}

double temperature_at(const BoardSettings &board, double count)
{
    const std::vector<double> &pct = board.temperature_points_pct;
    const double wanted = 100 * std::ldexp(count, -board.adc_bits);
    const bool rises = pct.back() > pct.front();
    std::size_t k = 1;
    while (k + 1 < pct.size() && (rises ? pct[k] < wanted : pct[k] > wanted)) {
        k++;
    }
    const std::vector<double> &points = board.temperature_points_c;
    const double share = (wanted - pct[k - 1]) / (pct[k] - pct[k - 1]);
    return points[k - 1] + share * (points[k] - points[k - 1]);
}

static double speed_base(const Bases &b)
{
    return std::ldexp(Q15, b.speed_shift) / STEPS_PER_TURN * TWO_PI / b.control_period_s;
}

Bases make_bases(const MotorSettings &motor, const BoardSettings &board)
{
    Bases b{};
    b.control_period_s = 1.0 / board.pwm_frequency_hz;
    b.current_a = board.current_full_scale_a * CURRENT_BASE_RATIO;
    b.voltage_v = board.bus_full_scale_v;
    b.pole_pairs = motor.pole_pairs;
    keep(b.speed_limit, b.step_from_rpm(motor.max_speed_rpm) * ESTIMATE_HEADROOM, 1, Q30 / 2);
    b.speed_shift = 1;
    while (std::ldexp(Q15, b.speed_shift) <= b.speed_limit) {
        b.speed_shift++;
    }
    b.speed_el_rad_s = speed_base(b);
    return b;
}

Bases rescaled(Bases bases, const drive_cfg_t &cfg)
{
    bases.speed_shift = static_cast<int>(cfg.speed_shift);
    bases.speed_el_rad_s = speed_base(bases);
    return bases;
}

namespace
{

drive_cfg_t convert(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &tuning, const ModelScales &scales)
{
    const Bases b = make_bases(motor, board);
    const Model m = make_model(motor, scales);
    check_speed(motor, board, tuning, m, b);
    drive_cfg_t c{};
    c.sampling = make_sampling(motor, board, tuning);
    c.protection = make_protection(board, b);
    const double period_s = b.control_period_s * tuning.slow_ticks * SUPERVISION_STEPS;
    c.derating = make_derating(motor, board, period_s, b);
    c.supervision = make_supervision(motor, board, tuning, period_s, b);
    set_imposed_limits(c.supervision, motor, board, tuning, m, b);
    c.oscillation = make_oscillation(motor, tuning, b);
    c.observer = make_observer(motor, board, tuning, m, b);
    c.current_loop = make_current_loop(motor, tuning, m, b);
    c.speed_loop = make_speed_loop(motor, tuning, m, b);
    c.position_loop = make_position_loop(motor, tuning, b);
    c.modulator = make_modulator(board, tuning, scales, m, b);
    c.hold_loop = make_hold_loop(c.current_loop, motor, board, tuning, scales, m, b);
    c.startup = make_startup(motor, board, tuning, scales, m, b);
    check_imposed_power(c.startup, board, m, b);
    c.current_reference = make_current_reference(motor, board, tuning, scales, m, b);
    c.run = make_run(tuning);
    c.model = make_model_cfg(motor, tuning, m, b);
    c.voltage_drive = make_voltage_drive(motor, tuning, b);
    c.torque_filter = make_torque_filter(tuning, b);
    c.torque_loop = make_torque_loop(motor, tuning, c.speed_loop, b);
    c.safe_state = make_safe_state(motor, board, b);
    c.link.timeout_ticks = command_timeout(tuning, b);
    c.speed_shift = static_cast<uint32_t>(b.speed_shift);
    c.slow_ticks = static_cast<uint32_t>(tuning.slow_ticks);
    c.crc = config_guard_crc(&c);
    return c;
}

// Each round moves one end of one rule's range; a rule that is moved this often contradicts the others.
constexpr int RULE_ROUNDS = 64;
// A value that its limit was computed for is within it in spite of rounding.
constexpr double INWARDS = 1e-9;

// Moves the range of a rule whose value was refused; false where the value is written.
bool narrow(RuleRanges &ranges, const SettingError &error, const TuningSettings &as_written)
{
    if (rule_source(error.key, as_written) == nullptr) {
        return false;
    }
    RuleRange &range = ranges[error.key];
    if (error.limit.at_most) {
        range.most = error.limit.value * (1 - INWARDS);
    } else {
        range.least = error.limit.value * (1 + INWARDS);
    }
    return range.least <= range.most;
}

} // namespace

TuningSettings settled_tuning(const MotorSettings &motor, const BoardSettings &board,
                              const TuningSettings &as_written, const ModelScales &scales)
{
    RuleRanges ranges;
    for (int round = 0;; round++) {
        const TuningSettings tuning =
            for_sensor(by_rules(as_written, motor, board, scales, ranges));
        try {
            convert(motor, board, tuning, scales);
            return tuning;
        } catch (const SettingError &error) {
            if (round == RULE_ROUNDS || !narrow(ranges, error, as_written)) {
                throw;
            }
        }
    }
}

drive_cfg_t make_drive_cfg(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &as_written, const ModelScales &scales)
{
    const drive_cfg_t c =
        convert(motor, board, settled_tuning(motor, board, as_written, scales), scales);
    if (const char *bad = config_check(&c)) {
        throw std::logic_error(fmt::format("{} is outside its range", bad));
    }
    return c;
}

} // namespace nf
