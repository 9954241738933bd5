// SPDX-License-Identifier: MIT
#include "serve_command.h"

#include "flash_file.h"
#include "interrupt.h"
#include "pty_server.h"

#include <cstdio>
#include <optional>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

Config load(const ServeArguments &arguments, const ServeFiles &files)
{
    std::vector<std::string> set = files.set;
    for (const auto &[key, value] :
         {std::pair("motor", files.motor), std::pair("board", files.board)}) {
        if (!value.empty()) {
            set.push_back(fmt::format("{}={}", key, value));
        }
    }
    return load_scenario(arguments.scenario, arguments.with, set);
}

// At once, also where it goes into a pipe: who waits for the port's name reads it there.
void say(const std::string &line)
{
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

} // namespace

std::string not_empty(const std::string &name)
{
    return name.empty() ? "needs a name" : "";
}

void describe(CLI::App &command, ServeArguments &arguments)
{
    command
        .add_option("--simulate", arguments.scenario,
                    "serve a simulated board on a pseudo-terminal, with the motor of a scenario, "
                    "whose script commands it until somebody else does")
        ->check(not_empty, "")
        ->type_name("SCENARIO");
    command.add_option("--with", arguments.with, "imperfection set of --simulate; may be repeated")
        ->allow_extra_args(false)
        ->type_name("IMPERFECTION");
    command
        .add_option("--pace", arguments.pace,
                    "seconds of the board in a second, of --simulate and of a port on which one is "
                    "served so; --simulate 0: as many as it can do")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1000.0));
    command
        .add_option("--link", arguments.link,
                    "symbolic link to the port of --simulate, for a name that stays")
        ->check(not_empty, "")
        ->type_name("PATH");
    command
        .add_option(
            "--flash", arguments.flash,
            "file of the flash of --simulate: read at the start where it is there, written at the "
            "end, as a board keeps what is stored when it is switched off")
        ->check(not_empty, "")
        ->type_name("FILE");
}

void serve(const ServeArguments &arguments, const ServeFiles &files)
{
    const Config config = load(arguments, files);
    std::optional<hal_host_flash_t> kept;
    std::optional<OutputFile> keeps; // from now on: that it cannot be written shows at once
    if (!arguments.flash.empty()) {
        kept = read_flash(arguments.flash, config.scenario.seed);
        keeps.emplace(arguments.flash);
    }
    SimulatedBoard board(config, kept ? &*kept : nullptr);
    Pty pty(arguments.link);
    const std::string &port = arguments.link.empty() ? pty.port() : arguments.link;
    say(fmt::format("serving on {}; connect with: motorsim live {}", pty.port(), port));
    const debug::InterruptWatch watch(debug::ending_signals());
    Serving serving;
    serving.pace = arguments.pace;
    serving.stops = debug::was_interrupted;
    serving.lags = [](double lag_s) {
        fmt::print(stderr, "the simulation is slower than its pace: {:.2g} s are left out\n",
                   lag_s);
    };
    serve(board, pty, serving);
    if (keeps) {
        write_flash(*keeps, board.flash());
    }
}

} // namespace nf::live
