// SPDX-License-Identifier: MIT
// Faults put into a running drive, end to end: which one is found, how soon, and none where none is
// due.
#include "scenario.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

// Scenario s2, 1800 rpm under 3 N·m: 60 electrical turns a second, ticks of 0.1 ms.
constexpr double FAULT_TIME_S = 0.6;
constexpr double TURN_TICKS = 10000.0 / 60.0;

struct Case {
    const char *fault;
    std::vector<fault_id_t> any_of;
    double ticks; // until it is found, at most
};

std::string list_of(const std::vector<nf::FoundFault> &faults)
{
    std::string text;
    for (const fault_t &fault : faults) {
        text += fmt::format("{}@{} ", fault_text(fault.id)->name, fault.tick);
    }
    return text;
}

nf::RunResult run(const std::string &scenario, const std::vector<std::string> &with,
                  std::vector<std::string> set)
{
    return nf::run_scenario(nf::load_scenario(scenario, with, set));
}

// A broken wire or sensor may show by what it does to currents and observer before it has been
// compared for long enough.
TEST(test_each_injected_fault_is_found_in_its_time)
{
    // A turn and a half that counts; an observer that is losing its angle counts some twice or not
    // at all.
    const Case cases[] = {
        {"what = 'adc_a_high'", {FAULT_ADC_SATURATED}, 0},
        {"what = 'adc_b_low'", {FAULT_ADC_SATURATED}, 0},
        {"what = 'overcurrent', value = 19", {FAULT_OVERCURRENT}, 0},
        {"what = 'bus_voltage', value = 190", {FAULT_UNDERVOLTAGE}, 0},
        {"what = 'bus_voltage', value = 405", {FAULT_OVERVOLTAGE}, 0},
        {"what = 'break_input'", {FAULT_BREAK}, 0},
        {"what = 'adc_a_stuck'", {FAULT_BREAK, FAULT_OVERCURRENT}, 3 * TURN_TICKS},
        {"what = 'adc_b_stuck', value = 3", {FAULT_BREAK}, 3 * TURN_TICKS},
        {"what = 'phase_a_open'", {FAULT_LOST_PHASE, FAULT_OVERCURRENT}, 12 * TURN_TICKS},
        {"what = 'phase_b_open'", {FAULT_LOST_PHASE, FAULT_OVERCURRENT}, 12 * TURN_TICKS},
        {"what = 'phase_c_open'", {FAULT_LOST_PHASE, FAULT_OVERCURRENT}, 12 * TURN_TICKS},
        {"what = 'temperature', value = 105", {FAULT_OVERTEMPERATURE}, 1100}, // 0.1 s
        {"what = 'rotor_blocked'", {FAULT_STALL}, 12000}, // 1 s, and it has to stop
        {"what = 'late_isr', until_s = 0.61", {FAULT_LATE}, 11},
        {"what = 'config_corrupt', value = 30",
         {FAULT_CONFIGURATION},
         2.0 * CONFIG_GUARD_STEPS * SUPERVISION_STEPS *
             10}, // two rounds, a word in its turn a slow period
    };
    const double before_s = nf::load_scenario("s2_robust", {}, {}).scenario.prelude_s;
    const auto fault_tick = static_cast<uint32_t>(std::lround((before_s + FAULT_TIME_S) * 10000));
    for (const Case &one : cases) {
        const nf::RunResult result =
            run("s2_robust", {},
                {"scenario.duration_s=2.5",
                 "scenario.fault=[{time_s = 0.6, " + std::string(one.fault) + "}]"});
        const std::string text = fmt::format("{}: {}", one.fault, list_of(result.faults));
        TEST_ASSERT_EQUAL_size_t_MESSAGE(1, result.faults.size(), text.c_str());
        const fault_t &fault = result.faults.front();
        TEST_ASSERT_TRUE_MESSAGE(std::count(one.any_of.begin(), one.any_of.end(), fault.id) == 1,
                                 text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(fault.tick >= fault_tick, text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(fault.tick - fault_tick <= one.ticks, text.c_str());
    }
}

// The robust tuning holds the rotor with each of the sets, and is never stopped.
TEST(test_the_robust_drive_keeps_its_rotor_without_a_fault)
{
    for (const char *scenario : {"s1_robust", "s2_robust", "s3_robust"}) {
        for (const char *with : {"ideal", "adc", "hot", "deadtime", "saturated", "imp", "all"}) {
            const nf::RunResult result = run(scenario, {with}, {});
            const std::string text = fmt::format("{} with {}", scenario, with);
            TEST_ASSERT_TRUE_MESSAGE(result.metrics.locked, text.c_str());
            TEST_ASSERT_EQUAL_STRING_MESSAGE("", list_of(result.faults).c_str(), text.c_str());
        }
    }
}

// Full reversals at the largest torque, with noise: a ramp of 10000 rpm/s, load steps of rated
// torque.
TEST(test_hard_but_allowed_use_has_no_fault)
{
    const nf::RunResult reversals = run(
        "s1_robust", {"adc"},
        {"scenario.command=[{time_s = 0.1, speed_rpm = 1800}, {time_s = 0.6, speed_rpm = -1800}, "
         "{time_s = 1.2, speed_rpm = 1800}]",
         "scenario.duration_s=2"});
    TEST_ASSERT_EQUAL_STRING("", list_of(reversals.faults).c_str());
    const nf::RunResult loads =
        run("s2_robust", {"adc"},
            {"scenario.load=[{time_s = 0.1, torque_nm = 7.8}, {time_s = 0.6, torque_nm = 0}, "
             "{time_s = 0.9, torque_nm = -7.8}]",
             "scenario.duration_s=1.5"});
    TEST_ASSERT_EQUAL_STRING("", list_of(loads.faults).c_str());
}

// What braking gives back charges a capacitor that no rectifier discharges: it has to end below the
// limit.
TEST(test_braking_into_a_capacitor_stays_below_the_highest_bus)
{
    const nf::RunResult result =
        run("s1_robust", {},
            {"scenario.command=[{time_s = 0.1, speed_rpm = 1800}, {time_s = 0.6, speed_rpm = 0}]",
             "scenario.duration_s=2", "plant.bus_capacitance_f=2e-4",
             "plant.bus_source_resistance_ohm=0.5"});
    TEST_ASSERT_EQUAL_STRING("", list_of(result.faults).c_str());
}

// The true currents in the tick in which each search for a turning rotor begins its first pulse.
class Searches : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        const drive_t &drive = tick.sim->drive();
        const bool pulse = drive.state == DRIVE_STATE_FLYING_START && tick.sim->out().gate_enable;
        if (pulse && !pulse_before_ && drive.start.flying_start.phase == FLYING_START_FIRST_PULSE) {
            for (const double i : tick.truth.i_abc_a) {
                largest_a = std::max(largest_a, std::fabs(i));
            }
            count++;
        }
        pulse_before_ = pulse;
        state = drive.state;
    }
    int count = 0;
    double largest_a = 0;
    drive_state_t state = DRIVE_STATE_INIT;

private:
    bool pulse_before_ = false;
};

