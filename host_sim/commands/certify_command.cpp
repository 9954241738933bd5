// SPDX-License-Identifier: MIT
#include "certify_command.h"

#include "certificate_json.h"
#include "certificate_page.h"
#include "certificate_text.h"
#include "choice.h"
#include "completion.h"
#include "ending.h"
#include "interrupt.h"
#include "program.h"
#include "progress.h"
#include "written_files.h"

namespace nf::commands
{
namespace
{

std::vector<std::string> overrides_of(const CertifyArguments &arguments)
{
    std::vector<std::string> set = {"motor=" + arguments.motor};
    if (!arguments.board.empty()) {
        set.push_back("board=" + arguments.board);
    }
    set.insert(set.end(), arguments.set.begin(), arguments.set.end());
    return set;
}

void check_certificate(const CertifyArguments &arguments, const Config &config)
{
    check_new(arguments.output, arguments.overwrite);
    check_outputs(config, {{"--output", arguments.output}, {"--json", arguments.json}});
    check_writable({arguments.output, arguments.json});
}

// Stopped by Ctrl-C it is of the runs so far.
void run_campaign(certify::Campaign &campaign, const CertifyArguments &arguments)
{
    const debug::InterruptWatch watch;
    certify::run(campaign, arguments.runs, arguments.seed,
                 {progress_of_runs(arguments.runs), debug::was_interrupted});
    if (campaign.points.empty()) {
        throw FileError("stopped before the first run");
    }
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

} // namespace

int certify(const CertifyArguments &arguments)
{
    const std::vector<std::string> shipped = {DEFAULT_TUNING};
    certify::Campaign campaign =
        certify::plan(arguments.tunings.empty() ? shipped : arguments.tunings, arguments.with,
                      overrides_of(arguments));
    check_certificate(arguments, campaign.series.front().believed);
    run_campaign(campaign, arguments);
    const certify::Judgement judgement = certify::judge(campaign);
    if (!arguments.output.empty()) {
        write_text(arguments.output, certify::page_of(campaign, judgement));
    }
    if (arguments.json.empty()) {
        write_text("-", certify::text_of(campaign, judgement));
    } else {
        write_text(arguments.json, certify::json_of(campaign, judgement));
    }
    const certify::Summary &best = judgement.summaries[judgement.best];
    return best.locked == best.runs ? LIMITS_HOLD : LIMIT_BROKEN;
}

void describe(CLI::App &command, CertifyArguments &arguments)
{
    command.footer(CERTIFY_HELP);
    command
        .add_option("motor", arguments.motor,
                    "motor file, by name or path; zoo:17 brings its board along")
        ->required()
        ->type_name(A_MOTOR);
    describe_board(command, arguments.board, "board, by name or path; else bench_310v");
    command
        .add_option("--tuning", arguments.tunings,
                    "tuning to try, by name or path; may be repeated; else the default, any")
        ->allow_extra_args(false)
        ->type_name(A_TUNING);
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

} // namespace nf::commands
