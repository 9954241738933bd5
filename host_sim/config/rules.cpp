// SPDX-License-Identifier: MIT
#include "rules.h"

#include "modulator_units.h"
#include "motor_model.h"
#include "nn_observer_units.h"
#include "numbers.h"
#include "speed_margin.h"
#include "torque_filter_units.h"

#include <algorithm>

namespace nf
{
namespace
{

// The motion loops by what the motor can do: its largest torque T_max = 1.5·P·φ·I_max on its
// inertia J.
//
// Speed: full torque at an error of 1/(2·ζ·4.3) = 12 % of rated speed (ζ = 1). A faster loop turns
// the ripple of the estimate into torque: with dead time 2 % of ripple is then a fifth of the
// torque.
constexpr double SPEED_PER_TORQUE = 4.3;
// And not faster than this many radians of the rotor at rated speed where dead time takes as much
// voltage as the EMF at the hand-over makes: that ripple of the estimate is not to be followed. In
// proportion.
constexpr double SPEED_PER_LOSS = 0.15;
// Nor so fast that its observer exceeds this by ω/X², X = L·I/φ: what is wrong of a current moves
// the estimate by a share X, and light rotors of large X swing in it. Where X is 0.2, as motor A's,
// this takes nothing off.
constexpr double OBSERVER_PER_REACTANCE = 0.5;
// But at least this, whatever the dead time and the reactance: a step of half the torque then takes
// half the rated speed off before the loop has answered. With less the rotor stalls, and exceeds
// its highest speed when the load goes.
constexpr double SPEED_PER_TORQUE_LEAST = 1;
// Torque: from none to the largest in the time of the speed loop, 1/ω of it: neither of the two
// waits for the other.
//
// Ramp and profile leave the rest of the torque to the load.
constexpr double RAMP_TORQUE = 0.27;
constexpr double PROFILE_TORQUE = 0.2;
constexpr double PROFILE_SPEED = 0.5; // of rated
// The position loop below the speed loop, and the soft end of its profile in units of 1/bandwidth.
constexpr double POSITION_SHARE = 1 / 2.8;
constexpr double SOFTNESS = 0.3;

// The observer by the speed loop that it serves. Its lag is the longest that takes no more than
// 9.5° of phase from that loop: a faster observer only lets more noise and more of the dead time's
// ripple through.
constexpr double LAG_PHASE = 0.165;
// And the ramp may not turn the lag into an error beyond this share of rated speed.
constexpr double LAG_RAMP = 0.0105;
// κ_p²/κ: with it the estimate settles without a swing, damping √8.1/2 = 1.4.
constexpr double OBSERVER_SHAPE = 8.1;
// The proportional path takes this share of the error in a sample at most, or the samples become
// visible.
constexpr double KAPPA_P_MAX = 0.45;
// It works within a radian of the rotor at rated speed at least, or the angle is lost in a fast
// change.
constexpr double OBSERVER_RADIAN = 1;

// The published law has no such path. It is damped from 1.5·(ωT)² on; twice as much, or what the
// paper's motor has.
constexpr double KAPPA_PUBLISHED = 3;
constexpr double KAPPA_LEAST = 0.025;

// ρ by how many times faster than the rotor turns the proportional path is: what it lets through, ρ
// amplifies.
constexpr double RHO_PER_RATE = 0.1;
constexpr double RHO_LEAST = 1;
constexpr double RHO_MOST = 1.25;

// What an error of the network loses in a sample at least. R/L alone damps too little on a fast
// PWM; much more hides the error that the speed is found by.
constexpr double DECAY_LEAST = 0.1;
// And not more than so many times the rotor's turn at rated speed: the current that shows an angle
// error is then still a third of what it is without feedback.
constexpr double DECAY_PER_RADIAN = 3;

// The current loop has 20 samples in a period of its bandwidth: π/10 rad in one, and as much again
// in the delay.
constexpr double CURRENT_SAMPLES = 20;

// The least current in percent, without dead time and for each R·I of its voltage.
constexpr double FLOOR_PCT = 18;
constexpr double FLOOR_SLOPE_PCT = 40;
constexpr double FLOOR_MAX_PCT = 50;
// As i_d > 0 it raises the voltage at rated speed, up to this share of the voltage circle.
constexpr double FLOOR_VOLTAGE = 0.95;

// The voltage's speed PI: share of φ, as the EMF is φ for 1 rad/s, and its corner, below R/L =
// 17…30/s. Chosen with motor B: docs/voltage_drive.md has the poles.
constexpr double VOLTAGE_PER_FLUX = 1.5;
constexpr double VOLTAGE_CORNER_S = 8;
// The virtual resistance as a share of ω·L at rated speed, and the corner of its mean as a share of
// ω: docs/voltage_drive.md.
constexpr double VIRTUAL_DAMPING = 0.45;
constexpr double VIRTUAL_MEAN_RADIAN = 0.6;
// In a sample it takes off this share of a change at most: the voltage acts a period and a half
// later.
constexpr double VIRTUAL_SHARE_MAX = 0.2;
// The lead of a braking drive stays this share above −atan(R/(ω·L_d)), where more voltage means
// less torque.
constexpr double BRAKE_SHARE = 0.8;

using T = TuningSettings;

// What leaves a setting to its rule: 0, or where 0 means something of its own, −1.
constexpr double LEFT_OPEN = -1;
enum class Open {
    at_zero,
    below_zero
};

// What a tuning may leave open, and the key that weighs most in the rule.
struct Rule {
    const char *key;
    double T::*value;
    const char *from;
    Open open = Open::at_zero;

