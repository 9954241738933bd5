// SPDX-License-Identifier: MIT
#include "startup_units.h"

#include "align_units.h"
#include "flying_start_units.h"
#include "imposed_current.h"
#include "inductance_units.h"
#include "numbers.h"
#include "sampling_units.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Shares of the hand-over speed: the observer runs free from the first on, and hands back at the
// second.
constexpr double TRACK_SHARE = 0.5;
constexpr double HOLD_SHARE = 0.7;
constexpr double RESIDUAL_SHARE = 0.25; // of the continuous current
constexpr double LOST_SHARE = 0.75;
constexpr double LOST_TIME_S = 0.1;
// On the file's J the vector's ramp takes the torque of this share of the current in motion: a load
// of half the rated torque and three times J still follow.
constexpr double RAMP_TORQUE = 0.07;
constexpr double HANDOVER_TIME_S = 0.1;
// While the observer settles the vector becomes faster by this share of the hand-over speed: the
// EMF of more would be too much for a soft control of the current.
constexpr double SETTLE_RISE = 0.15;
// At low speed a drive has a load from this torque current on, as a share of the continuous one.
constexpr double LOAD_SHARE = 0.15;
constexpr uint32_t ATTEMPTS = 5;

// An imposed current is controlled firmly beyond these shares of the over-current: 0.96 of it
// together.
constexpr double ALONG_SHARE = 0.85;
constexpr double ACROSS_SHARE = 0.45;

constexpr double STIFF_COUNTS = 24; // as many as an identification asks for

// A current of fewer counts shows neither R nor a rotor that slips.
void check_stiff_current(const MotorSettings &motor, const BoardSettings &board)
{
    require(
        stiff_current(motor) / count_a(board), STIFF_COUNTS, HUGE_VAL,
        {"board.current_full_scale_a", board.current_full_scale_a, -1},
        "half of motor.flux_linkage_wb/(motor.inductance_q_h - motor.inductance_d_h) is the largest current "
        "that holds the rotor at the start; it has to be 24 counts of the converter");
}

// Refuses a hand-over beyond the motor's speed.
double handover_step(const MotorSettings &motor, const TuningSettings &tuning, const Bases &b)
{
    const double handover_rpm = motor.rated_speed_rpm * tuning.handover_speed_pct / 100;
    require(handover_rpm, 0, motor.max_speed_rpm, {"motor.rated_speed_rpm", motor.rated_speed_rpm},
            "the share startup.handover_speed_pct of it is within motor.max_speed_rpm");
    return b.step_from_rpm(handover_rpm);
}

void set_currents(startup_cfg_t &c, const MotorSettings &motor, const BoardSettings &board,
                  const TuningSettings &tuning, const Bases &b)
{
    const double current = hold_current(motor, board, tuning) / b.current_a * Q15;
    store(c.current_hold, current, HOLD_MIN, Q14,
          {"startup.current_pct", tuning.startup_current_pct}, CURRENT_REASON);
    store(c.current_move, moving_current(motor, board, tuning) / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, CURRENT_REASON);
    c.current_slope = c.align.slope;
    c.along_max = std::max(current_q15(ALONG_SHARE * board.overcurrent_a, b), c.current_move);
    c.across_max = current_q15(ACROSS_SHARE * board.overcurrent_a, b);
}

void set_speeds(startup_cfg_t &c, double handover, const MotorSettings &motor,
                const BoardSettings &board, const TuningSettings &tuning, const Model &m,
                const Bases &b)
{
    keep(c.handover_speed, handover, 2, Q30 / 2);
    const double acceleration =
        RAMP_TORQUE * m.torque_acceleration * moving_current(motor, board, tuning);
    keep(c.ramp,
         std::ceil(acceleration * tuning.slow_ticks * std::pow(b.control_period_s, 2) / TWO_PI *
                   STEPS_PER_TURN),
         1, Q30 / 2);
    keep(c.track_speed, handover * TRACK_SHARE, 1, c.handover_speed);
    keep(c.hold_speed, handover * HOLD_SHARE, 1, c.handover_speed - 1);
}

void set_judgement(startup_cfg_t &c, const MotorSettings &motor, const TuningSettings &tuning,
                   const Bases &b)
{
    const double continuous = continuous_current(motor) / b.current_a * Q15;
    keep(c.residual_max, RESIDUAL_SHARE * continuous, 1, Q14);
    keep(c.residual_lost, LOST_SHARE * continuous, c.residual_max, Q14);
    c.lost_periods = slow_periods(LOST_TIME_S, tuning, b);
    c.handover_periods = slow_periods(HANDOVER_TIME_S, tuning, b);
    const auto settle = static_cast<uint32_t>(SETTLE_RISE * c.handover_speed / c.ramp);
    c.settle_periods = std::min(settle, c.handover_periods / 2);
}

// RUN under a load, below hold_speed.
void set_loaded_run(startup_cfg_t &c, const MotorSettings &motor, const TuningSettings &tuning,
                    const Bases &b)
{
    const bool loaded = tuning.loaded_speed_pct > 0;
    require({"startup.loaded_speed_pct", tuning.loaded_speed_pct}, 0,
            HOLD_SHARE * tuning.handover_speed_pct,
            "0.7 of startup.handover_speed_pct, where RUN without a load ends");
    const double speed = b.step_from_rpm(motor.rated_speed_rpm * tuning.loaded_speed_pct / 100);
    keep(c.loaded_speed, loaded ? speed : c.hold_speed, 1, c.hold_speed);
    keep(c.load_current, LOAD_SHARE * continuous_current(motor) / b.current_a * Q15, 1, Q14);
}

// A start imposes its current whatever the bus gives: what that takes at standstill has to be
// allowed.
void check_imposed_power(const startup_cfg_t &c, const BoardSettings &board, const Model &m,
                         const Bases &b)
{
    if (board.bus_current_max_a > 0) {
        const double imposed = std::max(c.current_move, c.align.current_high) / Q15 * b.current_a;
        require({"board.bus_current_max_a", board.bus_current_max_a},
                BUS_CURRENT_FACTOR * m.resistance * imposed * imposed / board.bus_nominal_v,
                HUGE_VAL, "what the current that a start imposes takes from board.bus_nominal_v");
    }
}

} // namespace

startup_cfg_t make_startup(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                           const Bases &b)
{
    startup_cfg_t c{};
    if (!(tuning.startup_current_pct > 0)) {
        return c;
    }
    check_stiff_current(motor, board);
    const double handover = handover_step(motor, tuning, b);
    c.flying_start = make_flying_start(motor, board, m, b);
    c.align = make_align(motor, board, tuning, scales, m, b);
    set_currents(c, motor, board, tuning, b);
    set_speeds(c, handover, motor, board, tuning, m, b);
    set_judgement(c, motor, tuning, b);
    set_loaded_run(c, motor, tuning, b);
    c.attempts = ATTEMPTS;
    check_imposed_power(c, board, m, b);
    return c;
}

double startup_time(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &as_written)
{
    const TuningSettings tuning = for_sensor(as_written);
    if (!(tuning.startup_current_pct > 0)) {
        return 0;
    }
    const Bases b = make_bases(motor, board);
    const Model model = make_model(motor, ModelScales());
    const double swing = swing_rad_s(motor, board, tuning, model);
    return flying_start_time_s(motor, model, b) + board.bootstrap_charge_s +
           align_pull_time_s(swing, b) + align_settle_time_s(swing) +
           align_measure_time_s(swing, b) + inductance_time_s(b);
}

} // namespace nf
