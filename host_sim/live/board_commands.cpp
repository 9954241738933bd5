// SPDX-License-Identifier: MIT
#include "board_commands.h"

#include "about_text.h"
#include "answers.h"
#include "ends_with.h"
#include "fault_line.h"
#include "findings.h"
#include "found_fault.h"
#include "limit.h"
#include "line_reader.h"
#include "measured.h"
#include "names.h"
#include "numbers.h"
#include "output_file.h"
#include "readable.h"
#include "reader.h"
#include "run_recording.h"
#include "si.h"
#include "trimmed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

using debug::Answer;
using debug::Outcome;

constexpr double Q16 = 65536.0;
constexpr double Q28 = 268435456.0;
constexpr int DUMP_TRIES = 5;
constexpr double PASS_S = 0.02;         // between two looks at what has come
constexpr int DUMP_PASSES = 6000;       // 120 s: all its lines at 9600 baud
constexpr int DUMP_SILENT_PASSES = 100; // 2 s: the line that says its end is lost
constexpr int IDENTIFY_PASSES = 6500;   // 130 s; where a person interrupts, passes take no time
constexpr double WAIT_MAX_S = 86400;    // a day
constexpr double REST_S = 10;           // in which a rotor comes to rest
constexpr const char *MEASURED = "the motor is being measured; stop ends that";

// While the drive measures its motor.
bool goes_meanwhile(const std::string &word)
{
    constexpr std::array<const char *, 6> WORDS = {"stop", "status", "get", "wait", "help", "quit"};
    return std::any_of(WORDS.begin(), WORDS.end(), [&](const char *one) { return word == one; });
}

// The whole text as a finite number; nothing where it is none.
std::optional<double> number(const std::string &text)
{
    char *end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool good = !text.empty() && *end == '\0' && std::isfinite(value);
    return good ? std::optional<double>(value) : std::nullopt;
}

} // namespace

BoardCommands::BoardCommands(Follower &follower, const FileChoice &files, Surroundings surroundings)
    : follower_(follower), configuration_(follower, files), surroundings_(std::move(surroundings))
{
}

std::string BoardCommands::help()
{
    return "run, stop, clear        as on the board's console\n"
           "speed RPM               of the shaft\n"
           "position 1.5 | 540deg   of the shaft, in turns or degrees\n"
           "zero                    positions count from here on; in position mode the rotor stays here\n"
           "torque NM               of the motor, in N·m\n"
           "set KEY=VALUE ...       keys of motor, board or tuning file; all act from one tick on\n"
           "unlock                  at rest: the next configuration may protect less; after that it is locked again\n"
           "get [PART]              the settings in force, those with PART in their path\n"
           "dump FILE               the configuration in force as a block: `load`, `nfconfig show`\n"
           "load FILE               the block of a file becomes the one in force\n"
           "adopt [MOTOR]           the configuration of the files, with this motor's, becomes the one in force\n"
           "defaults                the image's own configuration becomes the one in force\n"
           "store                   the configuration in force survives the next start\n"
           "status                  what the drive does\n"
           "record FILE             the ticks that are kept, up to the last fault, for `motorsim replay`\n"
           "last FILE               what the black box has saved of the last fault or reset, for `motorsim replay`\n"
           "faults                  the log of the last faults and resets\n"
           "debug [SECONDS]         step through the last seconds, forwards and backwards\n"
           "identify [PLATE [FILE]] the drive measures its motor, that of a name plate too; into a new motor file\n"
           "wait SECONDS            before the next command\n"
           "quit";
}

// What the drive is told. The shadow may be older than the last command of this session; once it is
// not, it has also what the board has done by itself: a stop when nobody was heard, the words of a
// measurement.
std::optional<drive_command_t> BoardCommands::in_force() const
{
    const bool newer = commanded_in_ == follower_.connections() &&
                       follower_.now_s() < commanded_s_ + follower_.oldest_s();
    std::optional<drive_command_t> now = newer ? commanded_ : follower_.shadow().command();
    if (now) {
        now->request &= static_cast<uint8_t>(~(DRIVE_REQUEST_CLEAR | DRIVE_REQUEST_ZERO));
    }
    const bool measures = now && (now->request & DRIVE_REQUEST_PROBE) != 0;
    if (now && !measures && now->mode > DRIVE_MODE_TORQUE) {
        now = drive_command_t{0, DRIVE_MODE_SPEED, now->request}; // what a measurement left
    }
    return now;
}

void BoardCommands::remember(const std::optional<drive_command_t> &command)
{
    commanded_ = command;
    commanded_s_ = follower_.now_s();
    commanded_in_ = follower_.connections();
}

