// SPDX-License-Identifier: MIT
#include "live_run.h"

#include "board_commands.h"
#include "command_source.h"
#include "console.h"
#include "follower.h"
#include "interrupt.h"
#include "line_rate.h"
#include "live_view.h"
#include "readable.h"
#include "trace.h"
#include "trimmed.h"
#include "udp_sink.h"
#include "vcd.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

#include <unistd.h>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr double LOOK_S = 0.02; // between two looks at keys and lines
constexpr double IN_STEP_S = 5; // until then a script waits for the first state
constexpr double LATE_S = 10;   // behind --for: the board's time does not go on
constexpr double PS_PER_S = 1e12;
constexpr const char *STOP = "stop";

// What is written of each tick that is verified.
class LiveOutputs : public TickSink
{
public:
    explicit LiveOutputs(const LiveOptions &options) : for_s_(options.for_s)
    {
        if (!options.trace.empty()) {
            trace_ = std::make_unique<Trace>(options.trace, false);
        }
        if (!options.vcd.empty()) {
            vcd_ = std::make_unique<Vcd>(options.vcd,
                                         TimeWindow{0, std::numeric_limits<double>::infinity()});
        }
        if (!options.udp.empty()) {
            udp_ = std::make_unique<UdpSink>(options.udp, options.udp_every);
        }
    }

    void add(const Tick &tick) override
    {
        first_s_ = first_s_.value_or(tick.time_s);
        ended_ =
            for_s_ && tick.time_s - *first_s_ >= *for_s_ - tick.sim->bases().control_period_s / 2;
        if (ended_) {
            return;
        }
        if (trace_) {
            trace_->add(tick);
        }
        if (vcd_) {
            vcd_->add(tick);
        }
        if (udp_) {
            udp_->add(tick);
        }
    }

    // All ticks of --for are there.
    bool has_ended() const
    {
        return ended_;
    }

    // Some tick is there.
    bool has_begun() const
    {
        return first_s_.has_value();
    }

    void close()
    {
        if (trace_) {
            trace_->close();
        }
        if (vcd_) {
            vcd_->close();
        }
    }

private:
    std::optional<double> for_s_;
    std::optional<double> first_s_;
    bool ended_ = false;
    std::unique_ptr<Trace> trace_;
    std::unique_ptr<Vcd> vcd_;
    std::unique_ptr<UdpSink> udp_;
};

class LiveRun
{
public:
    LiveRun(Channel &channel, const LiveOptions &options);
    bool run();

private:
    void follow_to_the_end();
    void connect();
    void warn_of_a_slow_line();
    void get_into_step();
    void pass(double seconds);
    void step();
    void take_what_is_typed_meanwhile();
    std::optional<std::string> next_line();
    void take_lines();
    void execute(const std::string &line);
    bool step_through(const RecordedRun &run);
    bool converse(const RecordedRun &run);
    bool is_over();
    void leave();
    void say(const std::string &line);

    Channel &channel_;
    const LiveOptions &options_;
    LiveOutputs outputs_;
    bool person_;                           // types, and sees what comes
    std::unique_ptr<CommandSource> source_; // none: a person types
    std::unique_ptr<LiveView> view_;
    Follower follower_;
    BoardCommands commands_;
    std::deque<std::string> typed_; // while a command was under way
    bool quit_ = false;
    bool refused_ = false;
    double begun_s_ = 0;
    std::atomic<bool> stepping_{false}; // somebody else has the terminal: lines wait
    std::mutex waiting_guard_;
    std::vector<std::string> waiting_;
};

LiveRun::LiveRun(Channel &channel, const LiveOptions &options)
    : channel_(channel), options_(options), outputs_(options),
      person_(options.script.empty() && isatty(STDIN_FILENO) != 0 && isatty(STDOUT_FILENO) != 0),
      source_(person_ ? nullptr : std::make_unique<CommandSource>(options.script)),
      view_(person_ ? terminal_view() : plain_view()),
      follower_(channel, outputs_,
                {[this](const std::string &line) { say(line); },
                 [this](const std::string &text) { commands_.take_text(text); }},
                {options.timing, options.keep_s}),
      commands_(follower_, options.files,
                {[this](const std::string &line) { say(line); },
                 [this](double seconds) { pass(seconds); },
                 [this](const RecordedRun &run) { return step_through(run); }})
{
}

void LiveRun::say(const std::string &line)
{
    if (stepping_) {
        const std::lock_guard<std::mutex> guard(waiting_guard_);
        waiting_.push_back(line);
    } else {
        view_->say(line);
    }
}

void LiveRun::connect()
{
    follower_.connect();
    check(follower_.about().name, options_.files);
    follower_.know_board(board_of(follower_.about().name, options_.files));
    const Identity &identity = follower_.identity();
    say(fmt::format("{}, {:g} ticks per s, {} baud", follower_.about().name,
                    PS_PER_S / identity.tick_ps, identity.baud));
    warn_of_a_slow_line();
}

void LiveRun::warn_of_a_slow_line()
{
    const Identity &identity = follower_.identity();
    const double needed = baud_needed(PS_PER_S / identity.tick_ps);
    if (options_.baud != 0 && identity.baud < needed) {
        say(fmt::format("the line is too slow for all ticks: {} baud, {:.0f} needed (board.baud of "
                        "the board file, and --baud); there may be gaps",
                        identity.baud, std::ceil(needed)));
    }
}

