// SPDX-License-Identifier: MIT
// Every key of the schema, in every mode: another value of it changes what the firmware, the board
// or the simulated machine is given, or it is refused, or the schema says that the key does not act
// there and whoever writes it is told so.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "report.h"
#include "scenario.h"

#include "describe.h"
#include "files.h"
#include "hal_header.h"
#include "header.h"
#include "schema.h"

#include "testing.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include <unistd.h>

namespace
{

using Lines = std::vector<std::string>;

const char *const TUNINGS[] = {"published", "robust_motor_a", "voltage_phase"};
const char *const SOURCES[] = {"observer", "sensor"};
const int STARTUPS[] = {0, 100};
// Of sensor.kind: each has keys of its own.
const char *const KINDS[] = {"hall", "encoder", "absolute"};

// Short, with all that a machine can do: the rotor turns and is loaded, and what the report says of
// it is judged.
const char *const SCENARIO = R"(motor = "motor_a"
board = "g431_bench"
[scenario]
title = "every key"
mode = "speed"
duration_s = 0.02
prelude_s = 0.03
evaluate_from_s = 0.002
initial_speed_rpm = 300
load = [{time_s = 0.005, torque_pct = 13}]
[accept.any]
locked = true
)";

// What the keys of [plant] act on, where it is not ideal.
const Lines ROUGH = {"plant.saturation_d_pct=10", "plant.saturation_q_pct=10",
                     "plant.cogging_pct=1", "plant.shaft_resonance_hz=100", "plant.adc_noise_lsb=1",
                     "plant.bus_ripple_pct=1", "plant.bus_capacitance_f=0.001",
                     "board.bus_capacitance_f=0.001", // with it open gates do not bear 2000 rpm
                     "motor.max_speed_rpm=1500", "plant.bus_source_resistance_ohm=1",
                     "plant.angle_counts=4096", "measured.dead_time_s=1e-6", "measured.knee_a=0.5",
                     // in line the comparators may look either way
                     "hal.current_position=in_line",
                     // so that half of the amplifier's gain is enough
                     "hal.shunt_ohm=0.0104", "hal.amplifier_gain=-7.93"};

struct Mode {
    std::string file; // of the scenario
    Lines set;
    bool is_run; // the alignment of a start takes longer than all else of this test

    std::string name() const
    {
        return file + " " + fmt::format("{}", fmt::join(set, " "));
    }
};

class Scenarios
{
public:
    Scenarios()
    {
        std::string name = (std::filesystem::temp_directory_path() / "everykeyXXXXXX").string();
        path_ = mkdtemp(name.data());
        for (const char *tuning : TUNINGS) {
            std::ofstream(file(tuning)) << fmt::format("tuning = \"{}\"\n{}", tuning, SCENARIO);
        }
    }
    Scenarios(const Scenarios &) = delete;
    Scenarios &operator=(const Scenarios &) = delete;
    ~Scenarios()
    {
        std::filesystem::remove_all(path_);
    }

    std::string file(const std::string &tuning) const
    {
        return (path_ / (tuning + ".toml")).string();
    }

    // The rough machine is that of the modes with a start-up current: a sensor leaves the start-up
    // out and is run.
    std::vector<Mode> modes() const
    {
        std::vector<Mode> all;
        for (const char *tuning : TUNINGS) {
            for (const char *source : SOURCES) {
                for (const int startup : STARTUPS) {
                    Mode mode = {file(tuning),
                                 {fmt::format("drive.angle_source={}", source),
                                  fmt::format("startup.current_pct={}", startup),
                                  startup == 0 ? "input.kind=voltage" : "input.kind=rc_pulse",
                                  "hal.throttle_pin=PB12", "hal.pulse_pin=PA15"},
                                 startup == 0 || std::strcmp(source, "sensor") == 0};
                    if (startup != 0) {
                        mode.set.insert(mode.set.end(), ROUGH.begin(), ROUGH.end());
                        mode.set.push_back("supervision.oscillation=lower");
                        // Within what the board allows, so that a larger one acts.
                        mode.set.push_back("startup.align_current_pct=100");
                        mode.set.push_back("speed_loop.notch_hz=100");
                    }
                    all.push_back(mode);
                }
            }
        }
        for (const char *kind : KINDS) {
            all.push_back({file(TUNINGS[1]),
                           {"drive.angle_source=both", "startup.current_pct=100",
                            "startup.align_current_pct=100", fmt::format("sensor.kind={}", kind)},
                           false});
        }
        return all;
    }

private:
    std::filesystem::path path_;
};

