// SPDX-License-Identifier: MIT
#include "low_speed_units.h"

#include "rules.h"

#include <algorithm>

namespace nf
{
namespace
{

// Times of the alignment in units of 1/ω_n, the rotor's swing in the field of the imposed current. Half a
// turn of the vector in 8 leaves no starting angle from which the rotor swings back by half a turn under 40 % of
// rated torque (measured over 64 angles; 5 does); after three times as long a swing damped with 0.3 has gone
// down to 1/1000.
constexpr double RISE = 0.8;
constexpr double SWEEP = 8;
constexpr double PULL = 24;
constexpr double SETTLE = 6;
constexpr double MEASURE = 4;
// The second level of the current: well apart from the first, and still enough to hold a load.
constexpr double LOW_SHARE = 0.62;
// A rotor rests while the current across stays below the smaller of two limits. One is the share from which on a rotor slips. The
// other is what the EMF at this share of the hand-over speed drives, but at least so many counts: noise of 1.5 counts reaches
// 4.5 times that in 2^16 samples of a winding, and nearly twice as much across.
constexpr double REST_SHARE = 1.0 / ALIGN_SLIP_SHARE;
constexpr double REST_SPEED = 0.125;
constexpr double REST_LSB = 12;
// Between them voltages for L_d and L_q: at most this share of the bus, so that the duty has room.
constexpr double STEP_SHARE = 0.3;
constexpr double STEP_TICKS_MIN = 2; // a filter before the converter takes less of it than of one
constexpr double STEP_TICKS_MAX = 16;
// The current across swings by this share of the imposed one. From 1/√3 on, a phase with half of it against it passes
// through zero; so an L_q of 0.6 of the file's is still measured without dead time.
constexpr double PULSE_SHARE = 0.3;
constexpr double PULSE_QUARTERS = 4;
// Damping wanted of the rotor's swing, and the slow integral that sets the mean current, per ω_n. Where R is more than that
// damping asks for, a negative K_p takes this share of R off. A winding of 0.7 of the file's R keeps 0.4 of its own.
constexpr double HOLD_DAMPING = 0.7;
constexpr double HOLD_INTEGRAL = 0.2;
constexpr double HOLD_RELIEF = 0.4;
// The dead-time compensation is off by up to 0.14 of what a leg loses, and by more the smaller the current is.
constexpr double HOLD_LOSS_SHARE = 0.2;

// A pulse that looks for a turning rotor ends at this share of the largest current.
constexpr double FLYING_START_SHARE = 0.05;
constexpr double FLYING_START_LSB = 25; // or so many counts: 4 % of noise, 2°
// Open gates put the bus against a current, which ends in L·I/U: ten times what 100 mH, 30 A and 300 V take.
constexpr double FLYING_START_WAIT_S = 0.1;
constexpr int FLYING_START_TICKS = 8;
constexpr double FLYING_START_GAP_MAX = 64;
// Turns between the ends of two pulses: below a half is unique, at the highest speed with the shortest pulse …
constexpr double FLYING_START_TURN_MAX = 0.4;
// … and in general, where a pulse may be twice as long as needed, and L/φ 1.4 times that of the file. Device drop and noise
// turn a direction by some 4°, so that the turn must not be much smaller either.
constexpr double FLYING_START_TURN = 0.15;
// In the pause the speed must not change much: a tenth of the highest one at the rated torque.
constexpr double FLYING_START_CHANGE = 0.1;
constexpr double FLYING_START_PAUSE_MIN = 32;
constexpr double FLYING_START_PAUSE_MAX = 256;

// Shares of the hand-over speed: the observer runs free from the first on, and hands back at the second.
constexpr double TRACK_SHARE = 0.5;
constexpr double HOLD_SHARE = 0.7;
constexpr double RESIDUAL_SHARE = 0.25; // of the continuous current
constexpr double LOST_SHARE = 0.75;
constexpr double LOST_TIME_S = 0.1;
// The least current goes so many times more slowly than it comes. A voltage drive takes over without it, and does not wait.
constexpr int32_t CURRENT_FALL = 32;
// Of a salient machine the least current takes φ − (L_q − L_d)·i_d down. Where it takes more than this share of φ it goes as fast as a
// torque comes: the torque, and the estimate of the angle, have only the flux that is left.
constexpr double FLUX_TAKEN = 0.125;
// On the file's J the vector's ramp takes the torque of this share of the current in motion: a load of half the rated torque and
// three times J still follow.
constexpr double RAMP_TORQUE = 0.07;
constexpr double HANDOVER_TIME_S = 0.1;
// While the observer settles the vector becomes faster by this share of the hand-over speed: the EMF of more would be too much for
// a soft control of the current.
constexpr double SETTLE_RISE = 0.15;
// At low speed a drive has a load from this torque current on, as a share of the continuous one.
constexpr double LOAD_SHARE = 0.15;
constexpr uint32_t ATTEMPTS = 5;

// What supervision allows an imposed current, in units of 1/ω_n of its swing: the turning point can hold a phase at zero
// for 1.4, and the leg's dead time keeps it there, for 3 as measured; what lasts twice as long is no swing.
// The current control adds at most this much to R·i and the EMF: for the winding's R at 100 K more than cold, and for a
// dead time of 2 % of the period that nobody compensates. A rotor that is pulled in can take more for half a swing.
constexpr double UNLIKE_SWING = 6;
constexpr double VOLTAGE_RESISTANCE_SHARE = 0.4;
constexpr double VOLTAGE_BUS_SHARE = 0.03;

constexpr double FLUX_TIME_S = 0.05;
constexpr double FLUX_SPEED_SHARE = 0.2; // of rated speed

const char *const CURRENT_REASON = "the firmware's steps of current";

constexpr double PERIODS_MAX = 60000; // what a counter of slow periods is set to at most
constexpr double HOLD_MIN = 8;        // Q15: less than a count of a 12-bit converter is no current
constexpr double PI_GAIN_MAX = 16000; // of a gain that no file writes: within make_pi's format

// While the rotor is pulled in, its EMF drives up to 0.8 of the imposed current on top of it.
constexpr double SWING_HEADROOM = 1.8;

// An imposed current is controlled firmly beyond these shares of the over-current: 0.96 of it together.
constexpr double ALONG_SHARE = 0.85;
constexpr double ACROSS_SHARE = 0.45;

// A vector of the current φ/(L_q − L_d) has no stiffness against a rotor on it: the reluctance turns it away as strongly as the
// magnet holds it. Half of it leaves half of the stiffness, if the file's L_d and L_q are right.
constexpr double SALIENT_SHARE = 0.5;
constexpr double STIFF_COUNTS = 24; // as many as an identification asks for

// The largest current along the flux that is imposed, at rest and in motion, and in RUN. The observer sees the angle by the same
// active flux.
double stiff_current(const MotorSettings &motor)
{
    const double saliency = motor.inductance_q_h - motor.inductance_d_h;
    return saliency > 0 ? SALIENT_SHARE * motor.flux_linkage_wb / saliency : HUGE_VAL;
}

double hold_current(const MotorSettings &motor, const BoardSettings &board,
                    const TuningSettings &tuning)
{
    return std::min({tuning.startup_current_pct / 100 * continuous_current(motor),
                     board.overcurrent_a / SWING_HEADROOM, motor.max_current_a,
                     stiff_current(motor)});
}

// What the imposed current takes of R·I, as a multiple of the EMF at the hand-over: R, known within some percent, and gains of
// sensors 2 % apart then leave the angle within some degrees.
constexpr double HIDDEN_EMF = 3;

// Electrical.
double handover_rad_s(const MotorSettings &motor, const TuningSettings &tuning)
{
    return tuning.handover_speed_pct / 100 * motor.pole_pairs *
           rad_s_from_rpm(motor.rated_speed_rpm);
}

// In motion: what the motor bears, within what its saliency allows and its EMF can be seen beside; never less than at rest, or a
// load would be lost.
double moving_current(const MotorSettings &motor, const BoardSettings &board,
                      const TuningSettings &tuning)
{
    const double seen =
        HIDDEN_EMF * handover_rad_s(motor, tuning) * motor.flux_linkage_wb / motor.resistance_ohm;
    return std::clamp(std::min(stiff_current(motor), seen), hold_current(motor, board, tuning),
                      motor.max_current_a);
}

// ψ/φ: what is left of the flux that a swing moves past an imposed current, as the reluctance takes (L_q − L_d)·I off it. A half at
// least, by stiff_current().
double active_share(double current_a, const MotorSettings &motor)
{
    return 1 - SALIENT_SHARE * current_a / stiff_current(motor);
}

// The rotor in the field of the current I: J/P·δ'' = −1.5·P·ψ·I·δ with the active flux ψ.
double swing_rad_s(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m)
{
    const double current = hold_current(motor, board, tuning);
    return std::sqrt(m.torque_acceleration * current * active_share(current, motor));
}

uint32_t ticks(double seconds, const Bases &b)
{
    return static_cast<uint32_t>(
        std::clamp(std::ceil(seconds / b.control_period_s), 1.0, 1048576.0));
}

// The imposed current's change in a tick: it rises in the rotor's own time.
int32_t hold_slope(const MotorSettings &motor, const BoardSettings &board,
                   const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const double current = hold_current(motor, board, tuning) / b.current_a * Q15;
    const double rise_s = RISE / swing_rad_s(motor, board, tuning, m);
    return static_cast<int32_t>(std::max(1.0, std::ceil(current / ticks(rise_s, b))));
}

int32_t current_q15(double current_a, const Bases &b)
{
    return static_cast<int32_t>(std::lround(current_a / b.current_a * Q15));
}

uint32_t slow_periods(double seconds, const TuningSettings &tuning, const Bases &b)
{
    return static_cast<uint32_t>(
        std::clamp(std::ceil(seconds / b.control_period_s / tuning.slow_ticks), 1.0, PERIODS_MAX));
}

uint32_t measure_log2(double swing, const Bases &b)
{
    const double wanted = MEASURE / swing / b.control_period_s;
    return static_cast<uint32_t>(std::clamp(std::ceil(std::log2(wanted)), 6.0, 16.0));
}

// How long a voltage acts that changes a flux linkage by so much.
uint32_t step_ticks(double flux, const BoardSettings &board, const Bases &b)
{
    const double needed = flux / (STEP_SHARE * board.bus_nominal_v) / b.control_period_s;
    return static_cast<uint32_t>(std::clamp(std::ceil(needed), STEP_TICKS_MIN, STEP_TICKS_MAX));
}

// The step along the current lowers it by fall_a; what R·i takes from it is added.
void set_voltage_step(inductance_cfg_t &c, double fall_a, const BoardSettings &board,
                      const Model &m, const Bases &b)
{
    const double flux = m.inductance_d * fall_a;
    c.step_ticks = step_ticks(flux, board, b);
    const double time_s = c.step_ticks * b.control_period_s;
    const double drop = m.resistance * time_s / (2 * m.inductance_d);
    const double voltage = std::min(STEP_SHARE * board.bus_nominal_v, flux / time_s * (1 + drop));
    keep(c.step_voltage, voltage / b.voltage_v * Q15, 1, MANTISSA_MAX);
    keep(c.step_response, voltage * time_s / m.inductance_d / b.current_a * Q15, 1, Q14);
}

void set_voltage_pulse(inductance_cfg_t &c, double swing_a, const BoardSettings &board,
                       const Model &m, const Bases &b)
{
    const double flux = m.inductance_q * swing_a;
    c.pulse_ticks = step_ticks(flux, board, b);
    const double time_s = c.pulse_ticks * b.control_period_s;
    const double voltage = std::min(STEP_SHARE * board.bus_nominal_v, flux / time_s);
    const double response_a = PULSE_QUARTERS * voltage * time_s / m.inductance_d;
    keep(c.pulse_voltage, voltage / b.voltage_v * Q15, 1, MANTISSA_MAX);
    keep(c.pulse_response, response_a / b.current_a * Q15, 1, 2 * Q15 - 1);
}

// Half a turn of the vector: in the rotor's own time, and not faster than the drive may turn.
double sweep_time_s(double swing, const Bases &b)
{
    return std::max(SWEEP / swing, STEPS_PER_TURN / 2 / b.speed_limit * b.control_period_s);
}

// The hold's, unless it is written; within the same limits.
double align_current(const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning)
{
    TuningSettings aligning = tuning;
    if (tuning.align_current_pct > 0) {
        aligning.startup_current_pct = tuning.align_current_pct;
    }
    return hold_current(motor, board, aligning);
}

// A count of the converter.
double count_a(const BoardSettings &board)
{
    return board.current_full_scale_a / std::ldexp(1.0, board.adc_bits - 1);
}

// K_p of the imposed current's control, in ohm, which adds to R: both together damp the swing as wanted. Below the swing's ω_n·L_q
// the current lags behind the EMF and damps less; below a share of V_dt/I the errors of the dead-time compensation set the current.
double hold_gain_ohm(const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning, const ModelScales &scales, const Model &m)
{
    const double current = hold_current(motor, board, tuning);
    const double swing = swing_rad_s(motor, board, tuning, m);
    const double loss_v = leg_loss_v(board, scales.dead_time_s, scales.device_drop_v);
    const double wanted =
        std::max({swing * active_share(current, motor) * m.flux / (2 * HOLD_DAMPING * current),
                  swing * m.inductance_q, HOLD_LOSS_SHARE * loss_v / current});
    return std::max(wanted - m.resistance, -HOLD_RELIEF * m.resistance);
}

// What may flow across the vector while the rotor rests. A rotor that slips drives its EMF over R and K_p: where R·I is many times
// that EMF, it is a small part of the current. A current of less than 60 counts does not tell a slip from noise.
double resting_swing(double current_a, const MotorSettings &motor, const BoardSettings &board,
                     const TuningSettings &tuning, const ModelScales &scales, const Model &m)
{
    const double emf_v = REST_SPEED * handover_rad_s(motor, tuning) * m.flux;
    const double slips_a = emf_v / (m.resistance + hold_gain_ohm(motor, board, tuning, scales, m));
    return std::min(REST_SHARE * current_a, std::max(slips_a, REST_LSB * count_a(board)));
}

align_cfg_t make_align(const MotorSettings &motor, const BoardSettings &board,
                       const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                       const Bases &b)
{
    const double current = align_current(motor, board, tuning);
    const double swing = swing_rad_s(motor, board, tuning, m);
    align_cfg_t c{};
    const Source written = {"startup.align_current_pct", tuning.align_current_pct};
    store(c.current_high, current / b.current_a * Q15, tuning.align_current_pct > 0 ? HOLD_MIN : 0,
          Q14, written, CURRENT_REASON);
    c.current_low = current_q15(current * LOW_SHARE, b);
    keep(c.swing_max, resting_swing(current, motor, board, tuning, scales, m) / b.current_a * Q15,
         1, Q14);
    c.slope = hold_slope(motor, board, tuning, m, b);
    c.sweep_ticks = ticks(sweep_time_s(swing, b), b);
    keep(c.sweep_speed, STEPS_PER_TURN / 2 / c.sweep_ticks, 1, b.speed_limit);
    c.pull_ticks = std::max(c.sweep_ticks, ticks(sweep_time_s(swing, b) * (PULL / SWEEP), b));
    c.settle_ticks = ticks(SETTLE / swing, b);
    c.measure_log2 = measure_log2(swing, b);
    set_voltage_step(c.inductance, current * (1 - LOW_SHARE), board, m, b);
    set_voltage_pulse(c.inductance, current * PULSE_SHARE, board, m, b);
    return c;
}

double flying_start_current(const MotorSettings &motor, const BoardSettings &board)
{
    return std::max(FLYING_START_SHARE * motor.max_current_a, FLYING_START_LSB * count_a(board));
}

// In lengths of a pulse, in which the rotor turns by I·L_q/φ.
double flying_start_gap(const MotorSettings &motor, const BoardSettings &board, const Model &m,
                        const Bases &b)
{
    const double fastest = m.max_speed_el * b.control_period_s / TWO_PI;
    const double pulse = flying_start_current(motor, board) * m.inductance_q / m.flux / TWO_PI;
    const double most = std::min(FLYING_START_TURN_MAX / fastest, FLYING_START_TURN / pulse) - 1;
    return std::clamp(std::floor(most), 1.0, FLYING_START_GAP_MAX);
}

double flying_start_pause_max(const MotorSettings &motor, const Model &m, const Bases &b)
{
    const double speeding_up = m.max_speed_el / (m.torque_acceleration * rated_current(motor));
    return std::clamp(std::floor(FLYING_START_CHANGE * speeding_up / b.control_period_s),
                      FLYING_START_PAUSE_MIN, FLYING_START_PAUSE_MAX);
}

flying_start_cfg_t make_flying_start(const MotorSettings &motor, const BoardSettings &board,
                                     const Model &m, const Bases &b)
{
    flying_start_cfg_t c{};
    store(c.current, flying_start_current(motor, board) / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, CURRENT_REASON);
    c.wait_ticks = ticks(FLYING_START_WAIT_S, b);
    c.pulse_ticks = FLYING_START_TICKS;
    c.gap_factor = static_cast<uint32_t>(flying_start_gap(motor, board, m, b));
    c.pause_max = static_cast<uint32_t>(flying_start_pause_max(motor, m, b));
    // The EMF lies along q. What R takes in a tick: a = T·R/L_q.
    const double a = b.control_period_s * m.resistance / m.inductance_q;
    const double left = -std::expm1(-a) / a;
    const double per_step =
        TWO_PI / STEPS_PER_TURN * m.flux / m.inductance_q * left / b.current_a * Q15;
    const Mantissa emf =
        normalise(std::ldexp(per_step, 16), 0, 30, {"motor.flux_linkage_wb", motor.flux_linkage_wb},
                  CURRENT_REASON);
    c.emf_current = emf.value;
    c.emf_shift = emf.shift;
    keep(c.decay_q15, -std::expm1(-a) * Q15, 0, MANTISSA_MAX);
    c.charge_ticks = board.bootstrap_charge_s > 0 ? ticks(board.bootstrap_charge_s, b) : 0;
    return c;
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

gain_share_cfg_t make_gain_share(double full_speed, double least)
{
    gain_share_cfg_t c{};
    c.least_q14 = static_cast<int32_t>(std::lround(least * Q14));
    keep(c.full_speed, full_speed, 0, Q30 / 4);
    int32_t mantissa = c.full_speed;
    while (mantissa >= Q14) {
        mantissa >>= 1;
        c.shift++;
    }
    if (mantissa > 0) {
        keep(c.gain, Q14 * Q14 / mantissa, 0, MANTISSA_MAX);
    }
    return c;
}

} // namespace

// A current of fewer counts shows neither R nor a rotor that slips.
static void check_stiff_current(const MotorSettings &motor, const BoardSettings &board)
{
    require(
        stiff_current(motor) / count_a(board), STIFF_COUNTS, HUGE_VAL,
        {"board.current_full_scale_a", board.current_full_scale_a, -1},
        "half of motor.flux_linkage_wb/(motor.inductance_q_h - motor.inductance_d_h) is the largest current "
        "that holds the rotor at the start; it has to be 24 counts of the converter");
}

ModelHeadroom model_headroom(const TuningSettings &tuning)
{
    const double r = tuning.adapt_resistance_pct / 100;
    const double l = tuning.adapt_inductance_pct / 100;
    const double f = tuning.adapt_flux_pct / 100;
    const double s = tuning.adapt_saliency_pct / 100;
    return {(1 + r) / (1 - l), (1 + l) * (1 + l), (1 + f) / (1 - l), 1 + s, (1 + l) * (1 + s)};
}

startup_cfg_t make_startup(const MotorSettings &motor, const BoardSettings &board,
                           const TuningSettings &tuning, const ModelScales &scales, const Model &m,
                           const Bases &b)
{
    startup_cfg_t c{};
    if (!(tuning.startup_current_pct > 0)) {
        return c;
    }
    check_stiff_current(motor, board);
    const double current = hold_current(motor, board, tuning) / b.current_a * Q15;
    const double handover_rpm = motor.rated_speed_rpm * tuning.handover_speed_pct / 100;
    require(handover_rpm, 0, motor.max_speed_rpm, {"motor.rated_speed_rpm", motor.rated_speed_rpm},
            "the share startup.handover_speed_pct of it is within motor.max_speed_rpm");
    const double handover = b.step_from_rpm(handover_rpm);
    c.flying_start = make_flying_start(motor, board, m, b);
    c.align = make_align(motor, board, tuning, scales, m, b);
    store(c.current_hold, current, HOLD_MIN, Q14,
          {"startup.current_pct", tuning.startup_current_pct}, CURRENT_REASON);
    const double moving_a = moving_current(motor, board, tuning);
    store(c.current_move, moving_a / b.current_a * Q15, 1, Q14,
          {"motor.max_current_a", motor.max_current_a}, CURRENT_REASON);
    c.current_slope = c.align.slope;
    c.along_max = std::max(current_q15(ALONG_SHARE * board.overcurrent_a, b), c.current_move);
    c.across_max = current_q15(ACROSS_SHARE * board.overcurrent_a, b);
    keep(c.handover_speed, handover, 2, Q30 / 2);
    const double acceleration = RAMP_TORQUE * m.torque_acceleration * moving_a;
    keep(c.ramp,
         std::ceil(acceleration * tuning.slow_ticks * std::pow(b.control_period_s, 2) / TWO_PI *
                   STEPS_PER_TURN),
         1, Q30 / 2);
    keep(c.track_speed, handover * TRACK_SHARE, 1, c.handover_speed);
    keep(c.hold_speed, handover * HOLD_SHARE, 1, c.handover_speed - 1);
    const double continuous = continuous_current(motor) / b.current_a * Q15;
    keep(c.residual_max, RESIDUAL_SHARE * continuous, 1, Q14);
    keep(c.residual_lost, LOST_SHARE * continuous, c.residual_max, Q14);
    c.lost_periods = slow_periods(LOST_TIME_S, tuning, b);
    c.handover_periods = slow_periods(HANDOVER_TIME_S, tuning, b);
    const auto settle = static_cast<uint32_t>(SETTLE_RISE * c.handover_speed / c.ramp);
    c.settle_periods = std::min(settle, c.handover_periods / 2);
    set_loaded_run(c, motor, tuning, b);
    c.attempts = ATTEMPTS;
    return c;
}

// The magnets bear the i_d of the largest torque of the largest current: 4·ΔL·|i_d| = √(φ² + 8·ΔL²·I²) − φ.
static void check_most_torque(const MotorSettings &motor)
{
    const double saliency = motor.inductance_q_h - motor.inductance_d_h;
    if (saliency <= 0 || !(motor.demagnetising_current_a > 0)) {
        return;
    }
    const double flux = motor.flux_linkage_wb;
    const double root = std::sqrt(flux * flux + 8 * std::pow(saliency * motor.max_current_a, 2));
    require((root - flux) / (4 * saliency), 0, motor.demagnetising_current_a,
            {"motor.max_current_a", motor.max_current_a},
            "above it the i_d of its largest torque is beyond motor.demagnetising_current_a; "
            "current_loop.most_torque = 0 leaves i_d at 0");
}

static int32_t current_fall(int32_t slope, double least_a, const MotorSettings &motor,
                            const TuningSettings &tuning)
{
    if (tuning.method == ControlMethod::voltage_phase) {
        return slope;
    }
    if (1 - active_share(least_a, motor) > FLUX_TAKEN) {
        return static_cast<int32_t>(Q14);
    }
    return std::max(slope / CURRENT_FALL, 1);
}

current_reference_cfg_t make_current_reference(const MotorSettings &motor,
                                               const BoardSettings &board,
                                               const TuningSettings &tuning,
                                               const ModelScales &scales, const Model &m,
                                               const Bases &b)
{
    const bool crossing = scales.dead_time_s > 0 || scales.device_drop_v > 0;
    const double floor = crossing ? tuning.current_floor_pct / 100 : 0;
    TuningSettings own = tuning;
    if (!(own.startup_current_pct > 0)) {
        own.startup_current_pct = 100;
    }
    current_reference_cfg_t c{};
    const double least = std::min(floor * continuous_current(motor), stiff_current(motor));
    keep(c.floor, least / b.current_a * Q15, 0, Q14);
    const bool gives_over = tuning.method == ControlMethod::voltage_phase;
    c.floor_shift = gives_over ? 0 : 1;
    c.slope = hold_slope(motor, board, own, m, b);
    c.slope_down = current_fall(c.slope, least, motor, tuning);
    c.most_torque = tuning.most_torque != 0 && !gives_over ? 1 : 0;
    if (c.most_torque != 0) {
        check_most_torque(motor);
    }
    keep(c.deepest, deepest_current(motor, tuning) / b.current_a * Q15, 0, Q14);
    return c;
}

run_cfg_t make_run(const TuningSettings &tuning)
{
    run_cfg_t c{};
    c.acceleration_q14 = static_cast<int32_t>(std::lround(tuning.observer_acceleration * Q14));
    return c;
}

current_loop_cfg_t make_hold_loop(const current_loop_cfg_t &run_loop, const MotorSettings &motor,
                                  const BoardSettings &board, const TuningSettings &tuning,
                                  const ModelScales &scales, const Model &m, const Bases &b)
{
    current_loop_cfg_t c = run_loop;
    if (tuning.startup_current_pct > 0) {
        const double swing = swing_rad_s(motor, board, tuning, m);
        const double kp = hold_gain_ohm(motor, board, tuning, scales, m);
        const double ki = (m.resistance + kp) * HOLD_INTEGRAL * swing * b.control_period_s;
        const double base = b.voltage_v / b.current_a;
        c.pi_d = make_pi(std::min(std::abs(kp) / base, PI_GAIN_MAX),
                         std::min(ki / base, PI_GAIN_MAX / 2048), 1, "startup.current_pct",
                         tuning.startup_current_pct);
        c.pi_d.kp *= kp < 0 ? -1 : 1;
        c.pi_q = c.pi_d;
    }
    return c;
}

void set_imposed_limits(supervision_cfg_t &c, const MotorSettings &motor,
                        const BoardSettings &board, const TuningSettings &tuning, const Model &m,
                        const Bases &b)
{
    const double resistive = VOLTAGE_RESISTANCE_SHARE * m.resistance * motor.max_current_a;
    const double voltage = resistive + VOLTAGE_BUS_SHARE * board.bus_nominal_v;
    keep(c.voltage_max, voltage / b.voltage_v * Q15, 1, MANTISSA_MAX);
    if (tuning.startup_current_pct > 0) {
        c.swing_periods =
            slow_periods(UNLIKE_SWING / swing_rad_s(motor, board, tuning, m), tuning, b);
    }
}

model_cfg_t make_model_cfg(const MotorSettings &motor, const TuningSettings &tuning, const Model &m,
                           const Bases &b)
{
    const double slow_period = b.control_period_s * tuning.slow_ticks;
    model_cfg_t c{};
    c.resistance_limit_q14 =
        static_cast<int32_t>(std::lround(tuning.adapt_resistance_pct / 100 * Q14));
    c.inductance_limit_q14 =
        static_cast<int32_t>(std::lround(tuning.adapt_inductance_pct / 100 * Q14));
    c.saliency_limit_q14 = static_cast<int32_t>(std::lround(tuning.adapt_saliency_pct / 100 * Q14));
    c.flux_limit_q14 = static_cast<int32_t>(std::lround(tuning.adapt_flux_pct / 100 * Q14));
    keep(c.flux_rate, slow_period / FLUX_TIME_S * b.current_a / m.flux_current * Q15, 0,
         MANTISSA_MAX);
    keep(c.flux_speed_min, b.step_from_rpm(motor.rated_speed_rpm * FLUX_SPEED_SHARE), 0, Q30 / 2);
    const double rated = b.step_from_rpm(motor.rated_speed_rpm);
    c.pace = make_gain_share(tuning.pace_speed_pct / 100 * rated, tuning.pace_least);
    c.kappa = make_gain_share(tuning.kappa_speed_pct / 100 * rated, tuning.kappa_least);
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
    const double pause = flying_start_pause_max(motor, model, b);
    const double looking = (2 * FLYING_START_TICKS + pause + 2) * b.control_period_s;
    const double measuring = 2 * std::exp2(measure_log2(swing, b)) * b.control_period_s;
    const double pulling = sweep_time_s(swing, b) * (PULL / SWEEP);
    return looking + board.bootstrap_charge_s + pulling + SETTLE / swing + measuring +
           (1 + PULSE_QUARTERS) * STEP_TICKS_MAX * b.control_period_s;
}

} // namespace nf
