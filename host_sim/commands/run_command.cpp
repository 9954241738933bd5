// SPDX-License-Identifier: MIT
#include "run_command.h"

#include "ending.h"
#include "extremes.h"
#include "peer.h"
#include "program.h"
#include "progress.h"
#include "replace.h"
#include "report.h"
#include "scenario_run.h"
#include "trace.h"
#include "vcd.h"
#include "writer.h"
#include "written_files.h"

#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace nf::commands
{
namespace
{

// What is written of each tick.
class Outputs : public TickSink
{
public:
    Outputs(const RunArguments &arguments, const Config &config)
    {
        if (!arguments.trace.empty()) {
            trace_ = std::make_unique<Trace>(arguments.trace, arguments.trace_prelude);
        }
        if (!arguments.vcd.empty()) {
            const TimeWindow window = {arguments.vcd_from_s.value_or(0.0),
                                       arguments.vcd_to_s.value_or(config.scenario.duration_s)};
            vcd_ = std::make_unique<Vcd>(arguments.vcd, window);
        }
        if (!arguments.record.empty()) {
            record_ = std::make_unique<replay::Writer>(config);
            record_path_ = arguments.record;
        }
        if (!arguments.extremes.empty()) {
            extremes_ = std::make_unique<Extremes>();
            extremes_path_ = arguments.extremes;
        }
    }

    bool any() const
    {
        return trace_ != nullptr || vcd_ != nullptr || record_ != nullptr || extremes_ != nullptr;
    }

    void add(const Tick &tick) override
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
            write_text(record_path_, record_->text());
        }
        if (extremes_) {
            write_text(extremes_path_, extremes_->json_text());
        }
    }

private:
    std::unique_ptr<Trace> trace_;
    std::unique_ptr<Vcd> vcd_;
    std::unique_ptr<replay::Writer> record_;
    std::string record_path_;
    std::unique_ptr<Extremes> extremes_;
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

// The estimator of the command line in place of the drive's own, if there is one; the run's notes
// name it.
std::function<void(drive_t &, const sample_t &)> replace_observer(const RunArguments &arguments,
                                                                  Config &config)
{
    if (arguments.estimator.empty()) {
        return {};
    }
    if (!arguments.record.empty()) {
        throw FileError("--record needs the drive's own observer: a replay knows no --estimator");
    }
    peers::Tuned tuned = peers::load("--estimator", arguments.estimator);
    config.scenario.notes.push_back(
        fmt::format("{} in place of the drive's observer", tuned.peer->title));
    return peers::in_place_of_the_observer(config, std::move(tuned.estimator));
}

} // namespace

int run(const RunArguments &arguments)
{
    Config config = arguments.load();
    check_outputs(config, {{"--trace", arguments.trace},
                           {"--json", arguments.json},
                           {"--vcd", arguments.vcd},
                           {"--record", arguments.record},
                           {"--extremes", arguments.extremes}});
    check_window(arguments);
    Outputs outputs(arguments, config);
    RunOptions options;
    options.progress = progress_line();
    options.sink = outputs.any() ? &outputs : nullptr;
    options.estimate = replace_observer(arguments, config);
    const RunResult result = run_scenario(config, options);
    outputs.close();
    if (arguments.json.empty()) {
        write_text("-", table_text(config, result));
    } else {
        write_text(arguments.json, json_text(config, result));
    }
    const std::vector<Violation> broken = violations(config, result);
    for (const Violation &violation : broken) {
        fmt::print(stderr, "{}: {}\n", config.scenario.id, violation.text());
    }
    return broken.empty() ? LIMITS_HOLD : LIMIT_BROKEN;
}

void describe(CLI::App &command, RunArguments &arguments)
{
    describe(command, static_cast<Choice &>(arguments));
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
        .add_option(
            "--extremes", arguments.extremes,
            "write the smallest and largest value of the drive's voltages, references and outputs as JSON")
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

} // namespace nf::commands