// Stopped under load and started again in the next tick, with 9 A in the windings.
TEST(test_a_search_for_a_turning_rotor_begins_without_current)
{
    // A quarter of 5 % of 10 A, and a count of the converter's rounding.
    constexpr double QUIET_A = 0.125 + 20.0 / 2048;
    Searches searches;
    nf::RunOptions options;
    options.sink = &searches;
    const nf::RunResult result = nf::run_scenario(
        nf::load_scenario("s2_robust", {},
                          {"scenario.duration_s=1", "scenario.load=[{time_s = 0.3, torque_nm = 8}]",
                           "scenario.request=[{time_s = 0.6, run = false}, "
                           "{time_s = 0.6001, run = true}]"}),
        options);
    TEST_ASSERT_EQUAL_STRING("", list_of(result.faults).c_str());
    TEST_ASSERT_EQUAL_INT(2, searches.count);
    TEST_ASSERT_TRUE_MESSAGE(searches.largest_a <= QUIET_A,
                             fmt::format("{} A", searches.largest_a).c_str());
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, searches.state);
}

// ---- a load that drives

// Whose load is more than its largest torque: it cannot brake, and its load takes it beyond its
// highest speed.
struct Driven {
    const char *motor;
    const char *board;
    const char *tuning;
    double load_pct; // of the rated torque
    const char *angle_source;
};
constexpr Driven DRIVEN[] = {{"motor_a", "bench_310v", "robust_motor_a", 200, "observer"},
                             {"motor_a", "bench_310v", "robust_motor_a", 200, "sensor"},
                             {"motor_b", "bench_310v", "any", 300, "observer"},
                             {"motor_b", "bench_310v", "any", 300, "sensor"},
                             {"odrive_d5065", "b_g431b_esc1", "any", 160, "sensor"},
                             {"teknic_m2310p", "frdm_mc_lvpmsm", "any", 130, "observer"},
                             {"teknic_m2310p", "frdm_mc_lvpmsm", "any", 130, "sensor"}};

std::vector<std::string> machine_of(const Driven &one)
{
    return {fmt::format("motor={}", one.motor), fmt::format("board={}", one.board),
            fmt::format("tuning={}", one.tuning),
            fmt::format("drive.angle_source={}", one.angle_source)};
}

