// SPDX-License-Identifier: MIT
// Drives that swing at a constant command: each ends in OSCILLATION or goes on calm. Healthy ones
// do not come near.
#include "scenario.h"

extern "C" {
#include "fault_text.h"
}

#include <algorithm>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using Words = std::vector<std::string>;

nf::RunResult run(const std::string &scenario, const Words &with, const Words &set,
                  nf::TickSink *sink = nullptr)
{
    nf::RunOptions options;
    options.sink = sink;
    return nf::run_scenario(nf::load_scenario(scenario, with, set), options);
}

Words operator+(Words words, const Words &more)
{
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

Words shaft(double resonance_hz, double damping_pct, double ratio)
{
    return {fmt::format("plant.shaft_resonance_hz={}", resonance_hz),
            fmt::format("plant.shaft_damping_pct={}", damping_pct),
            fmt::format("plant.load_inertia_ratio={}", ratio)};
}

const Words OFF = {"supervision.oscillation=off"};
const Words LOWER = {"supervision.oscillation=lower"};
const Words FAULT = {"supervision.oscillation=fault"};
const Words STIFF_LOAD = shaft(100, 0.5, 5);
const Words SOFT_LOAD = shaft(70, 2, 5);

void assert_ends_in_oscillation(const nf::RunResult &result, const char *what)
{
    TEST_ASSERT_EQUAL_size_t_MESSAGE(1, result.faults.size(), what);
    const fault_t &fault = result.faults.front();
    TEST_ASSERT_EQUAL_STRING_MESSAGE("OSCILLATION", fault_text(fault.id)->name, what);
    TEST_ASSERT_TRUE_MESSAGE(fault.value >= fault.limit, what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_STATE_FAULT, result.state_final, what);
    TEST_ASSERT_EQUAL_size_t_MESSAGE(1, result.notes.size(), what);
}

// Without the supervision it runs on for ever.
TEST(test_an_elastic_shaft_that_swings_is_a_fault)
{
    const nf::RunResult unwatched = run("any", {}, STIFF_LOAD + OFF);
    TEST_ASSERT_TRUE(unwatched.metrics.limit_cycle);
    TEST_ASSERT_EQUAL_size_t(0, unwatched.faults.size());
    TEST_ASSERT_EQUAL_size_t(0, unwatched.notes.size());
    assert_ends_in_oscillation(run("any", {}, STIFF_LOAD + FAULT), "motor A");
    assert_ends_in_oscillation(run("any", {}, STIFF_LOAD + Words{"motor=motor_b"} + FAULT),
                               "motor B");
}

// The supply drops to what the drive bears just so, or the power stage becomes as hot: the drive
// gives way until the rotor rests, and accelerates again. No swing of it, and no ripple: the
// cogging is zero.
TEST(test_a_drive_that_gives_way_rests_and_comes_back_does_not_swing)
{
    constexpr double NO_RIPPLE_PCT = 1; // of rated speed
    const Words idle = {"scenario.load=[{time_s=0,torque_nm=0}]", "plant.coulomb_friction_nm=3"};
    const char *const disturbances[] = {
        "{time_s=1.2,what=\"bus_voltage\",value=201,until_s=1.6}",
        "{time_s=1.0,what=\"bus_voltage\",value=201,until_s=1.1},"
        "{time_s=1.2,what=\"bus_voltage\",value=202,until_s=1.3},"
        "{time_s=1.4,what=\"bus_voltage\",value=203,until_s=1.5}",
        "{time_s=1.2,what=\"temperature\",value=99,until_s=1.6}",
    };
    for (const char *const disturbance : disturbances) {
        const nf::RunResult result =
            run("any", {}, idle + Words{fmt::format("scenario.fault=[{}]", disturbance)});
        TEST_ASSERT_TRUE_MESSAGE(result.metrics.locked, disturbance);
        TEST_ASSERT_FALSE_MESSAGE(result.metrics.limit_cycle, disturbance);
        TEST_ASSERT_TRUE_MESSAGE(*result.metrics.ripple_speed_pct < NO_RIPPLE_PCT, disturbance);
    }
}

// When the true torque current passed zero in RUN. After a fault the shaft swings on by itself, at
// another frequency.
class Passages : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        const bool forwards =
            forwards_ ? tick.truth.i_q_a > -RIPPLE_A : tick.truth.i_q_a > RIPPLE_A;
        if (tick.sim->drive().state == DRIVE_STATE_RUN && forwards != forwards_) {
            times_s.push_back(tick.time_s);
        }
        forwards_ = forwards;
    }

    std::vector<double> times_s;

private:
    static constexpr double RIPPLE_A =
        1; // near zero the current may pass it twice; the swing has ten times as much

    bool forwards_ = false;
};