// The values as they are and not as they were written.
nf::Config without_texts(nf::Config config)
{
    config.sources.overrides.clear();
    config.scenario.notes.clear();
    return config;
}

// The numbers of an image, without the words beside them.
std::string image(const nf::Config &config)
{
    std::string text = fmt::format("{}", nf::recorder_segment_entries(config.board));
    for (const nf::ConfigRow &row : nf::describe(config, nf::build(config))) {
        text += fmt::format(" {}", row.value);
    }
    return text;
}

// Of a part that refuses: "".
std::string hal_header(const nf::Config &config)
{
    try {
        return nf::make_hal_header(config);
    } catch (const nf::ConfigError &) {
        return "";
    }
}

// A hash of what the drive did to the machine, of the machine, and of the third current, which the
// background checks.
class Watch : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        const drive_out_t &out = tick.sim->out();
        for (const double value :
             {tick.truth.theta_el_rad, tick.truth.omega_mech_rad_s, tick.load_nm,
              static_cast<double>(out.compare.phase[0]), static_cast<double>(out.compare.phase[1]),
              static_cast<double>(tick.sim->hal().seen_ic)}) {
            uint64_t bits = 0;
            std::memcpy(&bits, &value, sizeof bits);
            hash_ = (hash_ ^ bits) * 1099511628211U;
        }
    }
    uint64_t hash() const
    {
        return hash_;
    }

private:
    uint64_t hash_ = 14695981039346656037U;
};

std::string run(nf::Config config)
{
    Watch watch;
    nf::RunOptions options;
    options.sink = &watch;
    const nf::RunResult result = nf::run_scenario(config, options);
    config.scenario.seed = 0; // the report repeats it
    return fmt::format("{} {} {}", watch.hash(), nf::json_text(config, result),
                       nf::table_text(config, result));
}

// What a configuration comes to, as far as is needed.
struct Outcome {
    nf::Config config;
    std::string firmware;
    std::string hal; // "": refused

    explicit Outcome(const nf::Config &whole)
        : config(without_texts(whole)), firmware(image(config)), hal(hal_header(config))
    {
    }
};

bool differ(const Outcome &a, const Outcome &b, std::string &run_of_a, bool is_run)
{
    if (a.firmware != b.firmware || (!a.hal.empty() && !b.hal.empty() && a.hal != b.hal)) {
        return true;
    }
    if (!is_run) {
        return false;
    }
    if (run_of_a.empty()) {
        run_of_a = run(a.config);
    }
    return run_of_a != run(b.config);
}

// Far ones first; near ones count where those are refused, as what they have to agree with is
// another key.
using Rungs = std::vector<Lines>;

constexpr double FACTORS[][2] = {{0.7, 1.4}, {0.97, 1.03}, {0.999, 1.001}};
constexpr double SHARES[][2] = {{0.01, 0.1},
                                {0.25, 0.5}}; // of the range, where 0 or a rule is in force

// Whole numbers are further away, as some are counted in fours.
Rungs numbers_near(double value, const nf::Field &field, bool whole)
{
    std::vector<std::array<double, 2>> pairs;
    const bool by_rule = field.min < 0 && value <= field.min;
    if (by_rule || !(std::abs(value) > 0)) {
        for (const auto &[low, high] : SHARES) {
            pairs.push_back({low * field.max, high * field.max});
        }
    } else if (whole) {
        pairs.push_back({std::floor(0.5 * value), 2 * value});
    } else {
        for (const auto &[low, high] : FACTORS) {
            pairs.push_back({low * value, high * value});
        }
    }
    Rungs rungs;
    for (const std::array<double, 2> &pair : pairs) {
        rungs.emplace_back();
        for (const double number : pair) {
            const double kept =
                std::clamp(whole ? std::round(number) : number, field.min, field.max);
            if (std::abs(kept - value) > 0) {
                rungs.back().push_back(fmt::format("{}", kept));
            }
        }
    }
    return rungs;
}

