// SPDX-License-Identifier: MIT
// The simulator's command line: run scenarios, step through them and through recordings, list what there is, measure
// speed.
// Exit status: 0 all limits hold or a recording is what it was, 1 not so, 2 wrong usage, wrong file or a file not written.
#include "bench.h"
#include "certificate_json.h"
#include "certificate_page.h"
#include "certificate_text.h"
#include "commands.h"
#include "completion.h"
#include "console.h"
#include "data_list.h"
#include "extremes.h"
#include "findings.h"
#include "injection.h"
#include "interrupt.h"
#include "live_command.h"
#include "measure.h"
#include "measured_file.h"
#include "motor_command.h"
#include "output_file.h"
#include "peer.h"
#include "plate.h"
#include "program.h"
#include "readable.h"
#include "reader.h"
#include "replace.h"
#include "replay.h"
#include "report.h"
#include "scenario.h"
#include "table.h"
#include "trace.h"
#include "vcd.h"
#include "whole_input.h"
#include "writer.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace
{

constexpr int LIMITS_HOLD = 0;
constexpr int LIMIT_BROKEN = 1;
constexpr const char *STDIN = "standard input";

constexpr const char *EXAMPLES = R"(Examples:
  motorsim list                              what can be run, and with which imperfections
  motorsim run s1                            metrics of scenario s1 beside their limits
  motorsim run s2 --with adc --with hot      the same drive with noisy sensors and a hot motor
  motorsim run s2 --set tuning=robust_motor_a        with another tuning file
  motorsim run s1 --set motor.inertia_kg_m2=0.006 --trace s1.csv --json s1.json
  motorsim run ./mine.toml --json - | jq .angle_error_max_deg
  motorsim run s2 --vcd s2.vcd --vcd-from 0.5 --vcd-to 0.51   every gate edge of 10 ms
  motorsim debug s1_robust                   step through a run, forwards and backwards
  motorsim run s1 --record s1.log            with the flight recorder, as the firmware sends it
  motorsim replay field.log                  run a recording again, check each tick; --debug steps
  motorsim live /dev/ttyACM0                 every signal of a running board, and commands to it
  motorsim bench                             simulation speed on this machine
  motorsim motor -o mine.toml                a motor file from a data sheet, with its units; asks for each value
  motorsim identify zoo:17:user -o mine.toml a simulated motor of which the drive knows the name plate
  motorsim identify --records console.log --motor plate.toml --board my_board.toml -o mine.toml
  motorsim certify mine.toml --board my_board.toml -o mine.html   how sure that drive is, within the error bars

Exit status: 0 all limits of the scenario hold, the recording comes out as it was, or all machines are locked; 1 one does
not, it departs, or not all are; 2 wrong usage or input.)";

// What is simulated.
struct Choice {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string motor;
    std::string board;

    nf::Config load() const;
};

// --motor and --board are short for --set.
nf::Config Choice::load() const
{
    std::vector<std::string> all = set;
    for (const auto &[key, value] : {std::pair("motor", motor), std::pair("board", board)}) {
        if (!value.empty()) {
            all.push_back(fmt::format("{}={}", key, value));
        }
    }
    return nf::load_scenario(scenario, with, all);
}

struct RunArguments : Choice {
    std::string estimator;
    std::string trace;
    bool trace_prelude = false;
    std::string json;
    std::string record;
    std::string extremes;
    std::string vcd;
    std::optional<double> vcd_from_s;
    std::optional<double> vcd_to_s;
};

struct DebugArguments : Choice {
    std::string script;
};

struct ReplayArguments {
    std::string file;
    bool debug = false;
    std::string script;
};

struct IdentifyArguments {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string motor;
    std::string board;
    std::string records;
    std::string output;
    std::string log;
    std::string json;
    bool overwrite = false;
    double temperature_c = 25;
};

struct CertifyArguments {
    std::string motor;
    std::string board;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::vector<std::string> tunings;
    int runs = 200;
    uint32_t seed = 1;
    std::string output;
    std::string json;
    bool overwrite = false;
};

struct BenchArguments {
    std::string scenario = "s1";
    int runs = 30;
    std::string json;
};

