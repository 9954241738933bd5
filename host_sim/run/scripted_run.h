/* SPDX-License-Identifier: MIT */
// A simulation and the script of its scenario: steps of command and load, requests and faults, each
// from the tick nearest to its time. Or the frames of a recording: then there is no motor, what is
// true is not known (NaN), and command and requests are the frames'.
//
// Ticks are those of the drive: of a scenario the first is 0 and begins the prelude, a recording
// begins at any, and its time is since the drive's tick 0. A tick is control(), then advance().
// What a run has become lies in its snapshot alone: the same snapshot goes on in the same way.
#pragma once

#include "injection.h"
#include "operator.h"
#include "profile.h"
#include "tick.h"

#include <optional>
#include <vector>

namespace nf
{

class ScriptedRun
{
public:
    // Throws ConfigError. The configuration must outlive the run.
    explicit ScriptedRun(const Config &config);
    // The motor and the board of one configuration, and a drive that believes another one (sim.h).
    // The script is of the first.
    ScriptedRun(const Config &real, const Config &believed);
    // At least one frame, and as many outputs.
    explicit ScriptedRun(const RecordedRun &recorded);

    struct Snapshot {
        int64_t tick;
        Simulation::State sim;
        Profile command;
        Profile load;
        Injection injection;
        Operator user;
        hal_host_faults_t forced;
        bool is_commanded;
        DriveMode mode;
    };
    // Between advance() and control(), of this run and no other.
    Snapshot save() const
    {
        return {tick_,     sim_.save(), command_,      load_, injection_,
                operator_, forced_,     is_commanded_, mode_};
    }
    void restore(const Snapshot &snapshot);

    // The drive begins anew with this configuration (sim.h). Before the first tick.
    void start(const drive_cfg_t &cfg);

    // The script acts, then the control interrupt. `commanded`: in place of what the script
    // commands and requests.
    Tick control(const std::optional<drive_command_t> &commanded = {});
    // One PWM period goes by. A configuration that the next tick has is in force then.
    void advance()
    {
        sim_.advance();
        tick_++;
        change_configuration();
    }

    bool is_recorded() const
    {
        return !frames_.empty();
    }

    // The configuration that the drive was given last, as it was made.
    const drive_cfg_t &built() const;
    // The last tick with it; the largest number when there is no change behind the present tick.
    int64_t built_until() const;

    // In place of the script's value, until its next step. Not of a recording.
    void set_command(double value);
    void set_load_nm(double torque_nm);
    // The same with another meaning of the command: rpm, or mechanical rad in position mode.
    void set_command(DriveMode mode, double value);

    // What a person asks for and breaks, from the next control() on, beside what the script does.
    // Not of a recording.
    void ask(const RequestEntry &request)
    {
        operator_.take(request);
    }
    void begin_fault(const FaultEntry &fault)
    {
        injection_.begin(fault, tick_ + 1);
    }
    void end_fault(FaultKind kind)
    {
        injection_.end(kind, tick_ + 1);
    }

    // From now on the script neither commands nor requests anything; its load and its faults go on.
    // Not of a recording.
    void leave_to_user()
    {
        is_commanded_ = false;
    }
    bool is_commanded() const
    {
        return is_commanded_;
    }

    // What the converter or the angle sensor reads from the next control() on, whatever the script
    // says, and the end of it: the channel is the script's again.
    using Channel = hal_host_channel_t hal_host_faults_t::*;
    void force_channel(Channel channel, uint16_t count);
    void release_channel(Channel channel);

    // The last control() brought a new value.
    bool new_command() const
    {
        return new_command_;
    }
    bool new_load() const
    {
        return new_load_;
    }
    // Or a fault began or ended.
    bool new_fault() const
    {
        return new_fault_;
    }

    Simulation &sim()
    {
        return sim_;
    }
    const Simulation &sim() const
    {
        return sim_;
    }
    int64_t tick() const
    {
        return tick_;
    }
    // The first tick, that of t = 0, and the one after the last.
    int64_t first() const
    {
        return first_;
    }
    int64_t zero() const
    {
        return zero_;
    }
    int64_t end() const
    {
        return end_;
    }
    // Nearest to a time since t = 0.
    int64_t tick_at(double time_s) const
    {
        return zero_ + ticks_in(time_s);
    }

private:
    int64_t ticks_in(double seconds) const;
    void send_command();
    void change_configuration();
    void act();
    void impose_forced();
    Tick view() const;
    std::size_t frame() const
    {
        return static_cast<std::size_t>(tick_ - first_);
    }
    std::vector<ConfigChange>::const_iterator next_change() const;

    DriveMode mode_;
    std::vector<drive_in_t> frames_; // of a recording
    std::vector<drive_out_t> outputs_;
    std::vector<ConfigChange> changes_;
    Simulation sim_;
    drive_cfg_t first_built_;
    int64_t first_;
    int64_t zero_;
    int64_t end_;
    Profile command_;
    Profile load_;
    Injection injection_;
    Operator operator_;
    hal_host_faults_t forced_{}; // its channels
    bool is_commanded_ = true;   // by the script
    int64_t tick_;
    bool new_command_ = false;
    bool new_load_ = false;
    bool new_fault_ = false;
};

} // namespace nf
