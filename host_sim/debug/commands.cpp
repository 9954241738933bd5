// SPDX-License-Identifier: MIT
#include "commands.h"

#include "diff.h"
#include "limit.h"
#include "readable.h"
#include "set.h"
#include "stages.h"
#include "suggest.h"
#include "trimmed.h"

extern "C" {
#include "drive_words.h"
}

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace nf::debug
{
namespace
{

constexpr std::size_t NEAR_COUNT = 3;
constexpr int TIME_DIGITS = 10; // an hour in steps of a microsecond

// What is wrong with a command, as the line for the user.
struct Refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Command {
    const char *name;
    const char *arguments;
    const char *summary;
    const char *teaching;
    std::function<std::string(Session &session, const std::string &rest)> act;
};

const std::vector<Command> &commands();

struct Split {
    std::string first;
    std::string rest;
};

Split split(const std::string &line)
{
    const std::string text = trimmed(line);
    const std::size_t end = text.find_first_of(" \t");
    return end == std::string::npos ? Split{text, ""}
                                    : Split{text.substr(0, end), trimmed(text.substr(end))};
}

std::vector<std::string> words(const std::string &text)
{
    std::vector<std::string> all;
    for (Split next = split(text); !next.first.empty(); next = split(next.rest)) {
        all.push_back(next.first);
    }
    return all;
}

void no_arguments(const std::string &rest)
{
    if (!rest.empty()) {
        throw Refusal(fmt::format("'{}' is one word too many", readable(rest)));
    }
}

int64_t integer(const std::string &text, const char *what, int64_t lowest, int64_t highest)
{
    int64_t value = 0;
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end || value < lowest || value > highest) {
        throw Refusal(fmt::format("{} is a whole number from {} to {}, found '{}'", what, lowest,
                                  highest, readable(text)));
    }
    return value;
}

int64_t count(const std::string &rest)
{
    constexpr int64_t MANY = 1000000000;
    return rest.empty() ? 1 : integer(rest, "how many ticks", 1, MANY);
}

std::string step(Session &session, const std::string &rest)
{
    const int64_t wanted = session.timeline.now() + count(rest);
    const int64_t last = session.timeline.last();
    const std::string stopped = session.go_to(std::min(wanted, last));
    const bool short_of_it = stopped.empty() && wanted > last;
    return stopped + (short_of_it ? "end of the scenario\n" : "") + session.position_text();
}

std::string back(Session &session, const std::string &rest)
{
    const int64_t wanted = session.timeline.now() - count(rest);
    const int64_t first = session.timeline.first();
    const std::string stopped = session.go_to(std::max(wanted, first));
    const bool short_of_it = stopped.empty() && wanted < first;
    return stopped + (short_of_it ? "beginning of the run\n" : "") + session.position_text();
}

std::string run(Session &session, const std::string &rest)
{
    const auto [word, condition] = split(rest);
    if (!word.empty() && word != "until") {
        throw Refusal(fmt::format("run, or run until EXPR; found '{}'", readable(rest)));
    }
    Value value;
    if (word == "until") {
        value = parse_expression(condition, named_value);
    }
    const std::string why = session.run_until(value, condition);
    return fmt::format("stopped: {}\n{}", why, session.position_text());
}

// A tick, or a time since t = 0: 0.35s.
std::string go_to(Session &session, const std::string &rest)
{
    const Timeline &timeline = session.timeline;
    int64_t tick = 0;
    if (!rest.empty() && rest.back() == 's') {
        char *end = nullptr;
        const double time_s = std::strtod(rest.c_str(), &end);
        const double period = timeline.run().sim().bases().control_period_s;
        const double first = static_cast<double>(timeline.first() - timeline.run().zero()) * period;
        const double last = static_cast<double>(timeline.last() - timeline.run().zero()) * period;
        const bool whole = end != rest.c_str() && trimmed(end) == "s";
        const bool inside = time_s >= first - period / 2 && time_s < last + period / 2;
        if (!whole || !inside) {
            throw Refusal(fmt::format("a time is from {}s to {}s, found '{}'",
                                      limit_number({false, first}, TIME_DIGITS),
                                      limit_number({true, last}, TIME_DIGITS), readable(rest)));
        }
        tick = timeline.run().tick_at(time_s);
    } else {
        tick = integer(rest, "a tick", timeline.first(), timeline.last());
    }
    const std::string stopped = session.go_to(std::clamp(tick, timeline.first(), timeline.last()));
    return stopped + session.position_text();
}

std::string list_breaks(const Session &session)
{
    std::string text;
    for (std::size_t k = 0; k < session.breaks.size(); k++) {
        text += fmt::format("{}: break on {}\n", k + 1, session.breaks[k].text);
    }
    return text.empty() ? "no breaks\n" : text;
}

std::string set_break(Session &session, const std::string &rest)
{
    if (rest.empty()) {
        return list_breaks(session);
    }
    const auto [on, what] = split(rest);
    if (on != "on" || what.empty()) {
        throw Refusal(fmt::format("break on fault, break on state, or break on EXPR; found '{}'",
                                  readable(rest)));
    }
    const Break one{what, parse_expression(what == "fault" ? "state == FAULT" : what, named_value),
                    what == "state", 0};
    session.breaks.push_back(one);
    return fmt::format("{}: break on {}\n", session.breaks.size(), what);
}

std::string remove_break(Session &session, const std::string &rest)
{
    if (session.breaks.empty()) {
        throw Refusal("there are no breaks");
    }
    const int64_t number = integer(rest, "a break", 1, static_cast<int64_t>(session.breaks.size()));
    session.breaks.erase(session.breaks.begin() + static_cast<std::ptrdiff_t>(number - 1));
    return list_breaks(session);
}

// Names, or one expression.
std::string print(const Session &session, const std::string &rest)
{
    if (rest.empty()) {
        throw Refusal("print what? NAME... or EXPR; `signals` lists the names");
    }
    const Tick &tick = session.timeline.tick();
    const std::vector<std::string> names = words(rest);
    const bool all_names = std::all_of(names.begin(), names.end(), [](const std::string &name) {
        return name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
                                      "0123456789.[]") == std::string::npos &&
               std::isdigit(static_cast<unsigned char>(name[0])) == 0 && name[0] != '.';
    });
    if (!all_names) {
        return fmt::format("{:.9g}\n", parse_expression(rest, named_value)(tick));
    }
    std::string text;
    for (const std::string &name : names) {
        text += signal_line(named_signal(name), tick) + '\n';
    }
    return text;
}

