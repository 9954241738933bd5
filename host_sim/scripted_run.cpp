#include "scripted_run.h"

#include <cmath>

namespace nf
{
namespace
{

std::vector<TimedValue> scaled(std::vector<TimedValue> steps, double factor)
{
    for (TimedValue &step : steps) {
        step.value *= factor;
    }
    return steps;
}

} // namespace

ScriptedRun::ScriptedRun(const Config &config)
    : scenario_(config.scenario), sim_(config), zero_(ticks_in(scenario_.prelude_s)),
      end_(zero_ + ticks_in(scenario_.duration_s)),
      command_(scenario_.command, sim_.bases().control_period_s, zero_),
      load_(scaled(scenario_.load, scenario_.load_scale), sim_.bases().control_period_s, zero_),
      injection_(config, sim_.bases().control_period_s, zero_),
      operator_(scenario_.requests, sim_.bases().control_period_s, zero_)
{
    send_command();
}

int64_t ScriptedRun::ticks_in(double seconds) const
{
    return std::llround(seconds / sim_.bases().control_period_s);
}

void ScriptedRun::send_command()
{
    if (scenario_.mode == DriveMode::position) {
        sim_.command_position_rad(command_.value());
    } else {
        sim_.command_speed_rpm(command_.value());
    }
}

void ScriptedRun::set_command(double value)
{
    command_.set(value);
    send_command();
}

void ScriptedRun::set_load_nm(double torque_nm)
{
    load_.set(torque_nm);
    sim_.set_load_nm(torque_nm);
}

void ScriptedRun::restore(const Snapshot &snapshot)
{
    tick_ = snapshot.tick;
    sim_.restore(snapshot.sim);
    command_ = snapshot.command;
    load_ = snapshot.load;
    injection_ = snapshot.injection;
    operator_ = snapshot.user;
}

Tick ScriptedRun::control()
{
    new_command_ = command_.advance(tick_);
    if (new_command_) {
        send_command();
    }
    new_load_ = load_.advance(tick_);
    if (new_load_) {
        sim_.set_load_nm(load_.value());
    }
    injection_.act(tick_, sim_);
    operator_.act(tick_, sim_);
    Tick tick{};
    tick.sim = &sim_;
    tick.speed_estimate = drive_speed(&sim_.drive());
    tick.position_estimate_q32 = drive_position_q32(&sim_.drive());
    tick.observer_speed = sim_.drive().observer.speed;
    plant_view(&sim_.plant(), &tick.truth);
    tick.time_s = static_cast<double>(tick_ - zero_) * sim_.bases().control_period_s;
    tick.mode = scenario_.mode;
    tick.command = command_.value();
    tick.load_nm = load_.value();
    sim_.control();
    return tick;
}

} // namespace nf
