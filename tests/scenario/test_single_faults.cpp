// SPDX-License-Identifier: MIT
// Sensors, legs and clock that are wrong by a factor, at standstill, in RUN and with a weakened
// field: how soon the drive names it, or what it does all the same. The table is part of the
// design: docs/protection.md, "Cross-checks".
//
//     test_single_faults            holds the table
//     test_single_faults --measure  prints it as it is measured now; tools/dev figures --write puts
//                                   it there
#include "scripted_run.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

constexpr double RPM_PER_RAD_S = 30.0 / 3.14159265358979323846;
constexpr double OBSERVED_S = 0.6;
constexpr double FOUND_MS = 200;

// A scenario and when the fault begins in it, long after what the load has changed.
struct Place {
    const char *name;
    const char *scenario;
    std::vector<std::string> set;
    double fault_s;
};

const std::vector<Place> &places()
{
    static const std::vector<Place> all = {
        {"standstill, 7.5 A", "any", {"scenario.command=[]", "scenario.load=[]"}, 1.5},
        {"1200 rpm, 3 N·m",
         "any",
         {"scenario.command=[{time_s = 0.1, speed_rpm = 1200}]",
          "scenario.load=[{time_s = 0.8, torque_nm = 3}]"},
         2.0},
        {"2600 rpm, weakened",
         "s_weakening",
         {"scenario.command=[{time_s = 0.1, speed_rpm = 2600}]",
          "scenario.load=[{time_s = 0.9, torque_nm = 3}]"},
         2.4},
    };
    return all;
}

struct Fault {
    const char *name;
    const char *text;
    bool in_run;   // is found within FOUND_MS in RUN …
    bool weakened; // … and with a weakened field
};

constexpr Fault FAULTS[] = {
    {"sensor a at half gain", "what = 'adc_a_gain', value = 0.5", true, true},
    {"sensor b at half gain", "what = 'adc_b_gain', value = 0.5", true, true},
    {"sensor c at half gain", "what = 'adc_c_gain', value = 0.5", true, true},
    {"sensor a 25 % high", "what = 'adc_a_gain', value = 1.25", true, true},
    {"all sensors at half gain", "what = 'adc_all_gain', value = 0.5", true, false},
    {"bus sensor at 3/4", "what = 'adc_bus_gain', value = 0.75", true, true},
    {"bus sensor at 5/4", "what = 'adc_bus_gain', value = 1.25", true, true},
    {"duty of leg a stuck at 50 %", "what = 'duty_a_stuck', value = 50", true, true},
    {"duty of leg b stuck at 50 %", "what = 'duty_b_stuck', value = 50", true, true},
    {"duty of leg c stuck at 0", "what = 'duty_c_stuck', value = 0", true, true},
    {"clock 25 % fast", "what = 'clock', value = 1.25", true, true},
    {"clock 20 % slow", "what = 'clock', value = 0.8", true, true},
    {"temperature open, high", "what = 'temperature_high'", true, true},
    {"temperature open, low", "what = 'temperature_low'", true, true},
};

struct Found {
    fault_id_t id = FAULT_NONE;
    double after_ms = 0;
    double current_a = 0; // the largest true phase current
    double rpm = 0;       // true, at the end
    bool gates_after = false;
};

Found inject(const Fault &fault, const Place &place)
{
    std::vector<std::string> set = place.set;
    set.push_back(fmt::format("scenario.duration_s={}", place.fault_s + OBSERVED_S));
    set.push_back(fmt::format("scenario.fault=[{{time_s = {}, {}}}]", place.fault_s, fault.text));
    const nf::Config config = nf::load_scenario(place.scenario, {}, set);
    nf::ScriptedRun run(config);
    Found found;
    while (run.tick() < run.end() && found.id == FAULT_NONE) {
        const nf::Tick tick = run.control();
        if (tick.time_s >= place.fault_s) {
            for (const double i : tick.truth.i_abc_a) {
                found.current_a = std::max(found.current_a, std::fabs(i));
            }
        }
        found.id = tick.sim->drive().fault.id;
        found.after_ms = (tick.time_s - place.fault_s) * 1e3;
        found.rpm = tick.truth.omega_mech_rad_s * RPM_PER_RAD_S;
        run.advance();
    }
    return found;
}

