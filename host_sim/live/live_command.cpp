// SPDX-License-Identifier: MIT
#include "live_command.h"

#include "paced_channel.h"
#include "port_search.h"
#include "readable.h"
#include "serial_port.h"

#include <fmt/ranges.h>

namespace nf::live
{
namespace
{

constexpr const char *LIVE_HELP =
    R"(Every signal of every control tick of a running board: the board sends what it measures, and the same firmware
computes here what it computes there. What is written is checked against the board's state.

Examples:
  motorsim live /dev/ttyACM0                      a view, and a line for commands: `help` lists them
  motorsim live /dev/ttyACM0 --trace run.csv --for 10   the signals of 10 s, for plots
  motorsim live /dev/ttyACM0 --udp localhost:9870 for PlotJuggler: UDP server, JSON
  motorsim live /dev/ttyACM0 --script tune.txt    commands from a file
  motorsim live --simulate s1 --link board        a simulated board on a port: try `motorsim live board` beside it

Exit status: 0 done, 1 the board's state departed from the one here or a command of a script was refused, 2 wrong usage,
no board, or another firmware.)";

// What is said, by option or board file, is taken; else the rates of the shipped boards are tried.
std::vector<unsigned> rates_of(const LiveArguments &arguments)
{
    if (arguments.rate != 0) {
        return {arguments.rate};
    }
    if (!arguments.files.board.empty()) {
        return {static_cast<unsigned>(load_board(arguments.files.board).baud)};
    }
    return known_rates();
}

unsigned rate_of(const LiveArguments &arguments)
{
    try {
        return find_rate(
            [&](unsigned rate) { return std::make_unique<SerialPort>(arguments.port, rate); },
            rates_of(arguments));
    } catch (const LinkError &error) {
        throw LinkError(
            fmt::format("{}: {}", readable(arguments.port, READABLE_PATH), error.what()));
    }
}

std::string ports_here()
{
    const std::vector<std::string> ports = list_ports();
    return ports.empty() ? "no USB port is here" : fmt::format("here: {}", fmt::join(ports, ", "));
}

void describe_outputs(CLI::App &command, LiveArguments &arguments)
{
    command.add_option("--trace", arguments.trace, "write all signals of every tick as CSV")
        ->check(not_empty, "")
        ->type_name("FILE");
    command.add_option("--vcd", arguments.vcd, "write states, signals and gate edges as VCD")
        ->check(not_empty, "")
        ->type_name("FILE");
    command.add_option("--udp", arguments.udp, "send signals as JSON datagrams, for PlotJuggler")
        ->check(not_empty, "")
        ->type_name("HOST:PORT");
    command.add_option("--udp-every", arguments.udp_every, "send each so many-th tick only")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000000));
    command.add_option("--for", arguments.for_s, "end after so much time of the board, s")
        ->check(CLI::Range(0.0, 1e9))
        ->type_name("SECONDS");
}

void refuse_what_does_not_go_together(const LiveArguments &arguments)
{
    const bool follows = !arguments.port.empty();
    const bool serves = !arguments.serve.scenario.empty();
    if (follows == serves) {
        throw ChannelError(
            follows ? "name a port or --simulate SCENARIO, not both"
                    : fmt::format("name a port ({}), or --simulate SCENARIO", ports_here()));
    }
}

// What is for a board that is followed, and what for one that is simulated.
void separate(CLI::App &command)
{
    CLI::Option *const simulate = command.get_option("--simulate");
    for (const char *of_follower : {"--baud", "--trace", "--vcd", "--udp", "--udp-every", "--for",
                                    "--script", "--tuning", "--keep"}) {
        command.get_option(of_follower)->excludes(simulate);
    }
    for (const char *of_board : {"--with", "--link", "--flash"}) {
        command.get_option(of_board)->needs(simulate);
    }
}

} // namespace

void describe(CLI::App &command, LiveArguments &arguments)
{
    command.footer(LIVE_HELP);
    command.add_option("port", arguments.port, "serial port of the board");
    describe(command, arguments.serve);
    command
        .add_option(
            "--baud", arguments.rate,
            "of the port; else board.baud of --board; else those of the shipped boards are tried")
        ->check(CLI::Range(1200, 12000000));
    describe_outputs(command, arguments);
    command
        .add_option("--script", arguments.script,
                    "commands from a file; - is standard input; status 1 when one is refused")
        ->check(not_empty, "")
        ->type_name("FILE");
    command
        .add_option("--motor", arguments.files.motor,
                    "the board's motor file for `set`; else the shipped one of its name")
        ->type_name("MOTOR");
    command.add_option("--board", arguments.files.board, "likewise the board file")
        ->type_name("BOARD");
    command.add_option("--tuning", arguments.files.tuning, "likewise the tuning")
        ->type_name("TUNING");
    command
        .add_option("--set", arguments.files.set,
                    "what the board's configuration has been set to, over the files; repeatable")
        ->allow_extra_args(false)
        ->type_name("SECTION.KEY=VALUE");
    command.add_option("--keep", arguments.keep_s, "so many seconds for `debug` and `record`")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 600.0));
    separate(command);
}

bool live(LiveArguments arguments)
{
    const FileChoice &files = arguments.files;
    refuse_what_does_not_go_together(arguments);
    if (arguments.port.empty()) {
        serve(arguments.serve, {files.motor, files.board, files.set});
        return true;
    }
    arguments.baud = rate_of(arguments);
    SerialPort port(arguments.port, arguments.baud);
    if (!(arguments.serve.pace > 0)) {
        throw ChannelError("--pace 0 is for --simulate: a board that is followed has a time");
    }
    PacedChannel paced(port, arguments.serve.pace);
    return follow(paced, arguments);
}

} // namespace nf::live
