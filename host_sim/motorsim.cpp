// SPDX-License-Identifier: MIT
// The simulator's command line: run scenarios, step through them and through recordings, list what
// there is, measure speed. Exit status: 0 all limits hold or a recording is what it was, 1 not so,
// 2 wrong usage, wrong file or a file not written.
#include "bench_command.h"
#include "certify_command.h"
#include "debug_command.h"
#include "ending.h"
#include "identify_command.h"
#include "list_command.h"
#include "live_command.h"
#include "motor_command.h"
#include "program.h"
#include "replay_command.h"
#include "run_command.h"
#include "signals_command.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace nf::commands;

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
    describe(add(app, "run", "run a scenario and judge it", [this] { return run(run_); }), run_);
    describe(add(app, "debug", "step through a scenario, forwards and backwards",
                 [this] { return debug(debug_); }),
             debug_);
    describe(add(app, "signals",
                 "the firmware's words with formats and scales, as JSON for debuggers",
                 [this] { return signals(signals_); }),
             signals_);
    describe(add(app, "replay", "run a flight recorder's recording again",
                 [this] { return replay(replay_); }),
             replay_);
    nf::sheet::describe(add(app, "motor",
                            "turn the values of a data sheet, with their units, into a motor file",
                            [this] {
                                nf::sheet::write_motor(motor_);
                                return LIMITS_HOLD;
                            }),
                        motor_);
    describe(add(app, "identify", "measure a motor of which only the name plate is known",
                 [this] { return identify(identify_); }),
             identify_);
    describe(add(app, "certify", "how sure a drive is, within all error bars",
                 [this] { return certify(certify_); }),
             certify_);
    nf::live::describe(add(app, "live", "follow a running board: all signals of every tick",
                           [this] { return nf::live::live(live_) ? LIMITS_HOLD : LIMIT_BROKEN; }),
                       live_);
    add(app, "list", "list scenarios and imperfections", list);
    add(app, "estimators", "what `run --estimator` knows, with its gains, as JSON", estimators);
    describe(add(app, "bench", "measure the simulation speed", [this] { return bench(bench_); }),
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