std::string cell(const Found &found)
{
    return found.id == FAULT_NONE
               ? fmt::format("not seen: {:.0f} A, {:.0f} rpm", found.current_a, found.rpm)
               : fmt::format("{} {:.0f} ms, {:.0f} A", fault_text(found.id)->name, found.after_ms,
                             found.current_a);
}

const std::vector<std::vector<Found>> &cells()
{
    static const std::vector<std::vector<Found>> all = [] {
        std::vector<std::vector<Found>> made;
        for (const Fault &fault : FAULTS) {
            made.emplace_back();
            for (const Place &place : places()) {
                made.back().push_back(inject(fault, place));
            }
        }
        return made;
    }();
    return all;
}

std::vector<std::string> table()
{
    std::vector<std::string> lines = {"| wrong |", "| --- |"};
    for (const Place &place : places()) {
        lines[0] += fmt::format(" {} |", place.name);
        lines[1] += " --- |";
    }
    std::size_t row = 0;
    for (const Fault &fault : FAULTS) {
        lines.push_back(fmt::format("| {} |", fault.name));
        for (const Found &found : cells()[row]) {
            lines.back() += fmt::format(" {} |", cell(found));
        }
        row++;
    }
    return lines;
}

TEST(test_what_is_wrong_by_a_factor_is_named_within_200_ms_of_run)
{
    std::size_t row = 0;
    for (const Fault &fault : FAULTS) {
        for (std::size_t place = 1; place < places().size(); place++) {
            const Found &found = cells()[row][place];
            const std::string text =
                fmt::format("{}, {}: {}", fault.name, places()[place].name, cell(found));
            if (place == 1 ? fault.in_run : fault.weakened) {
                TEST_ASSERT_TRUE_MESSAGE(found.id != FAULT_NONE, text.c_str());
                TEST_ASSERT_TRUE_MESSAGE(found.after_ms >= 0 && found.after_ms <= FOUND_MS,
                                         text.c_str());
            }
        }
        row++;
    }
}

// The comparators of the power stage open the gates at that current, whatever the sensors say.
TEST(test_the_true_current_stays_below_the_comparators_until_the_gates_open)
{
    for (const std::vector<Found> &row : cells()) {
        for (std::size_t place = 0; place < places().size(); place++) {
            const nf::Config config = nf::load_scenario(places()[place].scenario);
            TEST_ASSERT_TRUE(row[place].current_a <= config.board.trip_a);
        }
    }
}

// Its third current is what the drive is told of the other two.
TEST(test_a_board_with_two_current_sensors_has_no_sum_to_judge)
{
    Place two = places()[1];
    two.set.emplace_back("board.current_sensors=2");
    for (const char *const what : {"what = 'adc_a_stuck'", "what = 'adc_b_gain', value = 0.5"}) {
        const Found found = inject({"", what, false, false}, two);
        TEST_ASSERT_TRUE_MESSAGE(found.id != FAULT_CURRENT_SUM, what);
    }
}

TEST(test_the_table_of_the_design_is_the_measured_one)
{
    std::ifstream file(NF_DESIGN_FILE);
    const std::string design((std::istreambuf_iterator<char>(file)), {});
    for (const std::string &line : table()) {
        TEST_ASSERT_TRUE_MESSAGE(design.find(line + "\n") != std::string::npos, line.c_str());
    }
}

} // namespace

int main(int argc, char **argv)
{
    if (argc > 1 && std::strcmp(argv[1], "--measure") == 0) {
        for (const std::string &line : table()) {
            fmt::print("{}\n", line);
        }
        return 0;
    }
    return testing_main(argc, argv);
}