Answer BoardCommands::command(const drive_command_t &command)
{
    const std::string why = follower_.client().command(command);
    if (why.empty()) {
        remember(command);
    }
    return of_verdict(why);
}

// The command in force with something else in it.
Answer BoardCommands::amend(const std::function<void(drive_command_t &)> &change)
{
    std::optional<drive_command_t> wanted = in_force();
    if (!wanted) {
        return refused(fmt::format("not in step yet: {}; ask again",
                                   follower_.no_stream().empty()
                                       ? "what the drive is told is not known"
                                       : follower_.no_stream()));
    }
    if ((wanted->request & DRIVE_REQUEST_PROBE) != 0) {
        return refused(MEASURED);
    }
    change(*wanted);
    return command(*wanted);
}

// Also when the command in force is not known, or is a word of a measurement. Then the next one
// does not build on this one.
Answer BoardCommands::request(uint8_t what)
{
    const std::optional<drive_command_t> now = in_force();
    const bool known = now && (now->request & DRIVE_REQUEST_PROBE) == 0;
    drive_command_t wanted = known ? *now : drive_command_t{};
    wanted.request = what;
    const Answer answer = command(wanted);
    if (!known && answer.outcome == Outcome::done) {
        remember(std::nullopt);
    }
    return answer;
}

Answer BoardCommands::stop()
{
    const Answer answer = request(0);
    if (answer.outcome == Outcome::done && identification_) {
        identification_->stop();
    }
    return answer;
}

Answer BoardCommands::run()
{
    return amend([](drive_command_t &wanted) { wanted.request = DRIVE_REQUEST_RUN; });
}

Config BoardCommands::plate(const std::string &file)
{
    return configuration_.plate(file);
}

// The shadow does not know of the drive's command at once. A motor that runs would run on with the
// values of a name plate.
Answer BoardCommands::begin_identification(const std::string &file)
{
    if (runs()) {
        return refused("identify: the motor is asked to run; `stop` first");
    }
    const Config known = plate(file);
    Answer taken = file.empty() ? done() : configuration_.take_plate(known);
    if (taken.outcome != Outcome::done) {
        return taken;
    }
    (void)follower_.block_in_force(); // a change is taken before the board has made it
    identification_.emplace(known, follower_.now_s());
    identifies_in_ = follower_.connections();
    if (const std::string why = follower_.client().line("identify"); !why.empty()) {
        identification_.reset();
        return refused("identify: " + why);
    }
    remember(drive_command_t{0, DRIVE_MODE_SPEED, DRIVE_REQUEST_PROBE});
    return done();
}

// A board that was switched off and on knows nothing of it.
bool BoardCommands::identification_has_ended() const
{
    return !identification_ || identification_->has_ended(follower_.now_s()) ||
           identifies_in_ != follower_.connections();
}

bool BoardCommands::measures() const
{
    return !identification_has_ended();
}

MeasuredMotor BoardCommands::take_identification()
{
    if (!identification_) {
        throw ConfigError("no motor is being measured");
    }
    const Identification ended = std::move(*identification_);
    identification_.reset();
    return ended.found();
}

Answer BoardCommands::identify(const std::string &files)
{
    std::istringstream words(files);
    std::string plate;
    std::string path;
    std::string more;
    words >> plate >> path >> more;
    if (!more.empty()) {
        return refused(fmt::format("identify takes a name plate and a new file, found \"{}\" too",
                                   readable(more)));
    }
    if (path.empty()) {
        return identify(plate, nullptr);
    }
    if (is_there(path)) {
        return refused(readable(path, READABLE_PATH) +
                       ": is there already; identify takes the name of a new file");
    }
    OutputFile file(path);
    Answer answer = identify(plate, &file);
    if (answer.outcome == Outcome::done) {
        answer.text +=
            fmt::format("ok: `adopt {}` makes it the one in force, `store` keeps it", path);
    }
    return answer;
}

Answer BoardCommands::identify(const std::string &plate, OutputFile *file)
{
    Answer begun = begin_identification(plate);
    if (begun.outcome != Outcome::done) {
        return begun;
    }
    for (int pass = 0; measures() && pass < IDENTIFY_PASSES; pass++) {
        surroundings_.pass(PASS_S);
    }
    const MeasuredMotor motor = take_identification();
    if (file != nullptr) {
        file->write(motor.file_text());
        file->close();
    }
    return done(identify::table_text(motor.result, std::nullopt));
}