    bool is_open(const TuningSettings &tuning) const
    {
        const double written = tuning.*value;
        return open == Open::at_zero ? written <= 0 : written <= LEFT_OPEN;
    }
};
constexpr Rule RULES[] = {
    {"observer.kappa", &T::observer_kappa, "motor.inertia_kg_m2"},
    {"observer.kappa_p", &T::observer_kappa_p, "motor.inertia_kg_m2", Open::below_zero},
    {"observer.rho_max", &T::observer_rho_max, "motor.inertia_kg_m2", Open::below_zero},
    {"observer.feedback", &T::observer_feedback, "motor.resistance_ohm", Open::below_zero},
    {"current_loop.bandwidth_hz", &T::current_bandwidth_hz, "board.pwm_frequency_hz"},
    {"current_loop.floor_pct", &T::current_floor_pct, "board.dead_time_s", Open::below_zero},
    {"speed_loop.bandwidth_hz", &T::speed_bandwidth_hz, "motor.inertia_kg_m2"},
    {"speed_loop.low_speed_bandwidth_hz", &T::low_speed_bandwidth_hz, "board.dead_time_s",
     Open::below_zero},
    {"speed_loop.ramp_rpm_s", &T::speed_ramp_rpm_s, "motor.inertia_kg_m2"},
    {"torque_loop.slope_nm_s", &T::torque_slope_nm_s, "motor.inertia_kg_m2"},
    {"position_loop.bandwidth_hz", &T::position_bandwidth_hz, "motor.inertia_kg_m2"},
    {"position_loop.speed_rpm", &T::position_speed_rpm, "motor.rated_speed_rpm"},
    {"position_loop.acceleration_rad_s2", &T::position_acceleration_rad_s2, "motor.inertia_kg_m2"},
    {"position_loop.softness_s", &T::position_softness_s, "motor.inertia_kg_m2"},
    {"voltage_loop.kp_v_s_per_rad", &T::voltage_kp_v_s_per_rad, "motor.flux_linkage_wb"},
    {"voltage_loop.ki_v_per_rad", &T::voltage_ki_v_per_rad, "motor.flux_linkage_wb"},
    {"voltage_loop.virtual_resistance_ohm", &T::virtual_resistance_ohm, "motor.inductance_d_h",
     Open::below_zero},
    {"voltage_loop.virtual_mean_s", &T::virtual_mean_s, "motor.rated_speed_rpm"},
    {"phase_compensator.brake_max_deg", &T::brake_max_deg, "motor.resistance_ohm"},
};

const Rule &rule_of(double T::*value)
{
    return *std::find_if(std::begin(RULES), std::end(RULES),
                         [&](const Rule &rule) { return rule.value == value; });
}

// Between −1 and 0 is neither a value nor a rule.
void check_written(const TuningSettings &tuning)
{
    for (const Rule &rule : RULES) {
        if (rule.open == Open::below_zero && !rule.is_open(tuning)) {
            require({rule.key, tuning.*rule.value}, 0, HUGE_VAL,
                    "from 0 on, or -1, which leaves it to its rule");
        }
    }
}

// What the rules are made of, in SI units.
struct Drive {
    const MotorSettings &motor;
    const BoardSettings &board;
    const ModelScales &model;
    double period_s;
    double rated;    // rad/s of the shaft
    double rated_el; // electrical rad/s
    double acceleration;

    Drive(const MotorSettings &motor_, const BoardSettings &board_, const ModelScales &model_)
        : motor(motor_), board(board_), model(model_), period_s(1 / board.pwm_frequency_hz),
          rated(rad_s_from_rpm(motor.rated_speed_rpm)), rated_el(rated * motor.pole_pairs),
          acceleration(1.5 * motor.pole_pairs * motor.flux_linkage_wb * motor.max_current_a /
                       motor.inertia_kg_m2)
    {
    }
};

// A tuning that is being filled in.
class Filled
{
public:
    Filled(const TuningSettings &as_written, const RuleRanges &ranges)
        : tuning(as_written), as_written_(as_written), ranges_(ranges)
    {
    }