std::string watch(Session &session, const std::string &rest)
{
    for (const std::string &name : words(rest)) {
        session.watched.push_back(named_signal(name));
    }
    return session.position_text();
}

std::string unwatch(Session &session, const std::string &rest)
{
    if (rest.empty()) {
        session.watched.clear();
    }
    for (const std::string &name : words(rest)) {
        const SignalInfo *const signal = named_signal(name).signal;
        auto &all = session.watched;
        const auto gone = std::remove_if(all.begin(), all.end(),
                                         [&](const Named &one) { return one.signal == signal; });
        if (gone == all.end()) {
            throw Refusal(fmt::format("{} is not watched", readable(name)));
        }
        all.erase(gone, all.end());
    }
    return session.position_text();
}

std::string stages(const Session &session, const std::string &rest)
{
    no_arguments(rest);
    return session.position_text() + stages_text(session.timeline.tick());
}

std::string diff(const Session &session, const std::string &rest)
{
    no_arguments(rest);
    const Timeline &timeline = session.timeline;
    return diff_text(diff_tick(timeline.before(), timeline.tick(), timeline.run().built()));
}

std::string list_edits(const Session &session)
{
    std::string text;
    for (const std::string &line : session.timeline.edits()) {
        text += line + '\n';
    }
    return text.empty() ? "nothing is set\n" : text;
}