// Each item in turn, and all the other way round.
template <typename List> Rungs lists_near(const List &list, const nf::Field &field)
{
    List back = list;
    std::reverse(back.begin(), back.end());
    Lines texts = {fmt::format("[{}]", fmt::join(back, ","))};
    for (std::size_t k = 0; k < list.size(); k++) {
        List other = list;
        other[k] += other[k] > field.max / 2 ? -0.5 : 0.5;
        texts.push_back(fmt::format("[{}]", fmt::join(other, ",")));
    }
    return {texts};
}

// Of a choice, whose two words stand in quotes in what is allowed, in the order of the enumerators.
std::string other_word(const nf::Field &field, const nf::Target &target)
{
    const bool is_first = std::visit(
        [](const auto *value) {
            if constexpr (std::is_enum_v<std::remove_reference_t<decltype(*value)>>) {
                return static_cast<int>(*value) == 0;
            }
            return false;
        },
        target);
    const std::string allowed = field.allowed();
    const std::size_t quote = is_first ? allowed.rfind('"', allowed.size() - 2) : 0;
    return allowed.substr(quote + 1, allowed.find('"', quote + 1) - quote - 1);
}

// Other values of a key than the one in force; of a label and a record, which nothing follows from,
// none.
Rungs others(const nf::Field &field, const nf::Config &config)
{
    if (field.acting.is_record) {
        return {};
    }
    nf::Config copy = config;
    const nf::Target target = field.target(copy);
    if (const auto *number = std::get_if<double *>(&target)) {
        return numbers_near(**number, field, false);
    }
    if (const auto *number = std::get_if<int *>(&target)) {
        return numbers_near(**number, field, true);
    }
    if (const auto *number = std::get_if<unsigned *>(&target)) {
        return numbers_near(**number, field, true);
    }
    if (const auto *truth = std::get_if<bool *>(&target)) {
        return {{**truth ? "false" : "true"}};
    }
    if (const auto *pair = std::get_if<std::array<double, 2> *>(&target)) {
        return lists_near(**pair, field);
    }
    if (const auto *phases = std::get_if<std::array<double, 3> *>(&target)) {
        return lists_near(**phases, field);
    }
    if (const auto *points = std::get_if<std::vector<double> *>(&target)) {
        return lists_near(**points, field);
    }
    if (std::holds_alternative<std::string *>(target) ||
        std::holds_alternative<nf::Pins *>(target)) {
        return {}; // of pins test_g4_board tells
    }
    return {{other_word(field, target)}};
}

// The schema's word on a key that is written, beside what the user is told.
std::string told(const nf::Field &field, const nf::Config &config)
{
    const std::string idle = fmt::format("--set: {} = ", field.name());
    const std::string when = std::string(": acts ") + field.acting.when;
    const auto &notes = config.scenario.notes;
    const bool noted = std::any_of(notes.begin(), notes.end(), [&](const std::string &note) {
        return note.rfind(idle, 0) == 0 && note.find(when) != std::string::npos;
    });
    const bool acts = field.acting.holds(config);
    if (acts && field.acting.in != nullptr && noted) {
        return "acts, and is noted";
    }
    return !acts && !noted ? "does not act, and is not noted" : "";
}

// Whether an end of its range is refused because of it: some keys are limits, and nothing else.
bool is_a_limit(const nf::Field &field, const Mode &mode)
{
    for (const double end : {field.min, field.max}) {
        Lines set = mode.set;
        set.push_back(fmt::format("{}={}", field.name(), end));
        try {
            nf::make_hal_header(nf::load_scenario(mode.file, {}, set));
        } catch (const nf::ConfigError &error) {
            if (std::string(error.what()).find(field.name()) != std::string::npos) {
                return true;
            }
        }
    }
    return false;
}

// What else than a tuning says is the machine's or the run's: only a run shows it.
bool is_seen(const nf::Field &field, const Mode &mode)
{
    return mode.is_run || nf::may_hold(nf::FileKind::tuning, field.section);
}

// Each key in one mode after the other.
class Judge
{
public:
    void judge(const Mode &mode)
    {
        const Outcome before(nf::load_scenario(mode.file, {}, mode.set));
        run_before_.clear();
        for (const nf::Field &field : nf::schema()) {
            climb(field, mode, before);
        }
    }