// It runs in its mode, then comes the load.
nf::RunResult drive_on(const Driven &one, bool torque, double sign)
{
    std::vector<std::string> set = machine_of(one);
    const char *const command = torque ? "torque_pct" : "speed_pct";
    set.insert(set.end(), {"scenario.duration_s=2.5", "plant.inertia_scale=1", "model.inertia=1",
                           fmt::format("scenario.command=[{{time_s = 0.1, {} = {}}}]", command,
                                       sign * (torque ? 50 : 95)),
                           fmt::format("scenario.load=[{{time_s = 1.5, torque_pct = {}}}]",
                                       -sign * one.load_pct)});
    if (torque) {
        set.insert(set.end(),
                   {"torque_loop.speed_forward_rpm=-1", "torque_loop.speed_backward_rpm=-1"});
    }
    return run(torque ? "s_torque" : "any", {}, set);
}

TEST(test_an_overhauling_load_is_named_overspeed)
{
    for (const Driven &one : DRIVEN) {
        for (const bool torque : {false, true}) {
            for (const double sign : {1.0, -1.0}) {
                const nf::RunResult result = drive_on(one, torque, sign);
                const std::string text =
                    fmt::format("{}, {}, {} mode, {:+.0f}: {}", one.motor, one.angle_source,
                                torque ? "torque" : "speed", sign, list_of(result.faults));
                TEST_ASSERT_EQUAL_size_t_MESSAGE(1, result.faults.size(), text.c_str());
                TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_OVERSPEED, result.faults.front().id,
                                              text.c_str());
            }
        }
    }
}

// Of the highest speed. With an observer the gates are open, and the diodes conduct: the EMF is
// above the bus. Motor B has to be 1.35 times too fast for that; below it is caught, and its
// estimate is judged. With a sensor current control begins at once; the D5065 trips there at a true
// over-current.
struct TooFast {
    Driven machine;
    double share;
};
constexpr TooFast TOO_FAST[] = {{{"motor_a", "bench_310v", "robust_motor_a", 0, "observer"}, 1.3},
                                {{"motor_a", "bench_310v", "robust_motor_a", 0, "observer"}, 1.5},
                                {{"motor_a", "bench_310v", "robust_motor_a", 0, "sensor"}, 1.3},
                                {{"motor_b", "bench_310v", "any", 0, "observer"}, 1.2},
                                {{"motor_b", "bench_310v", "any", 0, "observer"}, 1.4},
                                {{"motor_b", "bench_310v", "any", 0, "observer"}, 1.5},
                                {{"motor_b", "bench_310v", "any", 0, "sensor"}, 1.3},
                                {{"odrive_d5065", "b_g431b_esc1", "any", 0, "observer"}, 1.3},
                                {{"odrive_d5065", "b_g431b_esc1", "any", 0, "observer"}, 1.5},
                                {{"teknic_m2310p", "frdm_mc_lvpmsm", "any", 0, "observer"}, 1.3},
                                {{"teknic_m2310p", "frdm_mc_lvpmsm", "any", 0, "observer"}, 1.5},
                                {{"teknic_m2310p", "frdm_mc_lvpmsm", "any", 0, "sensor"}, 1.3}};

// The first fault of a start with the rotor driven as fast in either direction. What the diodes
// take brakes the shaft, so it is heavy.
void expect_at_start(const TooFast &one, fault_id_t expected)
{
    for (const double sign : {1.0, -1.0}) {
        std::vector<std::string> set = machine_of(one.machine);
        const double max_rpm = nf::load_scenario("any", {}, set).motor.max_speed_rpm;
        set.insert(set.end(),
                   {"scenario.prelude_s=0", "scenario.duration_s=0.5", "plant.inertia_scale=20",
                    fmt::format("scenario.initial_speed_rpm={}", sign * one.share * max_rpm)});
        const nf::RunResult result = run("any", {}, set);
        const std::string text =
            fmt::format("{}, {}, {:.0f} rpm: {}", one.machine.motor, one.machine.angle_source,
                        sign * one.share * max_rpm, list_of(result.faults));
        TEST_ASSERT_TRUE_MESSAGE(!result.faults.empty(), text.c_str());
        TEST_ASSERT_EQUAL_INT_MESSAGE(expected, result.faults.front().id, text.c_str());
    }
}

TEST(test_a_rotor_driven_too_fast_at_a_start_is_named_overspeed)
{
    for (const TooFast &one : TOO_FAST) {
        expect_at_start(one, FAULT_OVERSPEED);
    }
}

// Between 1.25, where the estimate ends, and 1.35: nothing conducts, and the weakened field keeps
// the current in control. The estimate is at its limit for 12 ms, before the 20 ms of OVERSPEED are
// over.
TEST(test_a_rotor_caught_beyond_the_observers_limit_is_stopped)
{
    expect_at_start({{"motor_b", "bench_310v", "any", 0, "observer"}, 1.3},
                    FAULT_SPEED_IMPLAUSIBLE);
}

} // namespace