Answer BoardCommands::speed(const std::string &value)
{
    const std::optional<double> rpm = number(value);
    const int32_t most = follower_.about().speed_max_rpm;
    if (!rpm || std::abs(*rpm) > most) {
        return refused(
            fmt::format("speed takes rpm, {} to {}, found \"{}\"", -most, most, readable(value)));
    }
    return amend([&](drive_command_t &wanted) {
        wanted.mode = DRIVE_MODE_SPEED;
        wanted.target = static_cast<int32_t>(std::lround(follower_.bases().step_from_rpm(*rpm)));
    });
}

// At rest the board says whether it knows where the rotor is.
Answer BoardCommands::zero()
{
    if (!runs()) {
        return of_verdict(follower_.client().line("zero"));
    }
    return amend([](drive_command_t &wanted) {
        wanted.request |= static_cast<uint8_t>(DRIVE_REQUEST_ZERO);
        if (wanted.mode == DRIVE_MODE_POSITION) {
            wanted.target = 0;
        }
    });
}

Answer BoardCommands::position(const std::string &value)
{
    const bool degrees = debug::ends_with(value, "deg");
    const std::optional<double> found = number(degrees ? value.substr(0, value.size() - 3) : value);
    const double turn = degrees ? 360 : 1;
    const double most = follower_.bases().position_max_turns() * turn;
    if (!found || std::abs(*found) > most) {
        return refused(fmt::format(
            "position takes turns, or degrees as 90deg, {:.0f} to {:.0f}{}, found \"{}\"", -most,
            most, degrees ? " degrees" : " turns", readable(value)));
    }
    const double target = *found / turn * follower_.bases().pole_pairs * Q16;
    return amend([&](drive_command_t &wanted) {
        wanted.mode = DRIVE_MODE_POSITION;
        wanted.target = static_cast<int32_t>(std::lround(target));
    });
}

double BoardCommands::torque_max_nm()
{
    const drive_cfg_t cfg = follower_.block_in_force().cfg;
    return follower_.bases().torque_nm() / Q28 *
           current_reference_torque_max(&cfg.current_reference, &cfg.current_loop,
                                        cfg.derating.current_max);
}

Answer BoardCommands::torque(const std::string &value)
{
    const std::optional<double> found = number(value);
    const double most = torque_max_nm();
    if (!found || std::abs(*found) > most) {
        return refused(fmt::format("torque takes N·m, {}, found \"{}\"", limits_text(-most, most),
                                   readable(value)));
    }
    return amend([&](drive_command_t &wanted) {
        wanted.mode = DRIVE_MODE_TORQUE;
        wanted.target =
            static_cast<int32_t>(std::lround(*found / follower_.bases().torque_nm() * Q28));
    });
}

FileChoice BoardCommands::files_in_force()
{
    return configuration_.files_in_force();
}

// The flash is written at rest only: a motor that nobody drives any more is waited for.
Answer BoardCommands::store()
{
    const double until_s = follower_.now_s() + REST_S;
    std::string why = follower_.client().store();
    while (!why.empty() && !runs() && follower_.now_s() < until_s) {
        surroundings_.pass(PASS_S);
        why = follower_.client().store();
    }
    return of_verdict(why);
}

void BoardCommands::take_text(const std::string &characters)
{
    for (const char c : characters) {
        if (c != '\r' && c != '\n') {
            line_ += c;
        } else if (!line_.empty()) {
            take_line(std::exchange(line_, ""));
        }
    }
}

void BoardCommands::take_line(const std::string &line)
{
    if (identification_ && measures() && identification_->take(line)) {
        return;
    }
    const bool recorded = dumping_ && line.front() == RECORDER_LINE_MARK;
    if (recorded) {
        dump_ += line + '\n';
    } else if (dumping_ && line == "dump ends") {
        dump_ended_ = true;
    } else {
        surroundings_.say("board: " + readable(line, debug::LINE_READABLE));
    }
}

// Until its end, or until nothing comes any more.
bool BoardCommands::dump_once()
{
    dump_.clear();
    dump_ended_ = false;
    if (const std::string why = follower_.client().line("dump"); !why.empty()) {
        surroundings_.say("board: " + why);
        return false;
    }
    int silent = 0; // passes in a row without a line of it
    for (int pass = 0; !dump_ended_ && silent < DUMP_SILENT_PASSES && pass < DUMP_PASSES; pass++) {
        const std::size_t had = dump_.size();
        surroundings_.pass(PASS_S);
        silent = dump_.size() == had ? silent + 1 : 0;
    }
    return true;
}

