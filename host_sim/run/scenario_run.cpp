// SPDX-License-Identifier: MIT
#include "scenario_run.h"

#include "measured.h"
#include "motor_model.h"
#include "numbers.h"
#include "si.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double RPM_PER_RAD_S = 30.0 / PI;

std::vector<Parameter> parameters_of(const Config &config, const drive_t &drive)
{
    constexpr double ratio_q14 = 1.0 / MODEL_RATIO_ONE;
    const MotorSettings &motor = config.motor;
    const auto parameter = [](const char *name, double nameplate, double belief, double ratio,
                              double real) {
        return Parameter{name, nameplate * belief, nameplate * belief * ratio, nameplate * real};
    };
    return {
        parameter("resistance_ohm", motor.resistance_ohm, config.model.resistance,
                  drive.motor.model.resistance_q14 * ratio_q14, config.plant.resistance_scale),
        parameter("inductance_d_h", motor.inductance_d_h, config.model.inductance,
                  drive.motor.model.inductance_q14 * ratio_q14, config.plant.inductance_scale),
        parameter("inductance_q_h", motor.inductance_q_h, config.model.inductance,
                  drive.motor.model.inductance_q14 * drive.motor.model.saliency_q14 * ratio_q14 *
                      ratio_q14,
                  config.plant.inductance_scale * config.plant.saliency_scale),
        parameter("flux_linkage_wb", motor.flux_linkage_wb, config.model.flux,
                  std::ldexp(drive.motor.model.flux_q30, -30), config.plant.flux_scale),
        parameter("inertia_kg_m2", motor.inertia_kg_m2, config.model.inertia,
                  std::ldexp(drive.motion.speed_loop.inertia_q17, -17), config.plant.inertia_scale),
    };
}

// In torque mode the torque counts where nothing but the command decides it.
bool decides_torque(const drive_t &drive)
{
    return drive.state == DRIVE_STATE_RUN && drive.motion.mode == DRIVE_MODE_TORQUE &&
           !drive.motion.torque_loop.bound && drive.motion.torque_loop.end == SPEED_END_NONE;
}

double commanded(const Tick &tick, double speed_rpm)
{
    switch (tick.mode) {
    case DriveMode::position:
        return tick.truth.theta_mech_rad;
    case DriveMode::torque:
        return tick.truth.torque_nm;
    default:
        return speed_rpm;
    }
}

} // namespace

ScenarioRun::ScenarioRun(const Config &real, const Config &believed, const RunOptions &options)
    : config_(believed), options_(options), run_(real, believed),
      evaluate_from_(run_.tick_at(real.scenario.evaluate_from_s)),
      metrics_(real.scenario.mode, run_.sim().bases().control_period_s,
               believed.motor.rated_speed_rpm, rated_current(believed.motor),
               believed.motor.rated_torque_nm),
      rpm_per_step_(run_.sim().bases().rpm_from_step(1)),
      ampere_per_bit_(run_.sim().bases().current_a / Q15),
      supply_rad_s_(real.plant.bus_ripple_pct > 0 ? 2 * PI * real.plant.bus_ripple_hz : 0)
{
}

// What the script changed in this tick.
void ScenarioRun::judge_steps(const Tick &tick)
{
    const bool evaluated = run_.tick() >= evaluate_from_;
    if (run_.new_command() && evaluated) {
        metrics_.command_step(tick.command);
    } else if (run_.new_command()) {
        metrics_.start(tick.command);
    }
    if (run_.new_load() && evaluated) {
        metrics_.load_step();
    }
    if (run_.new_load()) {
        note_load(tick);
    }
    if (run_.new_fault() && evaluated) {
        metrics_.disturbed();
    }
}

// The speed ramp, the position profile, or the slope of the torque.
bool ScenarioRun::reference_moving()
{
    const drive_t &drive = run_.sim().drive();
    const DriveMode mode = config_.scenario.mode;
    int64_t reference = drive.motion.speed_reference;
    if (mode == DriveMode::position) {
        reference = drive.motion.position_loop.profile_q32;
    } else if (mode == DriveMode::torque) {
        reference = drive.motion.torque_loop.reference_q28;
    }
    const bool held_off = mode == DriveMode::torque && !decides_torque(drive);
    const bool moving = held_off || reference != reference_;
    reference_ = reference;
    return moving;
}