    // A line for each key that is not as it has to be.
    std::string wrong() const
    {
        std::string text = wrong_;
        for (const std::string &name : named_) {
            text += seen_.count(name) == 0 ? name + ": acts in no mode\n" : "";
        }
        return text;
    }

private:
    void climb(const nf::Field &field, const Mode &mode, const Outcome &before)
    {
        bool is_accepted = false;
        for (const Lines &rung : others(field, before.config)) {
            named_.insert(field.name());
            for (const std::string &value : rung) {
                is_accepted = judge(field, value, mode, before) || is_accepted;
            }
            if (is_accepted) {
                return;
            }
        }
    }

    // Whether the value is accepted: of one that is refused nobody thinks that it acts.
    bool judge(const nf::Field &field, const std::string &value, const Mode &mode,
               const Outcome &before)
    {
        try {
            const std::string problem = judged(field, value, mode, before);
            if (!problem.empty()) {
                wrong_ += fmt::format("{}={} {}: {}\n", field.name(), value, problem, mode.name());
            }
            return true;
        } catch (const nf::ConfigError &) {
            return false;
        }
    }

    std::string judged(const nf::Field &field, const std::string &value, const Mode &mode,
                       const Outcome &before)
    {
        Lines set = mode.set;
        set.push_back(fmt::format("{}={}", field.name(), value));
        const nf::Config config = nf::load_scenario(mode.file, {}, set);
        const Outcome after(config);
        if (std::string(field.section) == "hal") {
            nf::make_hal_header(config);
        }
        std::string problem = told(field, config);
        if (!problem.empty() || !field.acting.holds(config)) {
            return problem;
        }
        if (differ(before, after, run_before_, mode.is_run) || is_a_limit(field, mode)) {
            seen_.insert(field.name());
            return "";
        }
        return is_seen(field, mode) ? "changes nothing" : "";
    }

    std::string run_before_;
    std::set<std::string> named_; // of which there are other values
    std::set<std::string> seen_;  // to act
    std::string wrong_;
};

TEST(every_key_acts_or_is_noted_or_refused)
{
    const Scenarios scenarios;
    Judge judge;
    for (const Mode &mode : scenarios.modes()) {
        judge.judge(mode);
    }
    TEST_ASSERT_EQUAL_STRING("", judge.wrong().c_str());
}

// Of a scenario's file the line is named; what a shipped tuning says is for every scenario, and is
// not noted.
TEST(a_line_that_does_not_act_is_noted_by_its_place)
{
    const Scenarios scenarios;
    const std::string file = scenarios.file("robust_motor_a");
    std::ofstream(file, std::ios::app) << "[observer]\nkappa_p = 0.3\n";
    const std::vector<std::string> notes =
        nf::load_scenario(file, {}, {"drive.angle_source=sensor"}).scenario.notes;
    TEST_ASSERT_EQUAL_size_t(1, notes.size());
    const std::string expected =
        file +
        ":15: observer.kappa_p = 0.3: acts only with drive.angle_source other than \"sensor\"";
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), notes[0].c_str());
    TEST_ASSERT_TRUE(nf::load_scenario(file).scenario.notes.empty());
}

// A tuning that somebody wrote is for a drive of his own.
TEST(a_line_of_ones_own_tuning_or_imperfection_set_that_does_not_act_is_noted)
{
    const Scenarios scenarios;
    const std::string tuning = scenarios.file("tuning_of_ones_own");
    std::filesystem::copy_file(nf::data_folder() / "tunings/published.toml", tuning);
    std::ofstream(tuning, std::ios::app) << "[phase_compensator]\ngain = 0.05\n";
    const std::string rough = scenarios.file("rough");
    std::ofstream(rough) << "[plant]\nbus_ripple_hz = 120\n";
    const nf::Config config =
        nf::load_scenario(scenarios.file("published"), {rough}, {"tuning=" + tuning});
    const std::string noted = fmt::format("{}", fmt::join(config.scenario.notes, "\n"));
    TEST_ASSERT_TRUE(noted.find(": phase_compensator.gain = 0.05: acts only with") !=
                     std::string::npos);
    TEST_ASSERT_TRUE(noted.find(rough + ":2: plant.bus_ripple_hz = 120: acts only with") !=
                     std::string::npos);
}

} // namespace