struct FileError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// What CLI11 asks of a file to write; empty where it is one.
std::string not_a_file(const std::string &name)
{
    return name.empty() ? "needs the name of a file" : "";
}

std::string not_a_trace_file(const std::string &name)
{
    return name == "-" ? "standard output is for the results" : not_a_file(name);
}

// Whether two names are of one file, which need not be there yet.
bool same_file(const std::filesystem::path &a, const std::filesystem::path &b)
{
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::equivalent(a, b, error)) {
        return true;
    }
    const fs::path one = fs::weakly_canonical(fs::absolute(a, error), error);
    return !error && one == fs::weakly_canonical(fs::absolute(b, error), error);
}

// A file of the command line, by its option; "" where it is not given.
struct NamedFile {
    const char *option;
    std::string path;
};
using NamedFiles = std::vector<NamedFile>;

bool is_same(const NamedFile &a, const NamedFile &b)
{
    return !a.path.empty() && !b.path.empty() && same_file(a.path, b.path);
}

// Nothing is written over what was read, by the configuration or as one of `inputs`, nor twice to the same file.
void check_outputs(const nf::Config &config, const NamedFiles &outputs,
                   const NamedFiles &inputs = {})
{
    for (auto output = outputs.begin(); output != outputs.end(); ++output) {
        nf::check_output(config, output->option, output->path);
        for (const NamedFile &input : inputs) {
            if (is_same(*output, input)) {
                throw FileError(fmt::format("{}: {} would replace what {} reads", output->path,
                                            output->option, input.option));
            }
        }
        for (auto before = outputs.begin(); before != output; ++before) {
            if (is_same(*before, *output)) {
                throw FileError(fmt::format("{}: {} and {} cannot go to the same file",
                                            before->path, before->option, output->option));
            }
        }
    }
}

// A line on a terminal that shows how far a run is; nothing where stderr is no terminal.
std::function<void(double)> progress_line()
{
    if (isatty(STDERR_FILENO) == 0) {
        return {};
    }
    return [shown = 0](double done) mutable {
        const int percent = static_cast<int>(done * 100.0);
        if (percent != shown) {
            fmt::print(stderr, "\r{:<6}\r", done < 1 ? fmt::format("{} %", percent) : "");
            shown = percent;
        }
    };
}

// Of so many runs that they take a while; where stderr is no terminal, a line for each quarter.
std::function<void(double)> progress_of_runs(int runs)
{
    constexpr int WHILE = 100;
    if (isatty(STDERR_FILENO) != 0 || runs < WHILE) {
        return progress_line();
    }
    return [runs, shown = 0](double done) mutable {
        constexpr int PARTS = 4;
        const int parts = static_cast<int>(done * PARTS);
        if (parts != shown && parts < PARTS) {
            fmt::print(stderr, "motorsim: {} of {} runs\n", runs * parts / PARTS, runs);
        }
        shown = parts;
    };
}

// What is written of each tick.
class Outputs : public nf::TickSink
{
public:
    Outputs(const RunArguments &arguments, const nf::Config &config)
    {
        if (!arguments.trace.empty()) {
            trace_ = std::make_unique<nf::Trace>(arguments.trace, arguments.trace_prelude);
        }
        if (!arguments.vcd.empty()) {
            const nf::TimeWindow window = {arguments.vcd_from_s.value_or(0.0),
                                           arguments.vcd_to_s.value_or(config.scenario.duration_s)};
            vcd_ = std::make_unique<nf::Vcd>(arguments.vcd, window);
        }
        if (!arguments.record.empty()) {
            record_ = std::make_unique<nf::replay::Writer>(config);
            record_path_ = arguments.record;
        }
        if (!arguments.extremes.empty()) {
            extremes_ = std::make_unique<nf::Extremes>();
            extremes_path_ = arguments.extremes;
        }
    }

    bool any() const
    {
        return trace_ != nullptr || vcd_ != nullptr || record_ != nullptr || extremes_ != nullptr;
    }

