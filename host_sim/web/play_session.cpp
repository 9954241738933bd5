// SPDX-License-Identifier: MIT
// A machine without a script, for a person to play with. play.start makes it, play.advance lets
// time go by, the other calls turn its knobs and break it. All that a person does is an edit of a
// timeline, so the recent past can be stepped through.
#include "answers.h"
#include "calls.h"
#include "scope.h"
#include "sessions.h"

#include "document.h"
#include "event_file.h"
#include "fault_line.h"
#include "names.h"
#include "si.h"
#include "vocabulary.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace nf::web::play_session
{
namespace
{

constexpr double KEPT_S = 10;
constexpr double LONGEST_S = 86400; // a day at 48 kHz is less than the drive's tick can count
constexpr double POSITION_MAX_DEG = 3600;

// The machine of a scenario, with nothing that happens in it. A person says when it runs.
Config machine_of(const Choice &choice)
{
    Config config = load_scenario(choice.scenario, choice.with, choice.set);
    ScenarioSettings &script = config.scenario;
    script.mode = DriveMode::speed;
    script.prelude_s = 0;
    script.duration_s = LONGEST_S;
    script.command.clear();
    script.load.clear();
    script.faults.clear();
    script.requests = {{0, false, false}};
    return config;
}

struct PlaySession {
    explicit PlaySession(const Choice &choice)
        : config(machine_of(choice)),
          period_s(make_bases(config.motor, config.board).control_period_s),
          stepper(config, std::llround(KEPT_S / period_s)), latest(stepper.timeline.now())
    {
    }

    // The stepper keeps a reference to it.
    Config config;
    double period_s;
    debug::Session stepper;
    int64_t latest; // tick that play has come to; a stepper may stand before it
    std::unique_ptr<Scope> scope;
    DriveMode mode = DriveMode::speed;
    double command = 0; // rpm, degrees from `origin_rad`, or N·m
    double origin_rad = 0;
    double load_nm = 0;
    std::set<std::string> broken;
};

std::unique_ptr<PlaySession> session;

PlaySession &open_session()
{
    if (!session) {
        throw std::runtime_error("there is no machine to play with");
    }
    return *session;
}

// Once, at the present tick; whoever steps back and on again sees it again.
void act(PlaySession &s, const std::string &text, const debug::Timeline::Act &what)
{
    debug::Timeline &timeline = s.stepper.timeline;
    timeline.go_to(std::max(s.latest, timeline.now()));
    timeline.edit("play", text, timeline.now(), what);
}

double checked(const char *name, double value, double largest, const char *unit)
{
    if (!(std::abs(value) <= largest)) {
        throw std::runtime_error(fmt::format("{} = {:g} {}; allowed: {:g} to {:g} {}", name, value,
                                             unit, -largest, largest, unit));
    }
    return value;
}

double largest_speed_rpm(const PlaySession &s)
{
    return s.config.motor.rated_speed_rpm * SPEED_COMMAND_MAX_PCT / 100;
}

double largest_load_nm(const PlaySession &s)
{
    return s.config.motor.rated_torque_nm * LOAD_MAX_PCT / 100;
}

// That of the largest current, with the flux of the motor's file.
double largest_torque_nm(const PlaySession &s)
{
    const Simulation &sim = s.stepper.timeline.run().sim();
    constexpr double Q28 = 268435456.0;
    return sim.bases().torque_nm() / Q28 *
           current_reference_torque(sim.cfg().derating.current_max, sim.cfg().current_loop.emf_q13);
}

Json limits_json(const PlaySession &s)
{
    return {{"speed_rpm", largest_speed_rpm(s)},
            {"position_deg", POSITION_MAX_DEG},
            {"torque_nm", largest_torque_nm(s)},
            {"load_nm", largest_load_nm(s)},
            {"current_a", s.config.motor.max_current_a}};
}

const char *word_of(DriveMode mode)
{
    switch (mode) {
    case DriveMode::position:
        return "position";
    case DriveMode::torque:
        return "torque";
    case DriveMode::speed:
        break;
    }
    return "speed";
}

Json knobs_of(const PlaySession &s)
{
    return {{"mode", word_of(s.mode)},
            {"command", s.command},
            {"load_nm", s.load_nm},
            {"broken", s.broken}};
}

Json head_of(const PlaySession &s)
{
    const Simulation &sim = s.stepper.timeline.run().sim();
    return {{"period_s", s.period_s},
            {"motor", s.config.motor.name},
            {"board", s.config.board.name},
            {"tuning", s.config.tuning.name},
            {"bus_v", s.config.board.bus_nominal_v},
            {"has_sensor", drive_has_sensor(&sim.drive())},
            {"limits", limits_json(s)},
            {"knobs", knobs_of(s)},
            {"moves", moves_json()},
            {"signals", signals_json(sim)}};
}

void set_scope(PlaySession &s, const Json &given)
{
    s.scope = std::make_unique<Scope>(scope_of(given, s.period_s));
}

Json start(const Json &given)
{
    session.reset(); // its memory is needed
    auto made = std::make_unique<PlaySession>(choice_of(given));
    set_scope(*made, given);
    session = std::move(made);
    return head_of(*session);
}

// Of the machine that is there; null without one.
Json head(const Json &given)
{
    (void)given;
    return session ? head_of(*session) : Json(nullptr);
}

Json scope(const Json &given)
{
    set_scope(open_session(), given);
    return nullptr;
}

Json fault_of(const PlaySession &s, const Simulation &sim)
{
    if (sim.drive().state != DRIVE_STATE_FAULT) {
        return nullptr;
    }
    const FoundFault fault = found_fault(sim.drive(), sim.bases());
    return fault_json(fault, fault.tick * s.period_s,
                      fault_measure(fault, sim.bases(), &s.config.board));
}

Json values_of(const std::vector<std::string> &names, const Tick &tick)
{
    Json values = Json::object();
    for (const std::string &name : names) {
        values[name] = si_value(*debug::named_signal(name).signal, tick);
    }
    return values;
}

Json advance(const Json &given)
{
    PlaySession &s = open_session();
    debug::Timeline &timeline = s.stepper.timeline;
    timeline.go_to(std::max(s.latest, timeline.now()));
    s.scope->clear();
    for (int64_t left = given.at("ticks"); left > 0 && timeline.step(); left--) {
        s.scope->add(timeline.tick());
    }
    s.latest = timeline.now();
    const Simulation &sim = timeline.run().sim();
    return {{"tick", s.latest},
            {"time_s", timeline.tick().time_s},
            {"state", state_name(sim.drive().state)},
            {"fault", fault_of(s, sim)},
            {"values", values_of(texts_of(given, "values"), timeline.tick())},
            {"times", block_of(s.scope->times_s())},
            {"columns", columns_json(*s.scope)}};
}

Json request(const Json &given)
{
    const std::string what = given.at("what");
    RequestEntry entry{};
    if (what == "clear") {
        entry.clear = true;
    } else {
        entry.run = what == "run";
    }
    PlaySession &s = open_session();
    act(s, what, [entry](ScriptedRun &run) { run.ask(entry); });
    return knobs_of(s);
}

// Degrees count from where the rotor was believed to be when positions were first asked for, those
// of the drive from the zero of the turn that it was in.
double position_rad(PlaySession &s, double value_deg)
{
    const Tick &tick = s.stepper.timeline.tick();
    if (s.mode != DriveMode::position) {
        s.origin_rad = std::remainder(
            si_value(*debug::named_signal("position_estimated_rad").signal, tick), TWO_PI);
    }
    return s.origin_rad + value_deg * RAD_PER_DEG;
}

// What may be commanded in a mode, either way, and its unit.
struct Commandable {
    DriveMode mode;
    double largest;
    const char *unit;
};

Commandable commandable(const PlaySession &s, const std::string &mode)
{
    if (mode == "position") {
        return {DriveMode::position, POSITION_MAX_DEG, "°"};
    }
    if (mode == "torque") {
        return {DriveMode::torque, largest_torque_nm(s), "N·m"};
    }
    return {DriveMode::speed, largest_speed_rpm(s), "rpm"};
}

Json command(const Json &given)
{
    PlaySession &s = open_session();
    const auto [mode, largest, unit] = commandable(s, given.at("mode"));
    const double value = checked(word_of(mode), given.at("value"), largest, unit);
    const double target = mode == DriveMode::position ? position_rad(s, value) : value;
    act(s, fmt::format("{} {:g} {}", word_of(mode), value, unit),
        [asked = mode, target](ScriptedRun &run) { run.set_command(asked, target); });
    s.mode = mode;
    s.command = value;
    return knobs_of(s);
}

Json load(const Json &given)
{
    PlaySession &s = open_session();
    const double value = checked("load", given.at("value"), largest_load_nm(s), "N·m");
    act(s, fmt::format("load {:g} N·m", value),
        [value](ScriptedRun &run) { run.set_load_nm(value); });
    s.load_nm = value;
    return knobs_of(s);
}

// In the words of a scenario's file, and with its checks.
FaultEntry entry_of(const Json &given)
{
    const Json value = given.value("value", Json(nullptr));
    const std::string text =
        fmt::format("[{{time_s = 0, what = {}{}}}]", given.at("what").dump(),
                    value.is_null() ? "" : fmt::format(", value = {}", value.get<double>()));
    return read_faults(parse_override("scenario.fault", text)).front();
}

Json break_it(const Json &given)
{
    PlaySession &s = open_session();
    const FaultEntry entry = entry_of(given);
    const std::string what = given.at("what");
    act(s, what, [entry](ScriptedRun &run) { run.begin_fault(entry); });
    if (entry.span == FaultSpan::lasting) {
        s.broken.insert(what);
    }
    return knobs_of(s);
}

Json repair(const Json &given)
{
    PlaySession &s = open_session();
    const FaultKind kind = entry_of(given).kind;
    const std::string what = given.at("what");
    act(s, fmt::format("{} repaired", what), [kind](ScriptedRun &run) { run.end_fault(kind); });
    s.broken.erase(what);
    return knobs_of(s);
}

} // namespace

debug::Session *stepper()
{
    return session ? &session->stepper : nullptr;
}

const Calls &calls()
{
    static const Calls all = {
        {"play.start", start},     {"play.head", head},       {"play.scope", scope},
        {"play.advance", advance}, {"play.request", request}, {"play.command", command},
        {"play.load", load},       {"play.break", break_it},  {"play.repair", repair}};
    return all;
}

} // namespace nf::web::play_session
