// SPDX-License-Identifier: MIT
// A running board at a serial line, as `motorsim live` has it. live.open asks who is there,
// live.pass follows it for a while, the other calls tell it something. Each call ends within the
// time that it is given, but for a command that waits.
#include "answers.h"
#include "calls.h"
#include "live_board.h"
#include "worker_line.h"

#include "fault_line.h"
#include "found_fault.h"
#include "line_rate.h"
#include "names.h"
#include "paced_channel.h"
#include "schema.h"
#include "trimmed.h"
#include "vocabulary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace nf::web::live_session
{
namespace
{

using debug::Answer;
using debug::Outcome;

constexpr double PASS_S = 0.02; // between two looks at what a person asks for
constexpr double PS_PER_S = 1e12;
constexpr std::array<FileKind, 3> FILES_OF_A_BOARD = {FileKind::motor, FileKind::board,
                                                      FileKind::tuning};

// What the page shows of the ticks that are verified.
class Shown : public TickSink
{
public:
    Shown(const Json &scope, double period_s)
        : period_s_(period_s), scope_(scope_of(scope, period_s))
    {
    }

    void set_scope(const Json &given)
    {
        scope_ = scope_of(given, period_s_);
    }

    // Of the last tick, from the next one on.
    void set_values(const std::vector<std::string> &names)
    {
        std::vector<Value> values;
        for (const std::string &name : names) {
            const SignalInfo *const signal = debug::named_signal(name).signal;
            const auto known =
                std::find_if(values_.begin(), values_.end(),
                             [signal](const Value &value) { return value.signal == signal; });
            values.push_back({signal, known == values_.end() ? NOT_KNOWN : known->last});
        }
        values_ = std::move(values);
    }

    void add(const Tick &tick) override
    {
        if (std::abs(tick.time_s - time_s_ - period_s_) > period_s_ / 2) {
            scope_.skip(); // ticks are missing, or the board counts anew
        }
        scope_.add(tick);
        time_s_ = tick.time_s;
        for (Value &value : values_) {
            value.last = si_value(*value.signal, tick);
        }
    }

    double time_s() const
    {
        return time_s_;
    }

    Scope &scope()
    {
        return scope_;
    }

    Json values_json() const
    {
        Json values = Json::object();
        for (const Value &value : values_) {
            values[value.signal->name] = value.last; // NaN becomes null
        }
        return values;
    }

private:
    static constexpr double NOT_KNOWN = std::numeric_limits<double>::quiet_NaN();

    struct Value {
        const SignalInfo *signal;
        double last;
    };

    double period_s_;
    Scope scope_;
    std::vector<Value> values_;
    double time_s_ = 0;
};

// Ticks go to what is made of them when the board has said how long they are.
class Later : public TickSink
{
public:
    void add(const Tick &tick) override
    {
        if (shown) {
            shown->add(tick);
        }
    }

    std::unique_ptr<Shown> shown;
};

class LiveSession
{
public:
    explicit LiveSession(const Json &given)
        : files_{given.at("files").at("motor"),
                 given.at("files").at("board"),
                 given.at("files").at("tuning"),
                 {}},
          pace_(given.at("pace")), paced_(line_, pace_),
          follower_(paced_, sink_,
                    {[this](const std::string &line) { said_.push_back(line); },
                     [this](const std::string &text) { commands_.take_text(text); }},
                    options_of(given)),
          commands_(follower_, files_,
                    {[this](const std::string &line) { said_.push_back(line); },
                     [this](double seconds) { pass(seconds); },
                     [](const RecordedRun &) { return false; }})
    {
        follower_.connect();
        check_files();
        sink_.shown = std::make_unique<Shown>(given, follower_.bases().control_period_s);
    }

    // Of this machine's time.
    void follow(double seconds)
    {
        pass(seconds * pace_);
    }

    // Of the board's time. A stop that a person asks for does not wait for the command that is
    // under way.
    void pass(double seconds)
    {
        const double until_s = follower_.now_s() + seconds;
        do {
            stop_where_asked();
            follower_.step(std::min(PASS_S, seconds));
        } while (follower_.now_s() < until_s);
        stop_where_asked();
    }

    live::BoardCommands &commands()
    {
        return commands_;
    }

    std::vector<std::string> take_said()
    {
        return std::exchange(said_, {});
    }

    // What the board has answered to a stop.
    std::optional<Answer> take_stop_answer()
    {
        return std::exchange(stop_answer_, std::nullopt);
    }

    // The board goes on, and does not watch any more whether somebody is there.
    std::string leave()
    {
        stop_where_asked();
        const bool runs = commands_.runs();
        follower_.leave();
        return runs ? "the motor runs on, and the board does not watch for a PC any more" : "";
    }

    live::Follower &follower()
    {
        return follower_;
    }
    Shown &shown()
    {
        return *sink_.shown;
    }
    std::string state; // the last one that is known; empty before
    Json fault = nullptr;

private:
    static live::FollowerOptions options_of(const Json &given)
    {
        live::FollowerOptions options;
        options.keep_s = given.at("keep_s");
        return options;
    }

    // A board whose files are wrong is left as it was found.
    void check_files()
    {
        try {
            live::check(follower_.about().name, files_);
            follower_.know_board(live::board_of(follower_.about().name, files_));
        } catch (const ConfigError &) {
            follower_.leave();
            throw;
        }
    }

    void stop_where_asked()
    {
        if (WorkerLine::take_stop()) {
            stop_answer_ = commands_.execute("stop");
        }
    }

    live::FileChoice files_;
    double pace_;
    WorkerLine line_;
    live::PacedChannel paced_;
    Later sink_;
    std::vector<std::string> said_;
    std::optional<Answer> stop_answer_;
    live::Follower follower_;
    live::BoardCommands commands_;
};

std::unique_ptr<LiveSession> session;

LiveSession &open_session()
{
    if (!session) {
        throw std::runtime_error("no board is connected");
    }
    return *session;
}

std::string build_text(const live::Identity &identity)
{
    return fmt::format("{:02x}", fmt::join(identity.build, ""));
}

Json head_of(LiveSession &s)
{
    const live::Identity &identity = s.follower().identity();
    const double ticks_per_s = PS_PER_S / identity.tick_ps;
    return {{"name", s.follower().about().name},
            {"build", build_text(identity)},
            {"ticks_per_s", ticks_per_s},
            {"baud", identity.baud},
            {"baud_needed", std::ceil(live::baud_needed(ticks_per_s))},
            {"speed_max_rpm", s.follower().about().speed_max_rpm},
            {"torque_max_nm", s.commands().torque_max_nm()},
            {"moves", moves_json()}};
}

Json open(const Json &given)
{
    session.reset(); // its memory is needed
    session = std::make_unique<LiveSession>(given);
    return head_of(*session);
}

// Of the configuration that is in force now: another motor has another name and other limits.
Json head(const Json &given)
{
    (void)given;
    return head_of(open_session());
}

// Null before the first state of the board is known.
Json signals(const Json &given)
{
    (void)given;
    const live::Shadow &shadow = open_session().follower().shadow();
    return shadow.is_in_step() ? recorded_signals_json(shadow.sim()) : Json(nullptr);
}

Json scope(const Json &given)
{
    open_session().shown().set_scope(given);
    return nullptr;
}

// The drive's count of ticks wraps, the shadow's does not.
Json fault_of(const live::Shadow &shadow, const BoardSettings *board)
{
    const Simulation &sim = shadow.sim();
    if (sim.drive().state != DRIVE_STATE_FAULT) {
        return nullptr;
    }
    const FoundFault fault = found_fault(sim.drive(), sim.bases());
    const uint32_t ago = static_cast<uint32_t>(shadow.next()) - fault.tick;
    const auto tick = static_cast<double>(shadow.next() - ago);
    return fault_json(fault, tick * sim.bases().control_period_s,
                      fault_measure(fault, sim.bases(), board));
}

void look(LiveSession &s)
{
    const live::Shadow &shadow = s.follower().shadow();
    if (shadow.is_in_step()) {
        s.state = state_name(shadow.sim().drive().state);
        s.fault = fault_of(shadow, s.follower().board());
    }
}

double speed_rpm_of(const drive_command_t &command, const Bases &bases)
{
    return bases.rpm_from_step(command.target);
}

double position_deg_of(const drive_command_t &command, const Bases &bases)
{
    constexpr double Q16 = 65536.0;
    constexpr double DEG_PER_TURN = 360.0;
    return command.target / Q16 / bases.pole_pairs * DEG_PER_TURN;
}

double torque_nm_of(const drive_command_t &command, const Bases &bases)
{
    constexpr double Q28 = 268435456.0;
    return command.target / Q28 * bases.torque_nm();
}

// In rpm, in degrees of the shaft, or in N·m.
Json command_json(const std::optional<drive_command_t> &command, const Bases &bases)
{
    struct Mode {
        const char *word;
        double (*value)(const drive_command_t &, const Bases &);
    };
    constexpr Mode SPEED = {"speed", speed_rpm_of};
    constexpr Mode POSITION = {"position", position_deg_of};
    constexpr Mode TORQUE = {"torque", torque_nm_of};
    if (!command) {
        return nullptr;
    }
    // A measurement has words of its own there.
    if ((command->request & DRIVE_REQUEST_PROBE) != 0) {
        return {{"run", true}, {"mode", SPEED.word}, {"value", 0}};
    }
    Mode mode = SPEED;
    if (command->mode == DRIVE_MODE_POSITION) {
        mode = POSITION;
    } else if (command->mode == DRIVE_MODE_TORQUE) {
        mode = TORQUE;
    }
    return {{"run", command->request != 0},
            {"mode", mode.word},
            {"value", mode.value(*command, bases)}};
}

Json answer_json(const Answer &answer)
{
    return {{"text", answer.text}, {"refused", answer.outcome == Outcome::refused}};
}

// How far a measurement is; null: there is none.
Json measuring_json(const live::BoardCommands &commands, double now_s)
{
    const live::Identification *const one = commands.identification();
    if (one == nullptr) {
        return nullptr;
    }
    return {{"seconds", now_s - one->begun_s()},
            {"phases", one->measurement().phases()},
            {"ended", commands.identification_has_ended()}};
}

Json timeout_json(const live::Shadow &shadow)
{
    if (!shadow.is_in_step()) {
        return nullptr;
    }
    const Simulation &sim = shadow.sim();
    return sim.cfg().link.timeout_ticks * sim.bases().control_period_s;
}

Json health_json(const live::Follower &follower)
{
    const live::Health &health = follower.health();
    return {{"load_pct", health.load_pct},         {"late_ticks", health.late_ticks},
            {"tick_lost", health.tick_lost},       {"gaps", follower.gaps().size()},
            {"departures", follower.departures()}, {"hashes", follower.shadow().hashes_compared()},
            {"broken", follower.broken()},         {"bytes", follower.bytes_in()},
            {"no_stream", follower.no_stream()},   {"source", health.source},
            {"input_lost", health.input_lost},     {"reset", health.reset}};
}

Json pass(const Json &given)
{
    LiveSession &s = open_session();
    Shown &shown = s.shown();
    shown.scope().clear();
    shown.set_values(texts_of(given, "values"));
    s.follow(given.at("seconds"));
    look(s);
    const std::optional<Answer> stop = s.take_stop_answer();
    return {{"tick", s.follower().shadow().next()},
            {"time_s", shown.time_s()},
            {"state", s.state},
            {"fault", s.fault},
            {"values", shown.values_json()},
            {"times", block_of(shown.scope().times_s())},
            {"columns", columns_json(shown.scope())},
            {"in_step", s.follower().shadow().is_in_step()},
            {"command", command_json(s.commands().in_force(), s.follower().bases())},
            {"stop", stop ? answer_json(*stop) : Json(nullptr)},
            {"timeout_s", timeout_json(s.follower().shadow())},
            {"measuring", measuring_json(s.commands(), s.follower().now_s())},
            {"said", s.take_said()},
            {"health", health_json(s.follower())}};
}

// Commands of the program that the page has in another place.
struct Elsewhere {
    const char *word;
    const char *place;
};
constexpr std::array<Elsewhere, 7> ELSEWHERE = {
    {{"record", "press Record"},
     {"identify", "press Measure the motor"},
     {"dump", "press Parameters, then Download block"},
     {"load", "press Parameters, then choose or drop the block's file"},
     {"debug", "press Record, then Open in Replay: the stepper is there"},
     {"wait", "wait is for scripts"},
     {"quit", "press Disconnect"}}};

const Elsewhere *elsewhere(const std::string &line)
{
    const std::string word = line.substr(0, line.find(' '));
    const auto *const found = std::find_if(ELSEWHERE.begin(), ELSEWHERE.end(),
                                           [&](const Elsewhere &one) { return word == one.word; });
    return found == ELSEWHERE.end() ? nullptr : found;
}

// Without the commands that are elsewhere.
std::string help_here()
{
    std::istringstream lines(live::BoardCommands::help());
    std::vector<std::string> here;
    for (std::string line; std::getline(lines, line);) {
        if (elsewhere(line) == nullptr) {
            here.push_back(line);
        }
    }
    return fmt::format("{}", fmt::join(here, "\n"));
}

Json execute(const Json &given)
{
    const std::string line = debug::trimmed(given.at("line"));
    if (const Elsewhere *const other = elsewhere(line)) {
        return {{"text", other->place}, {"refused", true}};
    }
    return answer_json(line == "help" ? Answer{Outcome::done, help_here()}
                                      : open_session().commands().execute(line));
}

// Of the files whose configuration is in force: all that `set` takes.
Json keys(const Json &given)
{
    (void)given;
    const Config config = live::load(open_session().commands().files_in_force());
    Json keys = Json::array();
    for (const Field &field : schema()) {
        const bool is_of_board =
            std::any_of(FILES_OF_A_BOARD.begin(), FILES_OF_A_BOARD.end(),
                        [&](FileKind kind) { return may_hold(kind, field.section); });
        if (is_of_board) {
            keys.push_back({{"name", field.name()},
                            {"value", field.value_text(config)},
                            {"allowed", field.allowed()},
                            {"meaning", field.meaning()}});
        }
    }
    return keys;
}

Json record(const Json &given)
{
    return live_board::told("record", given);
}

Json close(const Json &given)
{
    (void)given;
    std::string text = open_session().leave();
    session.reset();
    return text;
}

} // namespace

const Calls &calls()
{
    static const Calls all = {
        {"live.open", open},       {"live.head", head},     {"live.scope", scope},
        {"live.signals", signals}, {"live.pass", pass},     {"live.execute", execute},
        {"live.keys", keys},       {"live.record", record}, {"live.close", close}};
    return all;
}

} // namespace nf::web::live_session

namespace nf::web::live_board
{

live::BoardCommands &commands()
{
    return live_session::open_session().commands();
}

std::string said_or_thrown(const debug::Answer &answer)
{
    if (answer.outcome == debug::Outcome::refused) {
        throw std::runtime_error(answer.text);
    }
    return answer.text;
}

std::string told(const char *word, const Json &given)
{
    const std::string file = given.at("file");
    return said_or_thrown(commands().execute(std::string(word) + ' ' + file));
}

} // namespace nf::web::live_board
