// SPDX-License-Identifier: MIT
#include "set.h"

#include "limit.h"
#include "readable.h"
#include "state_check.h"
#include "trimmed.h"
#include "vocabulary.h"

extern "C" {
#include "config_check.h"
#include "config_guard.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

constexpr int SHOWN_DIGITS = 10; // of a limit: no word of 32 bits has more

struct Change {
    Timeline::Act act;
    Timeline::Act end; // of the tick after the last; empty: it stays
};

// Commands of the user are the script's, not the drive's.
struct Command {
    const char *name;
    void (ScriptedRun::*set)(double);
    double largest; // either sign
};

constexpr std::array<Command, 4> COMMANDS = {{
    {"speed_command_rpm", &ScriptedRun::set_command, SPEED_COMMAND_MAX_RPM},
    {"position_command_rad", &ScriptedRun::set_command, POSITION_COMMAND_MAX_RAD},
    {"torque_command_nm", &ScriptedRun::set_command, LOAD_MAX_NM},
    {"load_torque_nm", &ScriptedRun::set_load_nm, LOAD_MAX_NM},
}};

struct Channel {
    const char *name;
    ScriptedRun::Channel channel;
};

constexpr std::array<Channel, 5> CHANNELS = {{
    {"in.adc_ia", &hal_host_faults_t::ia},
    {"in.adc_ib", &hal_host_faults_t::ib},
    {"in.adc_bus", &hal_host_faults_t::bus},
    {"in.adc_temperature", &hal_host_faults_t::temperature},
    {"in.angle", &hal_host_faults_t::angle},
}};

Change force_channel(ScriptedRun::Channel channel, int64_t raw)
{
    const auto count = static_cast<uint16_t>(raw);
    return {[=](ScriptedRun &run) { run.force_channel(channel, count); },
            [=](ScriptedRun &run) { run.release_channel(channel); }};
}

// The drive keeps watch over its configuration: what a person sets is sealed as if it had been
// built so.
void write_configuration(const SignalInfo &signal, int64_t raw, const Seam &seam)
{
    write_word(signal.word, raw, seam);
    if (signal.word.offset != offsetof(drive_cfg_t, crc)) {
        seam.cfg.crc = config_guard_crc(&seam.cfg);
        config_guard_reset(&seam.drive.guard);
    }
}

// What the firmware takes for granted: a configuration that it accepts, and of it a state that it
// can come to.
void check_change(const SignalInfo &signal, int64_t raw, const ScriptedRun &run)
{
    drive_cfg_t cfg = run.sim().cfg();
    drive_t drive = run.sim().drive();
    plant_t plant{};
    hal_host_faults_t hal{};
    write_word(signal.word, raw, {plant, hal, cfg, drive});
    const char *const refused = config_check(&cfg);
    const std::string bad = refused == nullptr ? state_problem(drive, cfg) : refused;
    if (!bad.empty()) {
        throw std::runtime_error(
            fmt::format("{}.raw = {} is refused by the drive: {}", signal.name, raw, bad));
    }
}

[[noreturn]] void refuse_result(const SignalInfo &signal)
{
    throw std::runtime_error(
        fmt::format("{} is a result; `help set` says what can be set", signal.name));
}

Change change_word(const SignalInfo &signal, int64_t raw, const ScriptedRun &run)
{
    for (const Channel &channel : CHANNELS) {
        if (find_signal(channel.name) == &signal) {
            return force_channel(channel.channel, raw);
        }
    }
    if (signal.word.home != Word::Home::cfg && signal.word.home != Word::Home::drive) {
        refuse_result(signal);
    }
    check_change(signal, raw, run);
    if (signal.word.home == Word::Home::cfg) {
        return {
            [&signal, raw](ScriptedRun &r) { write_configuration(signal, raw, r.sim().seam()); },
            {}};
    }
    return {[&signal, raw](ScriptedRun &r) { write_word(signal.word, raw, r.sim().seam()); }, {}};
}

[[noreturn]] void refuse_value(const char *name, double value, double lowest, double highest,
                               const char *unit)
{
    throw std::runtime_error(fmt::format("{} is from {}{}{}, found {}", name,
                                         limits_text(lowest, highest, SHOWN_DIGITS),
                                         *unit == '\0' ? "" : " ", unit, value));
}

bool is_within(double value, double lowest, double highest)
{
    return value >= lowest && value <= highest; // NaN is nowhere
}

// An expression's value is a double: beyond this it is no longer each whole number.
RawRange exact_range(const Word &word)
{
    constexpr int64_t EXACT = int64_t{1} << 53U;
    const RawRange range = raw_range(word);
    return {std::max(range.lowest, -EXACT), std::min(range.highest, EXACT)};
}

int64_t checked_raw(const Named &named, double value, const Simulation &sim)
{
    const SignalInfo &signal = *named.signal;
    const RawRange range = exact_range(signal.word);
    const auto lowest = static_cast<double>(range.lowest);
    const auto highest = static_cast<double>(range.highest);
    const double raw = named.raw ? value : raw_from_si(signal, value, sim);
    const bool fits = is_within(raw, lowest, highest);
    if (named.raw && (!fits || std::floor(raw) < raw)) {
        throw std::runtime_error(fmt::format("{}.raw is a whole number from {} to {}, found {}",
                                             signal.name, range.lowest, range.highest, raw));
    }
    if (!fits) {
        const Scale scale = word_scale(signal, sim);
        refuse_value(signal.name, value, (lowest - scale.zero) * scale.one,
                     (highest - scale.zero) * scale.one, scale.unit);
    }
    return static_cast<int64_t>(raw);
}

void refuse_in_recording(const SignalInfo &signal, const ScriptedRun &run)
{
    if (run.is_recorded()) {
        throw std::runtime_error(fmt::format(
            "{} is what it was: a recording has its commands in its frames", signal.name));
    }
}

// States whose enumerators are the drive's own are no numbers to play with.
Change change_of(const Named &named, double value, const ScriptedRun &run)
{
    const SignalInfo &signal = *named.signal;
    if (signal.value == nullptr) {
        const int64_t raw = checked_raw(named, value, run.sim());
        if (signal.quantity == Quantity::state || signal.quantity == Quantity::fault) {
            refuse_result(signal);
        }
        return change_word(signal, raw, run);
    }
    for (const Command &command : COMMANDS) {
        if (find_signal(command.name) == &signal) {
            refuse_in_recording(signal, run);
            if (!is_within(value, -command.largest, command.largest)) {
                refuse_value(signal.name, value, -command.largest, command.largest,
                             unit_text(signal, run.sim()));
            }
            return {[set = command.set, value](ScriptedRun &r) { (r.*set)(value); }, {}};
        }
    }
    refuse_result(signal);
}

// A command of another mode would change nothing.
void check_mode(const SignalInfo &signal, const Tick &tick)
{
    struct Mode {
        DriveMode mode;
        const char *name;
        const char *command;
    };
    static constexpr Mode MODES[] = {
        {DriveMode::speed, "speed", "speed_command_rpm"},
        {DriveMode::position, "position", "position_command_rad"},
        {DriveMode::torque, "torque", "torque_command_nm"},
    };
    const std::string name = signal.name;
    const auto in_force = std::find_if(std::begin(MODES), std::end(MODES),
                                       [&](const Mode &m) { return m.mode == tick.mode; });
    for (const Mode &other : MODES) {
        if (name == other.command && other.mode != tick.mode) {
            throw std::runtime_error(
                fmt::format("{} commands nothing in a run in {} mode", name, in_force->name));
        }
    }
}

// A configuration that the drive is given takes the place of all that was forced in the one before.
int64_t last_tick(const SignalInfo &signal, const ScriptedRun &run)
{
    return signal.value == nullptr && signal.word.home == Word::Home::cfg ? run.built_until()
                                                                          : Timeline::FOR_EVER;
}

} // namespace

std::string set_signal(Timeline &timeline, const std::string &assignment, Span span)
{
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
        throw std::runtime_error(fmt::format("NAME = VALUE; found '{}'", readable(assignment)));
    }
    const Named named = named_signal(trimmed(assignment.substr(0, equals)));
    const Value value = parse_expression(assignment.substr(equals + 1), named_value);
    check_mode(*named.signal, timeline.tick());
    const Change change = change_of(named, value(timeline.tick()), timeline.run());
    const char *const name = named.signal->name;
    const bool once = span == Span::once;
    const std::string text = fmt::format("{} {}", once ? "set" : "force", trimmed(assignment));
    timeline.edit(name, text, once ? timeline.now() : last_tick(*named.signal, timeline.run()),
                  change.act, change.end);
    return timeline.edits().back() + '\n';
}

} // namespace nf::debug