// The frequency that a person is told is that of the swing's 40 half-waves. Each of their ends is
// on a grid of 1 ms, and they take 3 ms and more.
TEST(test_the_frequency_is_that_of_the_swing)
{
    constexpr std::size_t HALVES = 40;
    Passages truth;
    const Words many = {fmt::format("supervision.oscillation_half_waves={}", HALVES)};
    const nf::RunResult result = run("any", {}, STIFF_LOAD + FAULT + many, &truth);
    const double told_hz =
        std::stod(result.notes.front().substr(result.notes.front().find(" at ") + 4));
    TEST_ASSERT_TRUE(truth.times_s.size() > HALVES);
    const double time_s = truth.times_s.back() - truth.times_s[truth.times_s.size() - 1 - HALVES];
    TEST_ASSERT_DOUBLE_WITHIN(2.0 / (HALVES * 3) * told_hz, HALVES / (2 * time_s), told_hz);
}

// What is left after the first half of the run is calm, with the same load step in it.
TEST(test_half_the_bandwidth_ends_the_swing_of_an_elastic_shaft)
{
    const Words late = SOFT_LOAD + Words{"scenario.evaluate_from_s=1.2"};
    TEST_ASSERT_TRUE(run("any", {}, late + OFF).metrics.limit_cycle);
    const nf::RunResult lowered = run("any", {}, late + LOWER);
    TEST_ASSERT_EQUAL_size_t(0, lowered.faults.size());
    TEST_ASSERT_EQUAL_size_t(1, lowered.notes.size());
    TEST_ASSERT_FALSE(lowered.metrics.limit_cycle);
    TEST_ASSERT_TRUE(lowered.metrics.locked);
}

TEST(test_half_the_bandwidth_ends_the_swing_of_a_speed_loop_that_is_too_fast)
{
    const Words fast = {"observer.kappa=0.015", "observer.kappa_p=0.3", // twice the lag of the rule
                        "speed_loop.bandwidth_hz=54", "scenario.evaluate_from_s=1.2"};
    TEST_ASSERT_TRUE(run("any", {"adc"}, fast + OFF).metrics.limit_cycle);
    const nf::RunResult lowered = run("any", {"adc"}, fast + LOWER);
    TEST_ASSERT_EQUAL_size_t(0, lowered.faults.size());
    TEST_ASSERT_EQUAL_size_t(1, lowered.notes.size());
    TEST_ASSERT_FALSE(lowered.metrics.limit_cycle);
}

// The slower loop does not help here, and the second swing is the fault.
TEST(test_what_half_the_bandwidth_does_not_end_is_a_fault)
{
    for (const char *motor : {"motor_a", "motor_b"}) {
        const nf::RunResult result =
            run("any", {}, STIFF_LOAD + Words{fmt::format("motor={}", motor)} + LOWER);
        assert_ends_in_oscillation(result, motor);
        TEST_ASSERT_TRUE(result.notes.front().find("half its bandwidth") != std::string::npos);
    }
}

// The law as published swings with an inverter that has dead time.
TEST(test_a_swing_of_the_observer_is_a_fault)
{
    assert_ends_in_oscillation(run("s1", {"deadtime"}, FAULT), "s1 deadtime");
}

// The longest run of half-waves.
class Longest : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        halves = std::max(halves, tick.sim->drive().watch.oscillation.halves);
    }

    uint32_t halves = 0;
};

// What holds its rotor counts to less than half of the 10 half-waves: steps of command and load,
// ramps, reversals, positions, cogging, harmonics, noise, dead time, a wrong model.
TEST(test_healthy_drives_do_not_come_near)
{
    struct Case {
        const char *scenario;
        Words with;
        Words set;
    };
    const Words ripple = {"plant.cogging_pct=3", "plant.emf_5th_pct=2", "plant.emf_7th_pct=1"};
    const Words reversals = {
        "scenario.command=[{time_s = 0.1, speed_pct = 50}, {time_s = 0.7, speed_pct = -50}, "
        "{time_s = 1.4, speed_pct = 10}]"};
    const Words sets = {"ideal", "adc", "hot", "deadtime", "saturated", "imp", "all"};
    std::vector<Case> cases = {
        {"any", {"all"}, ripple},
        {"any", {"all"}, reversals},
        {"any", {"all"}, Words{"motor=motor_b"} + ripple},
        {"s1", {"adc"}, {}},
        {"s2", {"adc"}, {}},
        {"s3", {"adc"}, {}},
        {"s4", {"all"}, {}},
        {"s5", {"saturated"}, {}},
    };
    for (const std::string &set : sets) {
        for (const char *scenario : {"any", "s1_robust", "s2_robust", "s3_robust"}) {
            cases.push_back({scenario, {set}, {}});
        }
        for (const char *scenario : {"any", "s1_robust"}) {
            cases.push_back({scenario, {set}, {"motor=motor_b"}});
        }
    }
    for (const Case &one : cases) {
        Longest longest;
        const nf::RunResult result = run(one.scenario, one.with, one.set + FAULT, &longest);
        const std::string text = fmt::format("{} with {}: {} half-waves", one.scenario,
                                             one.with.front(), longest.halves);
        TEST_ASSERT_EQUAL_size_t_MESSAGE(0, result.faults.size(), text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(longest.halves < 5, text.c_str());
    }
}

} // namespace