    void add(const nf::Tick &tick) override
    {
        if (trace_) {
            trace_->add(tick);
        }
        if (vcd_) {
            vcd_->add(tick);
        }
        if (record_) {
            record_->add(tick);
        }
        if (extremes_) {
            extremes_->add(tick);
        }
    }

    void close()
    {
        if (trace_) {
            trace_->close();
        }
        if (vcd_) {
            vcd_->close();
        }
        if (record_) {
            nf::write_text(record_path_, record_->text());
        }
        if (extremes_) {
            nf::write_text(extremes_path_, extremes_->json_text());
        }
    }

private:
    std::unique_ptr<nf::Trace> trace_;
    std::unique_ptr<nf::Vcd> vcd_;
    std::unique_ptr<nf::replay::Writer> record_;
    std::string record_path_;
    std::unique_ptr<nf::Extremes> extremes_;
    std::string extremes_path_;
};

void check_window(const RunArguments &arguments)
{
    const bool window = arguments.vcd_from_s || arguments.vcd_to_s;
    if (window && arguments.vcd.empty()) {
        throw FileError("--vcd-from and --vcd-to need --vcd FILE");
    }
    for (const auto &[option, time_s] : {std::pair("--vcd-from", arguments.vcd_from_s),
                                         std::pair("--vcd-to", arguments.vcd_to_s)}) {
        if (time_s && !std::isfinite(*time_s)) {
            throw FileError(
                fmt::format("{} is a finite number of seconds, found {}", option, *time_s));
        }
    }
    if (arguments.vcd_from_s && arguments.vcd_to_s && *arguments.vcd_from_s > *arguments.vcd_to_s) {
        throw FileError(fmt::format("--vcd-from {:g} is after --vcd-to {:g}", *arguments.vcd_from_s,
                                    *arguments.vcd_to_s));
    }
}

// The estimator of the command line in place of the drive's own, if there is one; the run's notes name it.
std::function<void(drive_t &)> replace_observer(const RunArguments &arguments, nf::Config &config)
{
    if (arguments.estimator.empty()) {
        return {};
    }
    if (!arguments.record.empty()) {
        throw FileError("--record needs the drive's own observer: a replay knows no --estimator");
    }
    nf::peers::Tuned tuned = nf::peers::load("--estimator", arguments.estimator);
    config.scenario.notes.push_back(
        fmt::format("{} in place of the drive's observer", tuned.peer->title));
    return nf::peers::in_place_of_the_observer(config, std::move(tuned.estimator));
}

int run(const RunArguments &arguments)
{
    nf::Config config = arguments.load();
    check_outputs(config, {{"--trace", arguments.trace},
                           {"--json", arguments.json},
                           {"--vcd", arguments.vcd},
                           {"--record", arguments.record},
                           {"--extremes", arguments.extremes}});
    check_window(arguments);
    Outputs outputs(arguments, config);
    nf::RunOptions options;
    options.progress = progress_line();
    options.sink = outputs.any() ? &outputs : nullptr;
    options.estimate = replace_observer(arguments, config);
    const nf::RunResult result = nf::run_scenario(config, options);
    outputs.close();
    if (arguments.json.empty()) {
        nf::write_text("-", nf::table_text(config, result));
    } else {
        nf::write_text(arguments.json, nf::json_text(config, result));
    }
    const std::vector<nf::Violation> broken = nf::violations(config, result);
    for (const nf::Violation &violation : broken) {
        fmt::print(stderr, "{}: {}\n", config.scenario.id, violation.text());
    }
    return broken.empty() ? LIMITS_HOLD : LIMIT_BROKEN;
}

int converse(nf::debug::Session &session, nf::debug::LineReader &reader)
{
    return nf::debug::converse(session, reader, stdout) ? LIMITS_HOLD : nf::BAD_INPUT;
}

// Commands of a file, of a pipe, or of a person. `-` is a pipe, also where a person types.
int converse(nf::debug::Session &session, const std::string &script)
{
    const bool piped = script == "-";
    if (!script.empty() && !piped) {
        const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(
            fdopen(nf::open_input(script), "rb"), std::fclose);
        return converse(session, *nf::debug::stream_reader(file.get(), stdout, script));
    }
    nf::check_standard_input();
    const bool person = !piped && isatty(STDIN_FILENO) != 0;
    return converse(session, person ? *nf::debug::terminal_reader(nf::debug::completions)
                                    : *nf::debug::stream_reader(stdin, stdout, STDIN));
}

