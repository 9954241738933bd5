/* SPDX-License-Identifier: MIT */
// The figures of merit of a run, computed while it runs.
//
// Errors are actual − estimated, taken at the sampling instants: the truth at t_k against what the
// drive believed about t_k. The evaluation covers every tick from `evaluate_from_s` to the end,
// transients included.
//
// Commanded quantity: the mechanical speed [rpm], in position mode the mechanical angle [rad], in
// torque mode the torque of the
//                 air gap [N·m].
// Step: the command or the load takes a new value. Steps before the evaluation do not count.
// Step window:    from a step to the next one (of either kind) or to the end of the run.
// Settled window: any stretch of the evaluation that begins 0.15 s after the last step, and after
// the
//                 drive's own reference (speed ramp, position profile) has last moved.
#pragma once

#include "config.h"
#include "ripple.h"
#include "swing.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nf
{

constexpr double SETTLED_AFTER_S = 0.15;
constexpr double SETTLING_BAND = 0.02;  // of the height of a command step
constexpr double REACHED_BAND = 0.05;   // of the height of a command step
constexpr double RECOVERY_BAND = 0.005; // of rated speed: above the ripple that sensor noise makes
constexpr double LOST_DEG = 90.0;       // electrical; beyond it torque has the wrong sign
constexpr double LOST_SPEED = 0.05;     // of rated speed; the estimate no longer is the speed
constexpr double LOST_COMMAND = 0.25;   // of the command, likewise
constexpr double LOST_RMS_DEG = 30.0;   // half of the torque's current is along the flux
constexpr double LOST_MEAN_S = 0.1;     // what these three are averaged over
constexpr double SWING_SPEED = 0.02;    // of rated speed
constexpr double SWING_CURRENT = 0.3;   // of the current of rated torque

// Empty where a figure does not apply, or where what it waits for never came (a step that does not
// settle, no settled window): a limit on an empty figure does not hold.
struct MetricValues {
    // ω − ω̂, mechanical: largest magnitude, root mean square; the first also as % of rated speed.
    std::optional<double> speed_error_max_rpm;
    std::optional<double> speed_error_rms_rpm;
    std::optional<double> speed_error_max_pct;
    // Speed mode: largest |command − ω| in settled windows, % of the command; of rated speed when
    // the command is 0.
    std::optional<double> command_error_settled_pct;
    // θ − θ̂, electrical, wrapped to ±180°: largest magnitude.
    std::optional<double> angle_error_max_deg;
    // Likewise: root mean square.
    std::optional<double> angle_error_rms_deg;
    // True i_q − î_q of the network: largest magnitude.
    std::optional<double> iq_error_max_a;
    // Command steps: time from the step until the commanded quantity stays within 2 % of the step's
    // height of the command to the end of the step window. The longest.
    std::optional<double> settling_time_s;
    // Command steps: how far the commanded quantity passes the command, % of the step's height. The
    // largest, 0 when it never does.
    std::optional<double> overshoot_pct;
    // Speed mode, load steps: largest |command − ω| in the step window, and the time from the step
    // until it stays within 0.5 % of rated speed. The largest and the longest.
    std::optional<double> speed_dip_rpm;
    std::optional<double> recovery_time_s;
    // Position mode: |command − angle|, mechanical, in the last tick before the next command step
    // or the end. The largest.
    std::optional<double> position_error_final_rad;
    // Magnitude of the mean of the true i_d over a settled window. The largest.
    std::optional<double> id_settled_a;
    // Likewise for the speed error, % of rated speed, in the windows of command steps and of load
    // steps; one of both in a tick is of the load, whose torque no drive knows.
    std::optional<double> speed_error_command_pct;
    std::optional<double> speed_error_load_pct;
    // What the rotor's own turning forces (ripple.h) while nothing from outside changes, neither
    // command nor load nor by a fault, amplitudes: of the speed, % of rated speed, and of the
    // torque's current, % of that of rated torque. The largest.
    std::optional<double> ripple_speed_pct;
    std::optional<double> ripple_current_pct;
    // Without that and the supply's ripple, the largest sustained swings (swing.h), likewise. The
    // frequency: the current's, if it swings. A window is watched from its beginning: what goes on
    // after it has settled began before.
    std::optional<double> swing_speed_pct;
    std::optional<double> swing_current_pct;
    std::optional<double> swing_hz;
    // Torque mode: magnitude of the mean of the air gap's torque less the command over a settled
    // window, % of the command; of rated torque when the command is 0. The largest. While the speed
    // loop decides the torque there is no such window, and one shorter than 0.15 s does not count.
    std::optional<double> torque_error_settled_pct;
    // When `locked` was lost.
    std::optional<double> lost_time_s;
    // Held against rated speed: in every tick the drive runs, without a fault, the angle error is
    // below 90° electrical, and the mean square of the speed error, through a low-pass of 0.1 s, is
    // below the square of 5 % of rated speed. A transient may be larger for a while (10 % for 29
    // ms).
    bool locked_coarse = false;
    // That, and what a drive can be built on at any speed. In settled windows with a command the
    // mean square of the speed error is below the square of a quarter of the command: the estimate
    // is the speed, not its swing. In closed loop that of the angle error is below the square of
    // 30°: at that angle half of the current makes no torque. Below, where the current is imposed,
    // the angle is the load's.
    bool locked = false;
    // One of the swings was found. It may be locked all the same.
    bool limit_cycle = false;
    // Speed and position mode: before the next command step, or the end, the commanded quantity
    // came within 5 % of the step's height of each command; of the command, if that was in force
    // before the evaluation.
    bool reached = false;
    // The first command that was not reached, and how near it came.
    struct Missed {
        double command;
        double nearest; // value of the commanded quantity
    };
    std::optional<Missed> missed;
};

// The numeric figures by their names in files, in the order of MetricValues.
struct MetricField {
    const char *name;
    std::optional<double> MetricValues::*value;
};
const std::vector<MetricField> &metric_fields();

// Those that are true or false, likewise.
struct FlagField {
    const char *name;
    bool MetricValues::*value;
};
const std::vector<FlagField> &flag_fields();

// One control tick.
struct Instant {
    double time_s; // of the scenario
    double speed_rpm;
    double speed_estimated_rpm;
    double angle_error_deg; // electrical, wrapped
    double angle_el_rad;    // of the rotor
    double supply_rad;      // of the supply's ripple; 0: it has none
    double iq_error_a;
    double i_q_a;
    double i_d_a;
    double actual;         // of the commanded quantity
    bool running;          // from FLYING_START to RUN
    bool closed_loop;      // in RUN: the currents are controlled at the estimated angle
    bool reference_moving; // the drive's own reference is not the one of the tick before
};

class Metrics
{
public:
    // Current and torque are rated ones; without a torque an error at no torque is not judged.
    Metrics(DriveMode mode, double period_s, double rated_speed_rpm, double rated_current_a,
            double rated_torque_nm = 0);

    // The command in force when the evaluation begins.
    void start(double command)
    {
        command_ = command;
        approach_ = {std::abs(command), {}};
    }
    // A step, before the tick at which it acts; of both in one tick, the command's first. A load
    // step in the tick of a command step has no dip of its own.
    void command_step(double command);
    void load_step();
    // Something else from outside begins or ends, before the tick at which it acts: a fault of the
    // scenario, as a supply that drops. It ends no window but that of ripple and swings.
    void disturbed();

    void add(const Instant &now);
    // The evaluation ends after the last add(). Call once.
    MetricValues finish();

private:
    // Time until the commanded quantity stays within a band of a value.
    struct Wait {
        bool active = false;
        double band = 0;
        int64_t since = 0;   // tick of the step
        int64_t outside = 0; // one past the last tick outside the band
    };
    // The worst over several windows; a window without a result spoils it.
    struct Worst {
        double value = 0;
        bool seen = false;
        bool spoiled = false;
        void add(double x);
        std::optional<double> get() const;
    };

    // A mean square through a low-pass, from 0 on.
    struct MeanSquare {
        double value = 0;
        void add(double x, double gain)
        {
            value += (x * x - value) * gain;
        }
    };

    void close_step_window();
    void close_approach();
    void close_wait(Wait &wait, Worst &into) const;
    void close_settled_window();
    void close_torque_window();
    void close_swings();
    void watch_window(const Instant &now);
    void watch_steps(double beyond);
    void average(const Instant &now);
    bool is_held_coarsely(const Instant &now) const;
    bool is_held() const;
    void add_settled(const Instant &now);
    static std::optional<double> of_rated(const Worst &worst, double rated);
    void finish_errors(MetricValues &m) const;
    void finish_swings(MetricValues &m) const;

    DriveMode mode_;
    double period_s_;
    double rated_rpm_;
    double rated_a_;
    double rated_nm_;
    int64_t settled_ticks_;
    double mean_gain_; // a tick's share in the mean squares

    int64_t ticks_ = 0;
    double command_ = 0;
    double last_actual_ = 0;
    bool locked_coarse_ = true;
    std::optional<double> lost_time_s_;
    double speed_error_max_ = 0;
    double speed_error_squares_ = 0;
    double angle_error_max_ = 0;
    double angle_error_squares_ = 0;
    double iq_error_max_ = 0;
    MeanSquare speed_mean_;
    MeanSquare settled_mean_; // of the speed error in this settled window
    MeanSquare angle_mean_;   // of the angle error in this stretch of closed loop

    enum class After {
        nothing,
        command,
        load
    };
    After after_ = After::nothing; // which step the window is of
    Worst error_command_;
    Worst error_load_;
    Ripple ripple_; // of speed and torque current, since the conditions changed
    Worst ripple_speed_;
    Worst ripple_current_;
    SwingFinder speed_swing_;
    SwingFinder current_swing_;

    int64_t quiet_ticks_ = 0; // since the last step or movement of the reference
    int64_t window_ticks_ = 0;
    double window_id_sum_ = 0;
    double window_actual_sum_ = 0;
    double command_scale_ = 0; // 100 / what the settled command error is a share of
    Worst id_settled_;
    Worst command_error_settled_;
    Worst torque_error_settled_;

    Wait settling_;
    Wait recovery_;
    // To a command: the height of its step, and the nearest value so far.
    struct Approach {
        double height = 0;
        std::optional<double> nearest;
    };
    Approach approach_;
    std::optional<MetricValues::Missed> missed_;
    double step_sign_ = 0; // +1 up, −1 down
    double step_height_ = 0;
    double excess_ = 0; // beyond the command, in the direction of the step
    double dip_ = 0;
    Worst settling_time_;
    Worst overshoot_;
    Worst dips_;
    Worst recovery_time_;
    Worst position_error_;
};

} // namespace nf
