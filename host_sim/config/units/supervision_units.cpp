// SPDX-License-Identifier: MIT
#include "supervision_units.h"

#include "imposed_current.h"
#include "numbers.h"
#include "safe_state_units.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Supervision. Currents are shares of the continuous current; docs/protection.md says what each
// must not see. Half a turn is judged from a fifth of the continuous current's amplitude on, which
// a phase then moves by at least; an eighth of it is above the noise of 1 LSB rms, which spans 8
// LSB in a turn.
constexpr double PHASE_RANGE_SHARE = 0.2;
constexpr double PHASE_RANGE_LSB = 64 + 1;
constexpr double PHASE_TURNS = 0.4; // in a slow period: beyond, two samples a turn can miss a phase
constexpr double FOLLOW_SHARE = 0.2;
constexpr double FOLLOW_LSB = 16;
constexpr double RESIDUAL_SHARE = 0.75;
// The sum of the currents: two sensors at opposite ends of their tolerance, and half as much beside
// it; drift of their zeros.
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
constexpr double OVERSPEED_TIME_S = 0.02;
constexpr double STALL_SHARE = 0.5;
constexpr double STALL_TIME_S = 1;
constexpr uint32_t LATE_MAX = 10;
constexpr double LATE_WINDOW_S = 1;
constexpr double PERIODS_MAX = 1e6; // what a counter of periods is set to at most

// What supervision allows an imposed current, in units of 1/ω_n of its swing: the turning point can
// hold a phase at zero for 1.4, and the leg's dead time keeps it there, for 3 as measured; what
// lasts twice as long is no swing. The current control adds at most this much to R·i and the EMF:
// for the winding's R at 100 K more than cold, and for a dead time of 2 % of the period that nobody
// compensates. A rotor that is pulled in can take more for half a swing.
constexpr double UNLIKE_SWING = 6;
constexpr double VOLTAGE_RESISTANCE_SHARE = 0.4;
constexpr double VOLTAGE_BUS_SHARE = 0.03;

// What the limits are made of.
struct Watched {
    const MotorSettings &motor;
    const BoardSettings &board;
    const TuningSettings &tuning;
    double period_s;
    const Bases &b;

    uint32_t periods(double seconds) const
    {
        return static_cast<uint32_t>(std::min(std::ceil(seconds / period_s), PERIODS_MAX));
    }

    // A share of the continuous current, not less than what converter noise can look like.
    int32_t current(double share, double lsb) const
    {
        const double number = share * continuous_current(motor) / b.current_a * Q15;
        return static_cast<int32_t>(
            std::lround(std::max(number, std::ldexp(lsb, 15 - board.adc_bits))));
    }

    // A share of the highest speed.
    step_t speed(double share) const
    {
        return static_cast<step_t>(
            std::lround(std::clamp(share * b.step_from_rpm(motor.max_speed_rpm), 1.0, Q30)));
    }
};

void set_phase_limits(supervision_cfg_t &c, const Watched &w)
{
    c.phase_range_min = w.current(PHASE_RANGE_SHARE, PHASE_RANGE_LSB);
    c.phase_zero_max = c.phase_range_min / 4;
    c.phase_speed_max = static_cast<step_t>(
        std::lround(std::min(Q30, PHASE_TURNS * STEPS_PER_TURN / w.tuning.slow_ticks)));
}

void set_current_limits(supervision_cfg_t &c, const Watched &w)
{
    c.follow_error_max = w.current(FOLLOW_SHARE, FOLLOW_LSB);
    c.residual_max = std::min(w.current(RESIDUAL_SHARE, FOLLOW_LSB), RESIDUAL_END);
    c.sum_max = std::min(
        w.current(0, SUM_LSB) + static_cast<int32_t>(std::lround(SUM_SHARE * Q15 / 2)), SUM_END);
    c.sum_share_q15 = static_cast<int32_t>(
        std::lround(SUM_TOLERANCES * w.board.current_gain_tolerance_pct / 100 * (Q15 - 1)));
    while (c.mean_shift < 14 &&
           std::ldexp(w.period_s, static_cast<int>(c.mean_shift)) < MEAN_TIME_S) {
        c.mean_shift++;
    }
}

void set_speed_limits(supervision_cfg_t &c, const Watched &w)
{
    c.speed_error_max = w.speed(SPEED_ERROR_SHARE);
    c.speed_error_periods = w.periods(
        std::max(SPEED_ERROR_TIME_S, SPEED_ERROR_TIME_SHARE / w.tuning.speed_bandwidth_hz));
    // An estimate may run away without its rotor. The speed of a sensor is the rotor's, so
    // OVERSPEED names it, which is as soon.
    const bool is_sensed = w.tuning.angle_source == AngleSource::sensor;
    c.runaway_periods = w.periods(is_sensed ? OVERSPEED_TIME_S : RUNAWAY_TIME_S);
    c.overspeed = w.speed(OVERSPEED_SHARE);
    c.overspeed_periods = w.periods(OVERSPEED_TIME_S);
}

void set_stall_limits(supervision_cfg_t &c, const Watched &w)
{
    c.stall_current = w.current(STALL_SHARE, FOLLOW_LSB);
    c.stall_speed = std::min(w.speed(STANDSTILL), 1 << 29);
    c.stall_periods = w.periods(STALL_TIME_S);
}

// What an imposed current is allowed.
void set_imposed_limits(supervision_cfg_t &c, const Watched &w, const Model &m)
{
    const double resistive = VOLTAGE_RESISTANCE_SHARE * m.resistance * w.motor.max_current_a;
    const double voltage = resistive + VOLTAGE_BUS_SHARE * w.board.bus_nominal_v;
    keep(c.voltage_max, voltage / w.b.voltage_v * Q15, 1, MANTISSA_MAX);
    if (w.tuning.startup_current_pct > 0) {
        c.swing_periods =
            slow_periods(UNLIKE_SWING / swing_rad_s(w.motor, w.board, w.tuning, m), w.tuning, w.b);
    }
}

} // namespace

supervision_cfg_t make_supervision(const MotorSettings &motor, const BoardSettings &board,
                                   const TuningSettings &tuning, const Model &m, double period_s,
                                   const Bases &b)
{
    const Watched watched = {motor, board, tuning, period_s, b};
    supervision_cfg_t c{};
    set_phase_limits(c, watched);
    set_current_limits(c, watched);
    set_speed_limits(c, watched);
    set_stall_limits(c, watched);
    c.late_max = LATE_MAX;
    c.late_window = watched.periods(LATE_WINDOW_S);
    set_imposed_limits(c, watched, m);
    return c;
}

} // namespace nf