// A script's first command finds a drive whose command is known: a state alone does not have it.
void LiveRun::get_into_step()
{
    const double until_s = channel_.now_s() + IN_STEP_S;
    while (!follower_.shadow().command() && channel_.now_s() < until_s && !is_over()) {
        step();
    }
}

bool LiveRun::is_over()
{
    if (debug::was_interrupted() || quit_ || outputs_.has_ended()) {
        return true;
    }
    if (options_.for_s && channel_.now_s() > begun_s_ + *options_.for_s + LATE_S) {
        throw LinkError(fmt::format("{:g} s of the board did not come within {:g} s",
                                    *options_.for_s, *options_.for_s + LATE_S));
    }
    return !person_ && source_->has_ended() && !options_.for_s;
}

void LiveRun::step()
{
    follower_.step(LOOK_S);
    view_->show(follower_);
}

void LiveRun::pass(double seconds)
{
    const double until_s = channel_.now_s() + seconds;
    while (channel_.now_s() < until_s && !debug::was_interrupted() && !outputs_.has_ended()) {
        step();
        take_what_is_typed_meanwhile();
    }
}

// A stop does not wait for the command that is under way.
void LiveRun::take_what_is_typed_meanwhile()
{
    const std::optional<std::string> line = person_ ? view_->typed() : std::nullopt;
    if (line && debug::trimmed(*line) == STOP) {
        execute(*line);
    } else if (line) {
        typed_.push_back(*line);
    }
}

std::optional<std::string> LiveRun::next_line()
{
    if (!person_) {
        return source_->next();
    }
    if (typed_.empty()) {
        return view_->typed();
    }
    std::string line = std::move(typed_.front());
    typed_.pop_front();
    return line;
}

void LiveRun::execute(const std::string &line)
{
    if (!person_) {
        say("> " + readable(line, debug::LINE_READABLE));
    }
    const debug::Answer answer = commands_.execute(line);
    if (!answer.text.empty()) {
        say(answer.outcome == debug::Outcome::refused ? "refused: " + answer.text : answer.text);
    }
    quit_ = answer.outcome == debug::Outcome::quit;
    refused_ = refused_ || answer.outcome == debug::Outcome::refused;
}

void LiveRun::take_lines()
{
    if (const std::optional<std::string> line = next_line()) {
        execute(*line);
    }
}

bool LiveRun::converse(const RecordedRun &run)
{
    debug::Session session(run, "live");
    session.timeline.go_to(session.timeline.last());
    const std::unique_ptr<debug::LineReader> reader =
        person_ ? debug::terminal_reader(debug::completions) : source_->reader(stdout);
    return debug::converse(session, *reader, stdout);
}

// Joins a thread that ends when its flag is set, also when an exception passes.
class Joining
{
public:
    Joining(std::thread &thread, std::atomic<bool> &ends) : thread_(thread), ends_(ends)
    {
    }
    ~Joining()
    {
        ends_ = true;
        thread_.join();
    }
    Joining(const Joining &) = delete;
    Joining &operator=(const Joining &) = delete;

private:
    std::thread &thread_;
    std::atomic<bool> &ends_;
};

// The board is followed all the same: it stops a motor that nobody asks for.
bool LiveRun::step_through(const RecordedRun &run)
{
    std::exception_ptr problem;
    std::atomic<bool> done{false};
    view_->leave();
    stepping_ = true;
    std::thread following([&] {
        try {
            while (!done) {
                follower_.step(LOOK_S);
            }
        } catch (...) {
            problem = std::current_exception();
        }
    });
    bool good = false;
    {
        const Joining joining(following, done);
        good = converse(run);
    }
    stepping_ = false;
    view_->enter();
    for (const std::string &line : std::exchange(waiting_, {})) {
        view_->say(line);
    }
    if (problem) {
        std::rethrow_exception(problem);
    }
    return good;
}

void LiveRun::follow_to_the_end()
{
    connect();
    get_into_step();
    while (!is_over()) {
        take_lines();
        step();
    }
}

// With a BYE the board does not watch any more whether a PC is there: that is for who ends the
// session by a command. A terminal that was closed, or a ctrl-C, is a PC that is gone: the time-out
// of the board goes on.
void LiveRun::leave()
{
    if (debug::was_interrupted()) {
        return;
    }
    if (commands_.runs()) {
        say("the motor runs on, and the board does not watch for a PC any more");
    }
    try {
        follower_.leave();
    } catch (const LinkError &error) {
        say(error.what());
    }
}

// What was measured is kept whatever ends it. Of a board that was never followed there is nothing:
// a file of before stays.
bool LiveRun::run()
{
    const debug::InterruptWatch watch(debug::ending_signals());
    begun_s_ = channel_.now_s();
    try {
        follow_to_the_end();
    } catch (...) {
        if (outputs_.has_begun()) {
            outputs_.close();
        }
        throw;
    }
    outputs_.close();
    leave();
    return follower_.departures() == 0 && (person_ || !refused_);
}

} // namespace

bool follow(Channel &channel, const LiveOptions &options)
{
    LiveRun run(channel, options);
    return run.run();
}

} // namespace nf::live