int debug(const DebugArguments &arguments)
{
    const nf::Config config = arguments.load();
    nf::debug::Session session(config);
    return converse(session, arguments.script);
}

int debug_recording(const nf::replay::Recording &recording, const nf::replay::Result &result,
                    const ReplayArguments &arguments)
{
    nf::debug::Session session(recording.run,
                               std::filesystem::path(arguments.file).filename().string());
    session.timeline.go_to(nf::replay::tick_of_interest(recording, result));
    return converse(session, arguments.script);
}

int replay(const ReplayArguments &arguments)
{
    if (!arguments.script.empty() && !arguments.debug) {
        throw FileError("--script needs --debug");
    }
    const nf::replay::Recording recording = nf::replay::read_file(arguments.file);
    const nf::replay::Result result = nf::replay::replay(recording);
    nf::write_text("-", nf::replay::summary(recording, result));
    const int done = arguments.debug ? debug_recording(recording, result, arguments) : LIMITS_HOLD;
    return done == LIMITS_HOLD && result.difference ? LIMIT_BROKEN : done;
}

int signals(const Choice &choice)
{
    nf::write_text("-", nf::debug::table_json(choice.load()));
    return LIMITS_HOLD;
}

int estimators()
{
    nlohmann::ordered_json json;
    for (const nf::peers::Peer &peer : nf::peers::all()) {
        nlohmann::ordered_json &entry = json[peer.name];
        entry["title"] = peer.title;
        for (const nf::peers::Gain &gain : peer.gains) {
            entry["gain"][gain.name] = {{"min", gain.min}, {"max", gain.max}, {"help", gain.help}};
        }
    }
    nf::write_text("-", json.dump(2) + '\n');
    return LIMITS_HOLD;
}

int list()
{
    nf::write_text("-", nf::data_list_text());
    return LIMITS_HOLD;
}

int bench(const BenchArguments &arguments)
{
    const nf::Config config = nf::load_scenario(arguments.scenario);
    nf::check_output(config, "--json", arguments.json);
    const nf::BenchResult b = nf::bench(config, arguments.runs);
    if (!arguments.json.empty()) {
        const nlohmann::ordered_json json = {
            {"scenario", b.scenario},
            {"runs", b.runs},
            {"ticks", b.ticks},
            {"simulated_s", b.simulated_s},
            {"real_time_factor_best", b.real_time_best},
            {"real_time_factor_median", b.real_time_median},
            {"tick_best_ns", b.best_ns},
            {"tick_median_ns", b.median_ns},
            {"plant_ns", b.plant_ns},
            {"drive_ns", b.drive_ns},
        };
        nf::write_text(arguments.json, json.dump(2) + '\n');
        return LIMITS_HOLD;
    }
    nf::write_text("-",
                   fmt::format("{}: {} ticks = {:g} s simulated, {} runs, one core\n"
                               "  best    {:7.1f} x real time  {:6.1f} ns per tick\n"
                               "  median  {:7.1f} x real time  {:6.1f} ns per tick\n"
                               "  of the best: plant {:.1f} ns, drive {:.1f} ns, rest {:.1f} ns\n",
                               b.scenario, b.ticks, b.simulated_s, b.runs, b.real_time_best,
                               b.best_ns, b.real_time_median, b.median_ns, b.plant_ns, b.drive_ns,
                               b.best_ns - b.plant_ns - b.drive_ns));
    return LIMITS_HOLD;
}

std::string joined(const std::vector<std::string> &lines)
{
    std::string text;
    for (const std::string &line : lines) {
        text += line + '\n';
    }
    return text;
}

