// The simulator's command line: run scenarios, list what there is, measure speed.
// Exit status: 0 all limits hold, 1 one does not, 2 wrong usage, wrong file or a file not written.
#include "bench.h"
#include "data_list.h"
#include "report.h"
#include "scenario.h"
#include "trace.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace
{

constexpr int LIMITS_HOLD = 0;
constexpr int LIMIT_BROKEN = 1;
constexpr int BAD_INPUT = 2;

constexpr const char *EXAMPLES = R"(Examples:
  motorsim list                              what can be run, and with which imperfections
  motorsim run s1                            metrics of scenario s1 beside their limits
  motorsim run s2 --with adc --with hot      the same drive with noisy sensors and a hot motor
  motorsim run s2 --set tuning=robust        with another tuning file
  motorsim run s1 --set motor.inertia_kg_m2=0.006 --trace s1.csv --json s1.json
  motorsim run ./mine.toml --json - | jq .angle_error_max_deg
  motorsim bench                             simulation speed on this machine

Exit status: 0 all limits of the scenario hold, 1 one does not, 2 wrong usage or input.)";

struct RunArguments {
    std::string scenario;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string trace;
    bool trace_prelude = false;
    std::string json;
};

struct BenchArguments {
    std::string scenario = "s1";
    int runs = 30;
    bool json = false;
};

struct OutputError : std::runtime_error {
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
    return fs::equivalent(a, b, error) ||
           fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
}

// Nothing is written over what was read, nor twice to the same file.
void check_outputs(const RunArguments &arguments, const nf::Config &config)
{
    nf::check_output(config, "--trace", arguments.trace);
    nf::check_output(config, "--json", arguments.json);
    if (!arguments.trace.empty() && !arguments.json.empty() &&
        same_file(arguments.trace, arguments.json)) {
        throw OutputError(
            fmt::format("{}: --trace and --json cannot go to the same file", arguments.trace));
    }
}

void write_text(const std::string &path, const std::string &text)
{
    std::FILE *const file = path == "-" ? stdout : std::fopen(path.c_str(), "wb");
    bool good = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    if (file != nullptr) {
        good = (path == "-" ? std::fflush(file) : std::fclose(file)) == 0 && good;
    }
    if (!good) {
        throw OutputError(fmt::format(
            "{}: cannot write: {}", path == "-" ? "standard output" : path, std::strerror(errno)));
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

int run(const RunArguments &arguments)
{
    const nf::Config config = nf::load_scenario(arguments.scenario, arguments.with, arguments.set);
    check_outputs(arguments, config);
    std::unique_ptr<nf::Trace> trace;
    nf::RunOptions options;
    options.progress = progress_line();
    if (!arguments.trace.empty()) {
        trace = std::make_unique<nf::Trace>(arguments.trace, arguments.trace_prelude);
        options.sink = trace.get();
    }
    const nf::RunResult result = nf::run_scenario(config, options);
    if (trace) {
        trace->close();
    }
    if (arguments.json.empty()) {
        write_text("-", nf::table_text(config, result));
    } else {
        write_text(arguments.json, nf::json_text(config, result));
    }
    const std::vector<nf::Violation> broken = nf::violations(config, result);
    for (const nf::Violation &violation : broken) {
        fmt::print(stderr, "{}: {}\n", config.scenario.id, violation.text());
    }
    return broken.empty() ? LIMITS_HOLD : LIMIT_BROKEN;
}

int list()
{
    write_text("-", nf::data_list_text());
    return LIMITS_HOLD;
}

int bench(const BenchArguments &arguments)
{
    const nf::BenchResult b = nf::bench(nf::load_scenario(arguments.scenario), arguments.runs);
    if (arguments.json) {
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
        write_text("-", json.dump(2) + '\n');
        return LIMITS_HOLD;
    }
    write_text("-", fmt::format("{}: {} ticks = {:g} s simulated, {} runs, one core\n"
                                "  best    {:7.1f} x real time  {:6.1f} ns per tick\n"
                                "  median  {:7.1f} x real time  {:6.1f} ns per tick\n"
                                "  of the best: plant {:.1f} ns, drive {:.1f} ns, rest {:.1f} ns\n",
                                b.scenario, b.ticks, b.simulated_s, b.runs, b.real_time_best,
                                b.best_ns, b.real_time_median, b.median_ns, b.plant_ns, b.drive_ns,
                                b.best_ns - b.plant_ns - b.drive_ns));
    return LIMITS_HOLD;
}

void describe_run(CLI::App &command, RunArguments &arguments)
{
    command
        .add_option("scenario", arguments.scenario, "name (see `motorsim list`) or path of a .toml")
        ->required();
    command.add_option("--with", arguments.with, "imperfection set, name or path; may be repeated")
        ->allow_extra_args(false)
        ->type_name("IMPERFECTION");
    command.add_option("--set", arguments.set, "override a setting; may be repeated")
        ->allow_extra_args(false)
        ->type_name("KEY=VALUE");
    command.add_option("--trace", arguments.trace, "write all signals of every tick as CSV")
        ->check(not_a_trace_file, "")
        ->type_name("FILE");
    command.add_flag("--trace-prelude", arguments.trace_prelude, "trace the time before t = 0 too");
    command.add_option("--json", arguments.json, "write the metrics as JSON; - is standard output")
        ->check(not_a_file, "")
        ->type_name("FILE");
}

void describe_bench(CLI::App &command, BenchArguments &arguments)
{
    command.add_option("scenario", arguments.scenario, "scenario to time")->capture_default_str();
    command.add_option("--runs", arguments.runs, "how often")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    command.add_flag("--json", arguments.json, "print JSON");
}

int parse_and_do(int argc, char **argv)
{
    CLI::App app{"Simulates a motor, its inverter and the drive's firmware, tick by tick."};
    RunArguments run_arguments;
    BenchArguments bench_arguments;
    CLI::App *const run_command = app.add_subcommand("run", "run a scenario and judge it");
    CLI::App *const list_command = app.add_subcommand("list", "list scenarios and imperfections");
    CLI::App *const bench_command = app.add_subcommand("bench", "measure the simulation speed");
    describe_run(*run_command, run_arguments);
    describe_bench(*bench_command, bench_arguments);
    app.footer(EXAMPLES);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success &asked) { // --help
        return app.exit(asked);
    } catch (const CLI::ParseError &error) {
        fmt::print(stderr, "motorsim: {}; `motorsim --help` shows how\n", error.what());
        return BAD_INPUT;
    }
    if (*run_command) {
        return run(run_arguments);
    }
    if (*bench_command) {
        return bench(bench_arguments);
    }
    if (*list_command) {
        return list();
    }
    fmt::print(stderr, "motorsim: no command; `motorsim --help` shows how\n");
    return BAD_INPUT;
}

} // namespace

int main(int argc, char **argv)
{
    try {
        return parse_and_do(argc, argv);
    } catch (const std::exception &error) {
        fmt::print(stderr, "motorsim: {}\n", error.what());
        return BAD_INPUT;
    }
}