std::string set_once(Session &session, const std::string &rest)
{
    return rest.empty() ? list_edits(session) : set_signal(session.timeline, rest, Span::once);
}

std::string force(Session &session, const std::string &rest)
{
    return rest.empty() ? list_edits(session) : set_signal(session.timeline, rest, Span::for_ever);
}

std::string release(Session &session, const std::string &rest)
{
    const std::string name = named_signal(rest).signal->name;
    if (!session.timeline.release(name)) {
        throw Refusal(fmt::format("{} is not set at tick {} or later; `set` lists what is", name,
                                  session.timeline.now()));
    }
    return list_edits(session);
}

std::string hash(const Session &session, const std::string &rest)
{
    no_arguments(rest);
    return fmt::format("tick {}  drive {:08x}\n", session.timeline.now(),
                       drive_words_hash(&session.timeline.run().sim().drive()));
}

std::string signals(const Session &session, const std::string &rest)
{
    std::string text;
    for (const SignalInfo &signal : all_signals()) {
        if (std::string(signal.name).find(rest) != std::string::npos) {
            text += signal_line({&signal, false}, session.timeline.tick()) + '\n';
        }
    }
    if (text.empty()) {
        throw Refusal(fmt::format("no signal has '{}' in its name", readable(rest)));
    }
    return text;
}

const Command &command_of(const std::string &name)
{
    std::vector<std::string> names;
    for (const Command &command : commands()) {
        if (command.name == name) {
            return command;
        }
        names.emplace_back(command.name);
    }
    const std::vector<std::string> near = nearest_at_all(name, names, NEAR_COUNT);
    throw Refusal(near.empty()
                      ? fmt::format("there is no command {}; `help` lists them", readable(name))
                      : fmt::format("there is no command {}; near: {}; `help` lists all",
                                    readable(name), fmt::join(near, " ")));
}

std::string help(const Session &session, const std::string &rest)
{
    (void)session;
    if (!rest.empty()) {
        const Command &command = command_of(rest);
        return fmt::format("{} {}\n{}.\n\n{}\n", command.name, command.arguments, command.summary,
                           command.teaching);
    }
    std::string text;
    for (const Command &command : commands()) {
        text += fmt::format("  {:<28}{}\n", fmt::format("{} {}", command.name, command.arguments),
                            command.summary);
    }
    return text +
           "`help COMMAND` says more. An empty line repeats the last step or back. Ctrl-C stops what "
           "runs.\n";
}

std::string quit(const Session &session, const std::string &rest)
{
    (void)session;
    no_arguments(rest);
    return "";
}

constexpr const char *HELP_EXPR =
    "EXPR: names, numbers, + - * / ( ), < <= > >= == !=, && || !, abs(x). Names are signals in SI\n"
    "units, NAME.raw their integers, and states and faults as words:\n"
    "    run until speed_rpm > 1000 && state == RUN\n"
    "    run until abs(angle_error_el_deg) > 5 || drive.rotor.observer.gradient.raw == 32767";

constexpr const char *HELP_SET =
    "What can be set: words of the drive's state (drive.…), of its configuration (cfg.…, sealed anew\n"
    "so that its guard accepts it), the counts of the converter and of the angle sensor (in.adc_ia,\n"
    "in.adc_ib, in.adc_bus, in.adc_temperature, in.angle) and the commands speed_command_rpm,\n"
    "position_command_rad, load_torque_nm. NAME takes the SI value,\n"
    "NAME.raw the integer:\n"
    "    set speed_command_rpm = 500\n"
    "    set drive.motor.model.observer.volt_gain.raw = 9000\n"
    "    force drive.rotor.observer.speed_out = 300\n"
    "It acts after the tick's interrupt: a state is what the next tick begins with, a count is what it\n"
    "reads. Going back and on again repeats it; `release NAME` ends it, `set` alone lists.";