// What has been measured goes to the files that were asked for, and to the screen.
void show(const IdentifyArguments &arguments, const nf::identify::Result &result,
          const std::optional<nf::identify::Truth> &truth, double duration_s,
          const std::string &head)
{
    if (!arguments.output.empty()) {
        nf::write_text(arguments.output,
                       nf::measured_motor_file(result.motor, result.measured, head));
    }
    if (arguments.json.empty()) {
        nf::write_text("-", nf::identify::table_text(result, truth));
    } else {
        nf::write_text(arguments.json, nf::identify::json_text(result, truth, duration_s));
    }
}

void check_new(const std::string &output, bool overwrite)
{
    if (!overwrite && !output.empty() && nf::is_there(output)) {
        throw FileError(fmt::format("{}: is there already; --overwrite replaces it",
                                    nf::readable(output, nf::READABLE_PATH)));
    }
}

// Of what takes a while: what cannot be written is said before it.
void check_writable(const std::vector<std::string> &paths)
{
    for (const std::string &path : paths) {
        if (!path.empty() && path != "-") {
            nf::OutputFile{path};
        }
    }
}

// What is written is no file that was read, and can be.
void check_findings(const IdentifyArguments &arguments, const nf::Config &config)
{
    check_new(arguments.output, arguments.overwrite);
    check_outputs(
        config,
        {{"--output", arguments.output}, {"--json", arguments.json}, {"--log", arguments.log}},
        {{"--records", arguments.records}});
    check_writable({arguments.output, arguments.log, arguments.json});
}

int identify_records(const IdentifyArguments &arguments)
{
    if (!arguments.log.empty() || !arguments.with.empty()) {
        throw FileError("--log and --with are for a simulated motor; --records is of a real one");
    }
    if (arguments.motor.empty() || arguments.board.empty()) {
        throw FileError(
            "--records needs the name plate, --motor FILE, and the board, --board FILE");
    }
    const nf::Config plate = nf::load_plate(arguments.motor, arguments.board, {}, arguments.set);
    check_findings(arguments, plate);
    const nf::identify::Records records = nf::identify::read_records_file(arguments.records);
    show(arguments, nf::identify::evaluate(records, plate, arguments.temperature_c), std::nullopt,
         records.duration_s,
         fmt::format("Measured by the drive, of the records {}.", arguments.records));
    return LIMITS_HOLD;
}

// What a person sees meanwhile: each phase before it begins. No record, and not how it ends.
void show_phase(const std::string &line)
{
    const bool phase = line.rfind("= ", 0) != 0 && line.rfind("identify ", 0) != 0;
    if (phase && isatty(STDERR_FILENO) != 0) {
        fmt::print(stderr, "{}\n", line);
    }
}

// So that a fault may come at any time of it.
constexpr const char *LONGEST_IDENTIFICATION = "scenario.duration_s=130";

// The drive commands itself, and its shaft is free. Faults act, from power-up on; what else the scenario's file has is of its
// run.
void check_measurable(const std::vector<std::string> &set)
{
    for (const char *const list : {"command", "load", "request", "load_scale", "mode"}) {
        const std::string key = fmt::format("scenario.{}=", list);
        for (const std::string &text : set) {
            if (text.rfind(key, 0) == 0) {
                throw FileError(fmt::format(
                    "--set {}: an identification has no {} of a scenario: the drive commands itself "
                    "with a free shaft; allowed: scenario.fault, times from power-up on, and any "
                    "other table",
                    text, list));
            }
        }
    }
}

int identify_simulated(const IdentifyArguments &arguments)
{
    Choice choice = {arguments.scenario, arguments.with, arguments.set, arguments.motor,
                     arguments.board};
    check_measurable(arguments.set);
    choice.set.insert(choice.set.begin(), LONGEST_IDENTIFICATION);
    const nf::Config config = choice.load();
    const nf::Config plate = nf::known_from_plate(config);
    check_findings(arguments, config);
    nf::Simulation sim(config, nf::with_typical(plate));
    nf::Injection injection(config, sim.bases().control_period_s, 0);
    const nf::identify::Measurement found =
        nf::identify::measure(sim, show_phase, [&, tick = int64_t{0}](nf::Simulation &now) mutable {
            injection.act(tick++, now);
        });
    if (!arguments.log.empty()) {
        nf::write_text(arguments.log, joined(found.lines));
    }
    if (!found.refusal.empty()) {
        fmt::print(stderr, "identify refused: {}\n", found.refusal);
        return LIMIT_BROKEN;
    }
    const nf::identify::Records records = nf::identify::read_records(found.lines, "the console");
    show(arguments, nf::identify::evaluate(records, plate, arguments.temperature_c),
         nf::identify::truth_of(config), found.duration_s,
         fmt::format("Measured by the drive in {:.0f} s, on the simulated motor of {}.",
                     found.duration_s, arguments.scenario));
    return LIMITS_HOLD;
}