    bool is_open(double T::*setting) const
    {
        return rule_of(setting).is_open(as_written_);
    }
    void fill(double T::*setting, double value)
    {
        if (is_open(setting)) {
            const auto range = ranges_.find(rule_of(setting).key);
            tuning.*setting = range == ranges_.end()
                                  ? value
                                  : std::clamp(value, range->second.least, range->second.most);
        }
    }

    TuningSettings tuning;

private:
    const TuningSettings &as_written_;
    const RuleRanges &ranges_;
};

// 1/s: the largest acceleration as a share of rated speed.
double torque_rate(const Drive &drive)
{
    return drive.acceleration / drive.rated;
}

// Voltage that dead time and drop take off, as the drive believes.
double believed_loss_v(const Drive &drive)
{
    return leg_loss_v(drive.board, drive.model.dead_time_s, drive.model.device_drop_v);
}

// What dead time leaves of the speed loop's bandwidth at the hand-over, rad/s.
double quiet_rate(const Drive &drive, double handover_pct)
{
    const double emf_v = handover_pct / 100 * drive.rated_el * drive.motor.flux_linkage_wb;
    const double loss_v = believed_loss_v(drive);
    return loss_v > 0 ? SPEED_PER_LOSS * drive.rated_el * emf_v / loss_v : HUGE_VAL;
}

// The speed loop's own bandwidth in rad/s, by torque, dead time and reactance. The lag of the
// estimate may limit it further.
double quiet_speed_rate(const Drive &drive, double handover_pct)
{
    const double reactance =
        drive.motor.inductance_d_h * rated_current(drive.motor) / drive.motor.flux_linkage_wb;
    const double by_reactance = OBSERVER_PER_REACTANCE * drive.rated_el / (reactance * reactance) *
                                LAG_PHASE / OBSERVER_SHAPE;
    const double rate = torque_rate(drive);
    return std::clamp(std::min(quiet_rate(drive, handover_pct), by_reactance),
                      SPEED_PER_TORQUE_LEAST * rate, SPEED_PER_TORQUE * rate);
}

double kappa_of(double kappa_p, const Drive &drive)
{
    if (kappa_p > 0) {
        return kappa_p * kappa_p / OBSERVER_SHAPE;
    }
    const double turn =
        rad_s_from_rpm(drive.motor.max_speed_rpm) * drive.motor.pole_pairs * drive.period_s;
    return std::max(KAPPA_LEAST, KAPPA_PUBLISHED * turn * turn);
}

// A loop that somebody made faster has an observer as fast.
void fill_observer(Filled &f, const Drive &drive)
{
    const double loop = std::max(quiet_speed_rate(drive, f.tuning.handover_speed_pct),
                                 TWO_PI * std::max(0.0, f.tuning.speed_bandwidth_hz));
    const double rate =
        std::max(OBSERVER_SHAPE * loop / LAG_PHASE, OBSERVER_RADIAN * drive.rated_el);
    const double kappa_p = f.is_open(&T::observer_kappa)
                               ? rate * drive.period_s
                               : std::sqrt(OBSERVER_SHAPE * f.tuning.observer_kappa);
    f.fill(&T::observer_kappa_p, std::min(kappa_p, KAPPA_P_MAX));
    f.fill(&T::observer_kappa, kappa_of(f.tuning.observer_kappa_p, drive));
    const double turns = f.tuning.observer_kappa_p / drive.period_s / drive.rated_el;
    f.fill(&T::observer_rho_max, std::clamp(RHO_PER_RATE * turns, RHO_LEAST, RHO_MOST));
    const double winding = drive.period_s * drive.motor.resistance_ohm / drive.motor.inductance_d_h;
    const double least = std::min(DECAY_LEAST, DECAY_PER_RADIAN * drive.rated_el * drive.period_s);
    f.fill(&T::observer_feedback, std::max(0.0, least - winding));
}

// The share of the continuous current that dead time asks for, as far as the voltage reaches.
double floor_pct(const Drive &drive)
{
    const MotorSettings &motor = drive.motor;
    const double loss_v = believed_loss_v(drive);
    const double drop_v = motor.resistance_ohm * rated_current(motor);
    const double asked = FLOOR_PCT + FLOOR_SLOPE_PCT * loss_v / drop_v;
    const double spare_v = FLOOR_VOLTAGE * largest_ratio(drive.board) * drive.board.bus_nominal_v -
                           drive.rated_el * motor.flux_linkage_wb;
    const double reactance_v = drive.rated_el * motor.inductance_d_h * continuous_current(motor);
    const double most = std::max(FLOOR_PCT, 100 * spare_v / reactance_v);
    return std::min({asked, most, FLOOR_MAX_PCT});
}

// With a torque filter the loop is as much slower as keeps its phase margin.
double with_filter(const TuningSettings &tuning, const Drive &drive, double bandwidth_hz)
{
    if (!has_torque_filter(tuning)) {
        return bandwidth_hz;
    }
    const double margin = speed_margin(tuning, drive.period_s, bandwidth_hz, TorqueFilter::none);
    return bandwidth_of_margin(tuning, drive.period_s, margin, bandwidth_hz);
}

void fill_motion(Filled &f, const Drive &drive)
{
    const double lag = estimate_lag_s(f.tuning, drive.period_s);
    double bandwidth = SPEED_PER_TORQUE * torque_rate(drive);
    double ramp = RAMP_TORQUE * drive.acceleration;
    // Gains that are written are taken to suit the loop that the torque allows.
    if (lag > 0 && f.is_open(&T::observer_kappa)) {
        bandwidth = std::min(quiet_speed_rate(drive, f.tuning.handover_speed_pct), LAG_PHASE / lag);
        ramp = std::min(ramp, LAG_RAMP * drive.rated / lag);
    }
    f.fill(&T::speed_bandwidth_hz, with_filter(f.tuning, drive, bandwidth / TWO_PI));
    f.fill(&T::low_speed_bandwidth_hz,
           std::min(f.tuning.speed_bandwidth_hz,
                    quiet_rate(drive, f.tuning.handover_speed_pct) / TWO_PI));
    f.fill(&T::speed_ramp_rpm_s, ramp / rad_s_from_rpm(1));
    f.fill(&T::torque_slope_nm_s,
           drive.acceleration * drive.motor.inertia_kg_m2 * TWO_PI * f.tuning.speed_bandwidth_hz);
    f.fill(&T::position_bandwidth_hz, POSITION_SHARE * f.tuning.speed_bandwidth_hz);
    f.fill(&T::position_speed_rpm,
           std::min(PROFILE_SPEED * drive.motor.rated_speed_rpm, drive.motor.max_speed_rpm));
    f.fill(&T::position_acceleration_rad_s2, PROFILE_TORQUE * drive.acceleration);
    f.fill(&T::position_softness_s, SOFTNESS / (TWO_PI * f.tuning.position_bandwidth_hz));
}

// Both axes take part in the mode: it is damped by the mean of R_v/L_d and R_v/L_q.
double virtual_resistance(const Drive &drive)
{
    const double l_d = drive.motor.inductance_d_h;
    const double l_q = drive.motor.inductance_q_h;
    const double inductance = 2 * l_d * l_q / (l_d + l_q);
    return std::min(VIRTUAL_DAMPING * drive.rated_el * inductance,
                    VIRTUAL_SHARE_MAX * std::min(l_d, l_q) / drive.period_s);
}

void fill_voltage_drive(Filled &f, const Drive &drive)
{
    f.fill(&T::virtual_resistance_ohm, virtual_resistance(drive));
    f.fill(&T::virtual_mean_s, 1 / (VIRTUAL_MEAN_RADIAN * drive.rated_el));
    f.fill(&T::voltage_kp_v_s_per_rad, VOLTAGE_PER_FLUX * drive.motor.flux_linkage_wb);
    f.fill(&T::voltage_ki_v_per_rad, VOLTAGE_CORNER_S * f.tuning.voltage_kp_v_s_per_rad);
    const double reactance = drive.rated_el * drive.motor.inductance_d_h;
    f.fill(&T::brake_max_deg,
           BRAKE_SHARE * std::atan(drive.motor.resistance_ohm / reactance) * 360 / TWO_PI);
}

} // namespace

const char *rule_source(const std::string &key, const TuningSettings &as_written)
{
    const auto rule = std::find_if(std::begin(RULES), std::end(RULES),
                                   [&](const Rule &any) { return any.key == key; });
    return rule != std::end(RULES) && rule->is_open(as_written) ? rule->from : nullptr;
}

TuningSettings by_rules(const TuningSettings &as_written, const MotorSettings &motor,
                        const BoardSettings &board, const ModelScales &model,
                        const RuleRanges &ranges)
{
    check_written(as_written);
    const Drive drive(motor, board, model);
    Filled f(as_written, ranges);
    fill_observer(f, drive);
    f.fill(&T::current_bandwidth_hz, board.pwm_frequency_hz / CURRENT_SAMPLES);
    f.fill(&T::current_floor_pct, floor_pct(drive));
    fill_motion(f, drive);
    fill_voltage_drive(f, drive);
    return f.tuning;
}

} // namespace nf
