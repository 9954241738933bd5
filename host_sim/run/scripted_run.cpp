// SPDX-License-Identifier: MIT
#include "scripted_run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

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

ScriptedRun::ScriptedRun(const Config &config) : ScriptedRun(config, config)
{
}

ScriptedRun::ScriptedRun(const Config &real, const Config &believed)
    : mode_(real.scenario.mode), sim_(real, believed), first_built_(sim_.cfg()), first_(0),
      zero_(ticks_in(real.scenario.prelude_s)), end_(zero_ + ticks_in(real.scenario.duration_s)),
      command_(real.scenario.command, sim_.bases().control_period_s, zero_),
      load_(scaled(real.scenario.load, real.scenario.load_scale), sim_.bases().control_period_s,
            zero_),
      injection_(real, sim_.bases().control_period_s, zero_),
      operator_(real.scenario.requests, sim_.bases().control_period_s, zero_), tick_(first_)
{
    send_command();
}

ScriptedRun::ScriptedRun(const RecordedRun &recorded)
    : mode_(DriveMode::speed), frames_(recorded.frames), outputs_(recorded.outputs),
      changes_(recorded.changes), sim_(recorded.image), first_built_(sim_.cfg()),
      first_(recorded.first()), zero_(0), end_(first_ + static_cast<int64_t>(frames_.size())),
      command_({}, sim_.bases().control_period_s, zero_),
      load_({}, sim_.bases().control_period_s, zero_),
      injection_({}, sim_.bases().control_period_s, zero_),
      operator_({}, sim_.bases().control_period_s, zero_), tick_(first_)
{
    change_configuration();
}

int64_t ScriptedRun::ticks_in(double seconds) const
{
    return std::llround(seconds / sim_.bases().control_period_s);
}

void ScriptedRun::send_command()
{
    if (mode_ == DriveMode::position) {
        sim_.command_position_rad(command_.value());
    } else if (mode_ == DriveMode::torque) {
        sim_.command_torque_nm(command_.value());
    } else {
        sim_.command_speed_rpm(command_.value());
    }
}

void ScriptedRun::start(const drive_cfg_t &cfg)
{
    sim_.start(cfg);
    send_command();
}

void ScriptedRun::change_configuration()
{
    for (const ConfigChange &change : changes_) {
        if (change.frame == frame()) {
            sim_.change(change.cfg);
        }
    }
}

std::vector<ConfigChange>::const_iterator ScriptedRun::next_change() const
{
    return std::upper_bound(
        changes_.begin(), changes_.end(), frame(),
        [](std::size_t frame, const ConfigChange &change) { return frame < change.frame; });
}

const drive_cfg_t &ScriptedRun::built() const
{
    const auto next = next_change();
    return next == changes_.begin() ? first_built_ : std::prev(next)->cfg;
}

int64_t ScriptedRun::built_until() const
{
    const auto next = next_change();
    return next == changes_.end() ? std::numeric_limits<int64_t>::max()
                                  : first_ + static_cast<int64_t>(next->frame) - 1;
}

void ScriptedRun::set_command(double value)
{
    command_.set(value);
    send_command();
}

void ScriptedRun::set_command(DriveMode mode, double value)
{
    mode_ = mode;
    set_command(value);
}

void ScriptedRun::set_load_nm(double torque_nm)
{
    load_.set(torque_nm);
    sim_.set_load_nm(torque_nm);
}

void ScriptedRun::impose_forced()
{
    hal_host_faults_t &hal = sim_.seam().hal;
    for (const Channel channel :
         {&hal_host_faults_t::ia, &hal_host_faults_t::ib, &hal_host_faults_t::bus,
          &hal_host_faults_t::temperature, &hal_host_faults_t::angle}) {
        hal.*channel = (forced_.*channel).forced ? forced_.*channel : injection_.binding().*channel;
    }
}

void ScriptedRun::force_channel(Channel channel, uint16_t count)
{
    forced_.*channel = {true, count};
    impose_forced();
}

void ScriptedRun::release_channel(Channel channel)
{
    forced_.*channel = {};
    impose_forced();
}

void ScriptedRun::restore(const Snapshot &snapshot)
{
    tick_ = snapshot.tick;
    sim_.restore(snapshot.sim);
    command_ = snapshot.command;
    load_ = snapshot.load;
    injection_ = snapshot.injection;
    operator_ = snapshot.user;
    forced_ = snapshot.forced;
    is_commanded_ = snapshot.is_commanded;
    mode_ = snapshot.mode;
}

void ScriptedRun::act()
{
    new_command_ = is_commanded_ && command_.advance(tick_);
    if (new_command_) {
        send_command();
    }
    new_load_ = load_.advance(tick_);
    if (new_load_) {
        sim_.set_load_nm(load_.value());
    }
    new_fault_ = injection_.act(tick_, sim_);
    if (new_fault_) {
        impose_forced();
    }
    if (is_commanded_) {
        operator_.act(tick_, sim_);
    }
}

Tick ScriptedRun::view() const
{
    const double time_s = static_cast<double>(tick_ - zero_) * sim_.bases().control_period_s;
    if (is_recorded()) {
        Tick tick = tick_of_frame(sim_, frames_[frame()], time_s);
        tick.recorded = &outputs_[frame()];
        return tick;
    }
    Tick tick =
        is_commanded_ ? believed_tick(sim_, time_s) : tick_of_frame(sim_, sim_.in(), time_s);
    plant_view(&sim_.plant(), &tick.truth);
    if (is_commanded_) {
        tick.mode = mode_;
        tick.command = command_.value();
        tick.request = operator_.request();
    }
    tick.load_nm = load_.value();
    return tick;
}

Tick ScriptedRun::control(const std::optional<drive_command_t> &commanded)
{
    if (is_recorded()) {
        sim_.feed(frames_[frame()]);
    } else {
        act();
    }
    if (commanded) {
        command_mailbox_post(&sim_.app().mailbox, &*commanded);
    }
    const Tick tick = view();
    sim_.control();
    return tick;
}

} // namespace nf