void ScenarioRun::evaluate(const Tick &tick)
{
    const drive_t &drive = run_.sim().drive();
    const plant_view_t &truth = tick.truth;
    Instant now{};
    now.time_s = tick.time_s;
    now.speed_rpm = truth.omega_mech_rad_s * RPM_PER_RAD_S;
    now.speed_estimated_rpm = tick.speed_estimate * rpm_per_step_;
    now.angle_error_deg = angle_error_deg(tick);
    now.angle_el_rad = truth.theta_el_rad;
    now.supply_rad = std::remainder(supply_rad_s_ * tick.time_s, 2 * PI);
    now.iq_error_a = truth.i_q_a - drive.rotor.observer.current.q * ampere_per_bit_;
    now.i_q_a = truth.i_q_a;
    now.i_d_a = truth.i_d_a;
    now.actual = commanded(tick, now.speed_rpm);
    now.running = drive.state > DRIVE_STATE_READY && drive.state < DRIVE_STATE_FAULT;
    now.closed_loop = drive.state == DRIVE_STATE_RUN;
    now.reference_moving = reference_moving();
    metrics_.add(now);
    if (now.closed_loop && !runs_from_s_) {
        runs_from_s_ = now.time_s;
    }
    if (now.running) {
        result_.saturations.add(drive, measured_sample(run_.sim()), run_.sim().out());
    }
}

void ScenarioRun::watch_state()
{
    const drive_state_t state = run_.sim().drive().state;
    if (state == state_) {
        return;
    }
    if (state == DRIVE_STATE_FAULT) {
        result_.faults.push_back(found_fault(run_.sim().drive(), run_.sim().bases()));
    }
    state_ = state;
}

void ScenarioRun::one()
{
    const Tick tick = run_.control(options_.commander ? options_.commander() : std::nullopt);
    judge_steps(tick);
    watch_state();
    if (run_.tick() >= evaluate_from_) {
        evaluate(tick);
    }
    if (options_.sink != nullptr) {
        options_.sink->add(tick);
    }
    if (options_.power_stage) {
        run_.sim().apply(options_.power_stage(tick));
    }
    if (options_.estimate) {
        drive_t &drive = run_.sim().seam().drive;
        options_.estimate(drive, measured_sample(run_.sim()));
    }
    run_.advance();
}

void ScenarioRun::note_swing()
{
    const drive_t &drive = run_.sim().drive();
    if (const std::optional<double> hz = last_swing_hz(drive, run_.sim().bases())) {
        result_.notes.push_back(fmt::format("the torque current swung at {:.1f} Hz{}", *hz,
                                            drive.motion.speed_loop.halvings > 0
                                                ? ", the speed loop was given half its bandwidth"
                                                : ""));
    }
}

// A fault says itself why.
void ScenarioRun::note_missed()
{
    const auto &missed = result_.metrics.missed;
    if (missed && result_.faults.empty()) {
        const bool turns = config_.scenario.mode == DriveMode::speed;
        result_.notes.push_back(fmt::format(
            "the {} never reached its command of {:.5g} {}, it came to {:.5g}",
            turns ? "speed" : "shaft", missed->command, turns ? "rpm" : "rad", missed->nearest));
    }
}

// A step of the load that comes while the start still runs is one of the start: no dip, no recovery
// of RUN.
void ScenarioRun::note_load(const Tick &tick)
{
    const drive_state_t state = run_.sim().drive().state;
    const bool starts = drive_is_driving(state) && state != DRIVE_STATE_RUN;
    if (starts && tick.command != 0 && !run_.new_command()) {
        result_.notes.push_back(fmt::format(
            "the load of {:.4g} N·m at {:.4g} s comes while the start still runs: dip and recovery are "
            "those of the start",
            tick.load_nm, tick.time_s));
    }
}

// A start that takes several attempts outlasts the time that is planned for it.
void ScenarioRun::note_late_start()
{
    const std::optional<double> &lost_s = result_.metrics.lost_time_s;
    if (lost_s && runs_from_s_ && *lost_s < *runs_from_s_) {
        result_.notes.push_back(fmt::format(
            "the start lasted until {:.4g} s and is judged from {:.4g} s on: a longer scenario.prelude_s begins it earlier",
            *runs_from_s_, config_.scenario.evaluate_from_s));
    }
}

void ScenarioRun::advance(int64_t ticks)
{
    const int64_t until = std::min(run_.end(), run_.tick() + ticks);
    while (run_.tick() < until) {
        one();
    }
}

RunResult ScenarioRun::finish()
{
    result_.parameters = parameters_of(config_, run_.sim().drive());
    result_.metrics = metrics_.finish();
    result_.ticks = run_.end();
    result_.zero = run_.zero();
    result_.period_s = run_.sim().bases().control_period_s;
    result_.state_final = run_.sim().drive().state;
    result_.gates_enabled_final = run_.sim().plant().gates_on;
    note_swing();
    note_missed();
    note_late_start();
    return result_;
}

} // namespace nf