int identify(const IdentifyArguments &arguments)
{
    if (arguments.scenario.empty() == arguments.records.empty()) {
        throw FileError("name a scenario, whose motor is simulated, or --records FILE of a board");
    }
    return arguments.records.empty() ? identify_simulated(arguments) : identify_records(arguments);
}

std::vector<std::string> overrides_of(const CertifyArguments &arguments)
{
    std::vector<std::string> set = {"motor=" + arguments.motor};
    if (!arguments.board.empty()) {
        set.push_back("board=" + arguments.board);
    }
    set.insert(set.end(), arguments.set.begin(), arguments.set.end());
    return set;
}

void check_certificate(const CertifyArguments &arguments, const nf::Config &config)
{
    check_new(arguments.output, arguments.overwrite);
    check_outputs(config, {{"--output", arguments.output}, {"--json", arguments.json}});
    check_writable({arguments.output, arguments.json});
}

// Stopped by Ctrl-C it is of the runs so far.
void run_campaign(nf::certify::Campaign &campaign, const CertifyArguments &arguments)
{
    const nf::debug::InterruptWatch watch;
    nf::certify::run(campaign, arguments.runs, arguments.seed,
                     {progress_of_runs(arguments.runs), nf::debug::was_interrupted});
    if (campaign.points.empty()) {
        throw FileError("stopped before the first run");
    }
}

int certify(const CertifyArguments &arguments)
{
    const std::vector<std::string> shipped = {nf::DEFAULT_TUNING};
    nf::certify::Campaign campaign =
        nf::certify::plan(arguments.tunings.empty() ? shipped : arguments.tunings, arguments.with,
                          overrides_of(arguments));
    check_certificate(arguments, campaign.series.front().believed);
    run_campaign(campaign, arguments);
    const nf::certify::Judgement judgement = nf::certify::judge(campaign);
    if (!arguments.output.empty()) {
        nf::write_text(arguments.output, nf::certify::page_of(campaign, judgement));
    }
    if (arguments.json.empty()) {
        nf::write_text("-", nf::certify::text_of(campaign, judgement));
    } else {
        nf::write_text(arguments.json, nf::certify::json_of(campaign, judgement));
    }
    const nf::certify::Summary &best = judgement.summaries[judgement.best];
    return best.locked == best.runs ? LIMITS_HOLD : LIMIT_BROKEN;
}

void describe_with(CLI::App &command, std::vector<std::string> &with)
{
    command.add_option("--with", with, "imperfection set, name or path; may be repeated")
        ->allow_extra_args(false)
        ->type_name(nf::AN_IMPERFECTION);
}

void describe_set(CLI::App &command, std::vector<std::string> &set)
{
    command.add_option("--set", set, "override a setting; may be repeated")
        ->allow_extra_args(false)
        ->type_name(nf::A_SETTING);
}

void describe_board(CLI::App &command, std::string &board, const char *help)
{
    command.add_option("--board", board, help)->type_name(nf::A_BOARD);
}

void describe_choice(CLI::App &command, Choice &arguments)
{
    command
        .add_option("scenario", arguments.scenario, "name (see `motorsim list`) or path of a .toml")
        ->required()
        ->type_name(nf::A_SCENARIO);
    describe_with(command, arguments.with);
    command
        .add_option("--motor", arguments.motor,
                    "another motor, by name or path; zoo:17 brings its board along")
        ->type_name(nf::A_MOTOR);
    describe_board(command, arguments.board, "another board, by name or path");
    describe_set(command, arguments.set);
}