// A line that is lost or damaged is not sent again: the whole dump is.
Answer BoardCommands::record_ring(OutputFile &file)
{
    std::string problem = "the board does not send it";
    dumping_ = true;
    for (int k = 0; k < DUMP_TRIES && !problem.empty(); k++) {
        try {
            if (dump_once()) {
                (void)replay::read(dump_);
                problem.clear();
            }
        } catch (const replay::RecordingError &error) {
            problem = error.what();
        }
    }
    dumping_ = false;
    if (!problem.empty()) {
        return refused("no recording: " + problem);
    }
    file.write(dump_);
    return done("ok: the board's ring");
}

// It takes some tenths of a second, and the board wants to hear somebody meanwhile.
Answer BoardCommands::record_shown(const RecordedRun &run, OutputFile &file)
{
    double passed_s = follower_.now_s();
    const replay::RunRecording recording =
        replay::recording_of(run, follower_.recorder_about(), [&] {
            if (follower_.now_s() - passed_s > PASS_S) {
                surroundings_.pass(PASS_S);
                passed_s = follower_.now_s();
            }
        });
    file.write(recording.text);
    return done(fmt::format("ok: {:.4g} s from tick {} on, up to {}",
                            static_cast<double>(recording.ticks) * run.image.bases.control_period_s,
                            recording.first,
                            recording.ends_in_fault ? "the last fault" : "the last tick shown"));
}

// While it is followed the board's ring does not stop at a fault: the ticks that were shown have
// it.
Answer BoardCommands::record(const std::string &path)
{
    constexpr std::size_t TICKS_MIN = 2;
    if (path.empty()) {
        return refused("record takes the name of a file");
    }
    OutputFile file(path);
    const std::optional<RecordedRun> run = follower_.shadow().run(follower_.kept_s());
    // A board that sends no ticks because it keeps a recording has what came after those that were
    // shown.
    const bool is_shown = follower_.no_stream().empty() && run && run->frames.size() >= TICKS_MIN;
    Answer answer = is_shown ? record_shown(*run, file) : record_ring(file);
    if (answer.outcome == Outcome::done) {
        file.close();
        answer.text += fmt::format(": `motorsim replay {}`", path);
    }
    return answer;
}

// As lines, so that it is the same file as that of a console.
Answer BoardCommands::last(const std::string &path)
{
    if (path.empty()) {
        return refused("last takes the name of a file");
    }
    std::vector<uint32_t> words = follower_.client().read_box(LINK_BOX_RECORDING);
    if (words.empty()) {
        return refused("no recording is saved");
    }
    OutputFile file(path);
    words.resize(std::size_t{recorder_lines(static_cast<uint32_t>(words.size()))} *
                 RECORDER_LINE_WORDS);
    std::string text;
    for (std::size_t at = 0; at < words.size(); at += RECORDER_LINE_WORDS) {
        std::array<char, RECORDER_LINE_CHARACTERS + 1> line{};
        recorder_line(static_cast<uint32_t>(at / RECORDER_LINE_WORDS), &words[at], line.data());
        text += line.data();
        text += '\n';
    }
    const replay::Recording recording = replay::read(text);
    file.write(text);
    file.close();
    return done(fmt::format("ok: ticks {} to {}: `motorsim replay {}`", recording.run.first(),
                            recording.last(), path));
}

Answer BoardCommands::wait(const std::string &seconds)
{
    const std::optional<double> time_s = number(seconds);
    if (!time_s || *time_s < 0 || *time_s > WAIT_MAX_S) {
        return refused(fmt::format("wait takes seconds, 0 to {:g}, found \"{}\"", WAIT_MAX_S,
                                   readable(seconds)));
    }
    surroundings_.pass(*time_s);
    return done();
}

Answer BoardCommands::step_through(const std::string &seconds)
{
    const std::optional<double> time_s = seconds.empty() ? follower_.kept_s() : number(seconds);
    if (!time_s || *time_s <= 0) {
        return refused(
            fmt::format("debug takes seconds, more than 0, found \"{}\"", readable(seconds)));
    }
    const std::optional<RecordedRun> run = follower_.shadow().run(*time_s);
    if (!run) {
        return refused("nothing to step through yet: not in step, or only just");
    }
    return surroundings_.stepper(*run) ? done() : refused("a command of the stepper was refused");
}

Answer BoardCommands::status() const
{
    return done(status_text(follower_));
}