const std::vector<Command> &commands()
{
    static const std::vector<Command> table = {
        {"step", "[N]", "N ticks on",
         "A tick is one control interrupt; at it, all signals are those that it has just computed.",
         step},
        {"back", "[N]", "N ticks back", "To the same bits as before: a run is its inputs.", back},
        {"run", "[until EXPR]", "on until EXPR holds, a break, or the end", HELP_EXPR, run},
        {"goto", "TICK | TIMEs", "to a tick, or to a time since t = 0",
         "Forwards or backwards:\n    goto 4711\n    goto 0.35s", go_to},
        {"break", "[on fault|state|EXPR]", "stop there; alone: list",
         "A run stops when the drive latches a fault, changes its state, or EXPR becomes true.\n"
         "See `help run` for EXPR.",
         set_break},
        {"delete", "N", "remove a break", "N is its number in the list of `break`.", remove_break},
        {"print", "NAME... | EXPR", "values in SI units, raw and format", HELP_EXPR, print},
        {"watch", "NAME...", "print them at each stop", "`unwatch` ends it.", watch},
        {"unwatch", "[NAME...]", "watch them no more; alone: none", "See `watch`.", unwatch},
        {"stages", "", "every intermediate of this tick, in order",
         "From the raw counts of the converter to the compare values, each in SI units and raw.\n"
         "In a recording the outputs have the recorded values beside them; a * marks another one.",
         stages},
        {"diff", "", "this tick computed again, beside double precision",
         "The tick is computed again. What a control module computes in it stands beside the same in\n"
         "double precision from the same inputs; each word that the tick has left, beside that of the\n"
         "tick computed again. A * marks what is farther apart than the roundings of one call. The last\n"
         "line names the first.",
         diff},
        {"set", "[NAME = VALUE]", "set it once, now; alone: list", HELP_SET, set_once},
        {"force", "NAME = VALUE", "set it in every tick from now on", HELP_SET, force},
        {"release", "NAME", "end what set and force do to it", HELP_SET, release},
        {"signals", "[PART]", "all signals with PART in their names", "Without PART: all.",
         signals},
        {"hash", "", "of the drive's whole state",
         "Equal hashes: the same state. It is that of recordings and of targets.", hash},
        {"help", "[COMMAND]", "this list, or more of one", "You have found it.", help},
        {"quit", "", "end the session", "So does the end of the input.", quit},
    };
    return table;
}

} // namespace

Answer execute(Session &session, const std::string &line)
{
    const std::string problem = utf8_problem(line);
    if (!problem.empty()) {
        return {Outcome::refused, problem + '\n'};
    }
    const auto [name, rest] = split(line.substr(0, line.find('#')));
    if (name.empty()) {
        return {Outcome::done, ""};
    }
    try {
        const Command &command = command_of(name);
        const std::string text = command.act(session, rest);
        return {name == "quit" ? Outcome::quit : Outcome::done, text};
    } catch (const std::runtime_error &error) {
        return {Outcome::refused,
                fmt::format("{}: {}\n", readable(name), readable(error.what(), READABLE_LINE))};
    }
}

std::vector<std::string> completions(const std::string &line_before, const std::string &word)
{
    std::vector<std::string> known;
    const std::string command = split(line_before).first;
    if (command.empty() || command == "help") {
        for (const Command &one : commands()) {
            known.emplace_back(one.name);
        }
    } else {
        known = all_words();
        for (const char *const keyword : {"until", "on", "fault", "state"}) {
            known.emplace_back(keyword);
        }
    }
    std::vector<std::string> found;
    std::copy_if(known.begin(), known.end(), std::back_inserter(found),
                 [&](const std::string &one) { return one.compare(0, word.size(), word) == 0; });
    return found;
}

} // namespace nf::debug
