// SPDX-License-Identifier: MIT
#include "identify_command.h"

#include "choice.h"
#include "completion.h"
#include "ending.h"
#include "findings.h"
#include "injection.h"
#include "measure.h"
#include "measured_file.h"
#include "plate.h"
#include "program.h"
#include "written_files.h"

#include <cstdio>
#include <optional>

#include <unistd.h>

#include <fmt/format.h>

namespace nf::commands
{
namespace
{

std::string joined(const std::vector<std::string> &lines)
{
    std::string text;
    for (const std::string &line : lines) {
        text += line + '\n';
    }
    return text;
}

// What has been measured goes to the files that were asked for, and to the screen.
void show(const IdentifyArguments &arguments, const identify::Result &result,
          const std::optional<identify::Truth> &truth, double duration_s, const std::string &head)
{
    if (!arguments.output.empty()) {
        write_text(arguments.output, measured_motor_file(result.motor, result.measured, head));
    }
    if (arguments.json.empty()) {
        write_text("-", identify::table_text(result, truth));
    } else {
        write_text(arguments.json, identify::json_text(result, truth, duration_s));
    }
}

// What is written is no file that was read, and can be.
void check_findings(const IdentifyArguments &arguments, const Config &config)
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
    const Config plate = load_plate(arguments.motor, arguments.board, {}, arguments.set);
    check_findings(arguments, plate);
    const identify::Records records = identify::read_records_file(arguments.records);
    show(arguments, identify::evaluate(records, plate, arguments.temperature_c), std::nullopt,
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

// The drive commands itself, and its shaft is free. Faults act, from power-up on; what else the
// scenario's file has is of its run.
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
    const Config config = choice.load();
    const Config plate = known_from_plate(config);
    check_findings(arguments, config);
    Simulation sim(config, with_typical(plate));
    Injection injection(config, sim.bases().control_period_s, 0);
    const identify::Measurement found =
        identify::measure(sim, show_phase, [&, tick = int64_t{0}](Simulation &now) mutable {
            injection.act(tick++, now);
        });
    if (!arguments.log.empty()) {
        write_text(arguments.log, joined(found.lines));
    }
    if (!found.refusal.empty()) {
        fmt::print(stderr, "identify refused: {}\n", found.refusal);
        return LIMIT_BROKEN;
    }
    const identify::Records records = identify::read_records(found.lines, "the console");
    show(arguments, identify::evaluate(records, plate, arguments.temperature_c),
         identify::truth_of(config), found.duration_s,
         fmt::format("Measured by the drive in {:.0f} s, on the simulated motor of {}.",
                     found.duration_s, arguments.scenario));
    return LIMITS_HOLD;
}

} // namespace

int identify(const IdentifyArguments &arguments)
{
    if (arguments.scenario.empty() == arguments.records.empty()) {
        throw FileError("name a scenario, whose motor is simulated, or --records FILE of a board");
    }
    return arguments.records.empty() ? identify_simulated(arguments) : identify_records(arguments);
}

void describe(CLI::App &command, IdentifyArguments &arguments)
{
    command
        .add_option(
            "scenario", arguments.scenario,
            "whose motor, board and imperfections are simulated; the drive knows the name plate only")
        ->type_name(A_SCENARIO);
    describe_with(command, arguments.with);
    command
        .add_option("--motor", arguments.motor,
                    "another motor; with --records the name plate, by name or path")
        ->type_name(A_MOTOR);
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

} // namespace nf::commands
