// SPDX-License-Identifier: MIT
#include "bench_command.h"

#include "bench.h"
#include "completion.h"
#include "config.h"
#include "ending.h"
#include "program.h"
#include "written_files.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nf::commands
{
namespace
{

std::string bench_json(const BenchResult &b)
{
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
    return json.dump(2) + '\n';
}

std::string bench_text(const BenchResult &b)
{
    return fmt::format("{}: {} ticks = {:g} s simulated, {} runs, one core\n"
                       "  best    {:7.1f} x real time  {:6.1f} ns per tick\n"
                       "  median  {:7.1f} x real time  {:6.1f} ns per tick\n"
                       "  of the best: plant {:.1f} ns, drive {:.1f} ns, rest {:.1f} ns\n",
                       b.scenario, b.ticks, b.simulated_s, b.runs, b.real_time_best, b.best_ns,
                       b.real_time_median, b.median_ns, b.plant_ns, b.drive_ns,
                       b.best_ns - b.plant_ns - b.drive_ns);
}

} // namespace

int bench(const BenchArguments &arguments)
{
    const Config config = load_scenario(arguments.scenario);
    check_output(config, "--json", arguments.json);
    const BenchResult b = nf::bench(config, arguments.runs);
    if (!arguments.json.empty()) {
        write_text(arguments.json, bench_json(b));
    } else {
        write_text("-", bench_text(b));
    }
    return LIMITS_HOLD;
}

void describe(CLI::App &command, BenchArguments &arguments)
{
    command.add_option("scenario", arguments.scenario, "scenario to time")
        ->capture_default_str()
        ->type_name(A_SCENARIO);
    command.add_option("--runs", arguments.runs, "how often")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    command.add_option("--json", arguments.json, "write the figures as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

} // namespace nf::commands