void describe_run(CLI::App &command, RunArguments &arguments)
{
    describe_choice(command, arguments);
    command
        .add_option(
            "--estimator", arguments.estimator,
            "in place of the drive's observer: a name of `motorsim estimators`, or a file of gains")
        ->check(not_a_file, "");
    command.add_option("--trace", arguments.trace, "write all signals of every tick as CSV")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_flag("--trace-prelude", arguments.trace_prelude, "trace the time before t = 0 too");
    command.add_option("--json", arguments.json, "write the metrics as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
    command
        .add_option("--record", arguments.record,
                    "write what the flight recorder holds after the first fault, or at the end")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command
        .add_option("--extremes", arguments.extremes,
                    "write the smallest and largest value of each of the drive's signals as JSON")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_option("--vcd", arguments.vcd, "write states, signals and gate edges as VCD")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_option("--vcd-from", arguments.vcd_from_s, "first tick of it, s; else t = 0")
        ->type_name("TIME");
    command.add_option("--vcd-to", arguments.vcd_to_s, "last tick of it, s; else the end")
        ->type_name("TIME");
}

void describe_script(CLI::App &command, std::string &script)
{
    command
        .add_option("--script", script,
                    "commands from a file; - is standard input; status 2 when one fails")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

void describe_debug(CLI::App &command, DebugArguments &arguments)
{
    describe_choice(command, arguments);
    describe_script(command, arguments.script);
}

void describe_replay(CLI::App &command, ReplayArguments &arguments)
{
    command
        .add_option("file", arguments.file,
                    "a recording: what the console's `dump` sent, as it was logged")
        ->required();
    command.add_flag("--debug", arguments.debug,
                     "step through it, beginning where it departs, else at the fault");
    describe_script(command, arguments.script);
}

void describe_identify(CLI::App &command, IdentifyArguments &arguments)
{
    command
        .add_option(
            "scenario", arguments.scenario,
            "whose motor, board and imperfections are simulated; the drive knows the name plate only")
        ->type_name(nf::A_SCENARIO);
    describe_with(command, arguments.with);
    command
        .add_option("--motor", arguments.motor,
                    "another motor; with --records the name plate, by name or path")
        ->type_name(nf::A_MOTOR);
    describe_board(command, arguments.board, "another board, by name or path");
    describe_set(command, arguments.set);
    command
        .add_option("--records", arguments.records,
                    "what a board's console has sent after `identify`")
        ->check(not_a_file, "")
        ->type_name("FILE");
    command.add_option("-o,--output", arguments.output, "write the motor file")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_flag("--overwrite", arguments.overwrite, "even if it is there already");
    command.add_option("--log", arguments.log, "write the console's lines, records among them")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command
        .add_option("--json", arguments.json, "write values and bars as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
    command
        .add_option("--temperature", arguments.temperature_c, "of the winding meanwhile, degrees C")
        ->capture_default_str()
        ->check(CLI::Range(-50.0, 250.0));
}

constexpr const char *CERTIFY_HELP =
    R"(Each run has another machine: every value is drawn within its error bar, those of the board within its tolerances,
and load and rotor angle within what the machine is used for. The drive believes the files. It starts, runs at half and at
rated speed, takes a load on and off, and reverses. [measured] of the motor file has the error bars, as identify leaves
them; for what it does not say, typical ones are taken, and the output says which.

Examples:
  motorsim certify mine.toml --board my_board.toml           table, and which value to measure better
  motorsim certify mine.toml --board my_board.toml -o mine.html   the same with a map, for a browser
  motorsim certify zoo:17 --tuning any --runs 1000           one tuning, more runs: a stronger statement
  motorsim certify motor_a --set plant.cogging_pct=3         with what no draw varies

Exit status: 0 all machines are locked with the recommended tuning, 1 not all, 2 wrong usage or input.)";

void describe_certify(CLI::App &command, CertifyArguments &arguments)
{
    command.footer(CERTIFY_HELP);
    command
        .add_option("motor", arguments.motor,
                    "motor file, by name or path; zoo:17 brings its board along")
        ->required()
        ->type_name(nf::A_MOTOR);
    describe_board(command, arguments.board, "board, by name or path; else bench_310v");
    command
        .add_option("--tuning", arguments.tunings,
                    "tuning to try, by name or path; may be repeated; else the default, any")
        ->allow_extra_args(false)
        ->type_name(nf::A_TUNING);
    describe_with(command, arguments.with);
    describe_set(command, arguments.set);
    command.add_option("--runs", arguments.runs, "machines, the same ones for each tuning")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    command.add_option("--seed", arguments.seed, "another seed is another sample of machines")
        ->capture_default_str();
    command.add_option("-o,--output", arguments.output, "write the page, HTML")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_flag("--overwrite", arguments.overwrite, "even if it is there already");
    command
        .add_option("--json", arguments.json,
                    "write everything, each run too, as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

void describe_bench(CLI::App &command, BenchArguments &arguments)
{
    command.add_option("scenario", arguments.scenario, "scenario to time")
        ->capture_default_str()
        ->type_name(nf::A_SCENARIO);
    command.add_option("--runs", arguments.runs, "how often")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    command.add_option("--json", arguments.json, "write the figures as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

// All commands with their arguments, and what each does.
struct Commands {
    explicit Commands(CLI::App &app);
    int chosen() const;

private:
    // The entry of a new command.
    CLI::App &add(CLI::App &app, const char *name, const char *help, std::function<int()> action)
    {
        CLI::App &command = *app.add_subcommand(name, help);
        actions_.emplace_back(&command, std::move(action));
        return command;
    }

    RunArguments run_;
    DebugArguments debug_;
    Choice signals_;
    ReplayArguments replay_;
    IdentifyArguments identify_;
    CertifyArguments certify_;
    BenchArguments bench_;
    nf::live::LiveArguments live_;
    nf::sheet::MotorArguments motor_;
    std::vector<std::pair<const CLI::App *, std::function<int()>>> actions_;
};

Commands::Commands(CLI::App &app)
{
    describe_run(add(app, "run", "run a scenario and judge it", [this] { return run(run_); }),
                 run_);
    describe_debug(add(app, "debug", "step through a scenario, forwards and backwards",
                       [this] { return debug(debug_); }),
                   debug_);
    describe_choice(add(app, "signals",
                        "the firmware's words with formats and scales, as JSON for debuggers",
                        [this] { return signals(signals_); }),
                    signals_);
    describe_replay(add(app, "replay", "run a flight recorder's recording again",
                        [this] { return replay(replay_); }),
                    replay_);
    nf::sheet::describe(add(app, "motor",
                            "turn the values of a data sheet, with their units, into a motor file",
                            [this] {
                                nf::sheet::write_motor(motor_);
                                return LIMITS_HOLD;
                            }),
                        motor_);
    describe_identify(add(app, "identify", "measure a motor of which only the name plate is known",
                          [this] { return identify(identify_); }),
                      identify_);
    describe_certify(add(app, "certify", "how sure a drive is, within all error bars",
                         [this] { return certify(certify_); }),
                     certify_);
    nf::live::describe(add(app, "live", "follow a running board: all signals of every tick",
                           [this] { return nf::live::live(live_) ? LIMITS_HOLD : LIMIT_BROKEN; }),
                       live_);
    add(app, "list", "list scenarios and imperfections", list);
    add(app, "estimators", "what `run --estimator` knows, with its gains, as JSON", estimators);
    describe_bench(
        add(app, "bench", "measure the simulation speed", [this] { return bench(bench_); }),
        bench_);
}

int Commands::chosen() const
{
    const auto found = std::find_if(actions_.begin(), actions_.end(),
                                    [](const auto &action) { return bool(*action.first); });
    return found->second();
}

int parse_and_do(int argc, char **argv)
{
    CLI::App app{"Simulates a motor, its inverter and the drive's firmware, tick by tick.",
                 "motorsim"};
    const Commands commands(app);
    app.footer(EXAMPLES);
    if (const std::optional<int> status = nf::parse(app, argc, argv)) {
        return *status;
    }
    return commands.chosen();
}

} // namespace

int main(int argc, char **argv)
{
    return nf::guarded("motorsim", parse_and_do, argc, argv);
}
