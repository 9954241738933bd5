// SPDX-License-Identifier: MIT
#include "motor_command.h"

#include "output_file.h"
#include "program.h"
#include "questions.h"

#include <filesystem>
#include <iostream>
#include <stdexcept>

#include <unistd.h>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

constexpr const char *MOTOR_HELP =
    R"(Each value is typed as the data sheet prints it: a number, its unit and, where sheets differ, the convention.

  units           ohm mohm, H mH uH, N.m mN.m kgf.cm oz.in lb.in lb.ft, N.m/A oz.in/A kg.cm/A, V/krpm mV/rpm V.s/rad,
                  rpm/V, kg.m2 kg.cm2 g.cm2 oz.in2 oz.in.s2 lb.in2, A mA, W, rpm rad/s; also N·m, N*m, Nm, oz-in, cm², Ω, µH
  R and L         "phase to phase" (line to line), "phase" (line to neutral, star), "delta winding"
  currents        "peak" or "rms", of a phase
  torque / A      "peak" or "rms" of a phase; "six-step" (block commutation): sheets of "brushless DC" motors
  voltages        "peak" or "rms" and "phase to phase" or "phase"; "six-step" alone
What is missing is asked for on a terminal, and else named.

Examples:
  motorsim motor -o my_motor.toml                    asks for each value
  motorsim motor --name "EC 45 flat" --poles 16 --resistance "0.608 ohm phase to phase"
      --inductance "0.463 mH phase to phase" --torque-constant "36.9 mN.m/A six-step" --rated-torque "128 mN.m"
      --rated-speed "4000 rpm" --max-current "6 A peak" --inertia "181 g.cm2" --no-load "234 mA 6110 rpm" -o my_motor.toml
  motorsim motor --poles 14 --kv "270 rpm/V peak phase to phase" --friction 0   asks for the rest)";

void check_output_file(const MotorArguments &arguments)
{
    if (!arguments.overwrite && !arguments.output.empty() && is_there(arguments.output)) {
        throw std::runtime_error(
            fmt::format("{}: is there already; --overwrite replaces it", arguments.output));
    }
}

Dialogue terminal()
{
    return {[](const std::string &text) {
                fmt::print(stderr, "{}", text);
                std::fflush(stderr);
            },
            []() -> std::optional<std::string> {
                std::string line;
                return std::getline(std::cin, line) ? std::optional(line) : std::nullopt;
            }};
}

Sheet sheet_of(const MotorArguments &arguments)
{
    Sheet sheet;
    // In the order of the help, so that poles are known before what is divided by them.
    for (const SheetOption &option : sheet_options()) {
        const auto typed = arguments.given.find(option.name);
        if (typed != arguments.given.end()) {
            sheet.give(option.name, typed->second);
        }
    }
    return sheet;
}

void show_remarks(const Sheet &sheet)
{
    for (const std::string &remark : sheet.remarks()) {
        fmt::print(stderr, "note: {}\n", remark);
    }
}

} // namespace

void describe(CLI::App &command, MotorArguments &arguments)
{
    command.footer(MOTOR_HELP);
    for (const SheetOption &option : sheet_options()) {
        const std::string name = option.name;
        command
            .add_option_function<std::string>(
                name,
                [&arguments, name](const std::string &typed) { arguments.given[name] = typed; },
                fmt::format("{}: \"{}\"", option.help, option.example))
            ->type_name("VALUE");
    }
    command.add_option("-o,--output", arguments.output, "write the motor file; else it is printed")
        ->check(
            [](const std::string &name) {
                return name.empty()  ? std::string("needs the name of a file")
                       : name == "-" ? std::string("without it the file goes to standard output")
                                     : std::string();
            },
            "")
        ->type_name("FILE");
    command.add_flag("--overwrite", arguments.overwrite, "even if it is there already");
}

void write_motor(const MotorArguments &arguments)
{
    check_output_file(arguments);
    Sheet sheet = sheet_of(arguments);
    if (isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0) {
        ask(sheet, terminal());
    }
    if (!sheet.missing().empty()) {
        throw std::runtime_error(missing_text(sheet));
    }
    write_text(arguments.output.empty() ? "-" : arguments.output, sheet.motor_file());
    show_remarks(sheet);
    if (!arguments.output.empty()) {
        write_text("-",
                   fmt::format("{0}: written; next: motorsim run any --motor {0} --board BOARD\n",
                               arguments.output));
    }
}

} // namespace nf::sheet