Answer BoardCommands::execute(const std::string &line)
{
    if (const std::string problem = utf8_problem(line); !problem.empty()) {
        return refused(problem);
    }
    const std::string text = debug::trimmed(line);
    const std::size_t blank = text.find(' ');
    const std::string word = text.substr(0, blank);
    const std::string rest = blank == std::string::npos ? "" : debug::trimmed(text.substr(blank));
    const std::vector<std::pair<const char *, std::function<Answer()>>> table = {
        {"run", [this] { return run(); }},
        {"stop", [this] { return stop(); }},
        {"clear", [this] { return request(DRIVE_REQUEST_CLEAR); }},
        {"speed", [&] { return speed(rest); }},
        {"position", [&] { return position(rest); }},
        {"zero", [this] { return zero(); }},
        {"unlock", [this] { return of_verdict(follower_.client().line("unlock")); }},
        {"torque", [&] { return torque(rest); }},
        {"set", [&] { return configuration_.set(rest); }},
        {"get", [&] { return configuration_.get(rest); }},
        {"dump", [&] { return configuration_.dump(rest); }},
        {"load", [&] { return configuration_.load(rest); }},
        {"adopt", [&] { return configuration_.adopt(rest); }},
        {"defaults", [this] { return configuration_.defaults(); }},
        {"store", [this] { return store(); }},
        {"status", [this] { return status(); }},
        {"record", [&] { return record(rest); }},
        {"last", [&] { return last(rest); }},
        {"faults", [this] { return of_verdict(follower_.client().line("faults")); }},
        {"debug", [&] { return step_through(rest); }},
        {"identify", [&] { return identify(rest); }},
        {"wait", [&] { return wait(rest); }},
        {"help", [] { return done(help()); }},
        {"quit", [] { return Answer{Outcome::quit, ""}; }},
    };
    if (word.empty() || word[0] == '#') {
        return done();
    }
    if (measures() && !goes_meanwhile(word)) {
        return refused(MEASURED);
    }
    for (const auto &[name, action] : table) {
        if (word == name) {
            try {
                return action();
            } catch (const ConfigError &error) {
                return refused(error.what());
            } catch (const OutputError &error) {
                return refused(error.what());
            } catch (const LinkError &error) {
                return refused(error.what());
            } catch (const replay::RecordingError &error) {
                return refused(error.what());
            }
        }
    }
    return refused(fmt::format("no command \"{}\"; `help` lists them", readable(word)));
}

namespace
{

// What was asked for last is told only while the drive follows it.
std::string speed_text(const Simulation &sim)
{
    const drive_t &drive = sim.drive();
    const double rpm = sim.bases().rpm_from_step(drive_speed(&drive));
    if (!drive_knows_rotor(&drive)) {
        return "speed unknown";
    }
    if (!drive_is_controlled(drive.state)) {
        return fmt::format("speed {:.0f} rpm", rpm);
    }
    return fmt::format("speed {:.0f} of {:.0f} rpm", rpm,
                       sim.bases().rpm_from_step(drive.motion.speed_reference));
}

// Along θ̂; with open gates none is controlled, and nothing turns what is measured.
std::string current_text(const Simulation &sim)
{
    const dq_t current = measured_current(sim);
    return drive_is_controlled(sim.drive().state)
               ? fmt::format(", i_q {:.2f} A, i_d {:.2f} A",
                             current.q / Q15 * sim.bases().current_a,
                             current.d / Q15 * sim.bases().current_a)
               : "";
}

std::string drive_text(const Simulation &sim)
{
    return fmt::format("{}, {}{}, bus {:.1f} V", state_and_gates(sim.drive()), speed_text(sim),
                       current_text(sim), sim.drive().bus / Q15 * sim.bases().voltage_v);
}

std::string fault_advice(const Simulation &sim, const BoardSettings *board)
{
    if (sim.drive().state != DRIVE_STATE_FAULT) {
        return "";
    }
    const FoundFault fault = found_fault(sim.drive(), sim.bases());
    return fmt::format("; {}: {}", fault_measure(fault, sim.bases(), board), fault.advice);
}

} // namespace

std::string status_text(const Follower &follower)
{
    const Health &health = follower.health();
    const std::string drive = follower.shadow().is_in_step()
                                  ? drive_text(follower.shadow().sim()) +
                                        fault_advice(follower.shadow().sim(), follower.board())
                                  : "not in step";
    const std::string input =
        health.input_lost.empty() ? "" : ", the input is lost: " + health.input_lost;
    return fmt::format("{}, load {} %, late {}, gaps {}, by {}{}, last reset: {}{}", drive,
                       health.load_pct, health.late_ticks, follower.gaps().size(), health.source,
                       input, health.reset,
                       health.tick_lost ? ", THE CONTROL TICK STAYS AWAY" : "");
}

} // namespace nf::live
