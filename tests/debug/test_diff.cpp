// SPDX-License-Identifier: MIT
// A tick beside its twins: within the roundings as long as nothing is wrong, and at the right module when something is.
#include "diff.h"
#include "set.h"
#include "timeline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "unity.h"

using nf::debug::Comparison;
using nf::debug::Diff;
using nf::debug::diff_tick;
using nf::debug::first_departure;
using nf::debug::set_signal;
using nf::debug::Span;
using nf::debug::Timeline;

void setUp()
{
}

void tearDown()
{
}

// Each value has to come near its tolerance somewhere, or the tolerance would see nothing. Where nothing is rounded,
// both agree to the last bits of a double.
static constexpr double LEAST_SHARE = 0.2;
static constexpr double EXACT_SHARE = 1e-9;

struct Shares {
    std::map<std::string, double> largest; // of the tolerance, by quantity
    std::string worst;                     // a row that departs
};

static void take(const Diff &diff, int64_t tick, Shares &shares)
{
    for (const Comparison &row : diff.rows) {
        const double apart = std::abs(row.drive - row.reference);
        if (row.tolerance > 0) {
            double &share = shares.largest[row.module + ' ' + row.quantity];
            share = std::max(share, apart / row.tolerance);
        }
        if (row.departs() && shares.worst.empty()) {
            shares.worst = fmt::format("tick {}: {} {}: {} and {}, tolerance {}", tick, row.module,
                                       row.quantity, row.drive, row.reference, row.tolerance);
        }
    }
}

static void take_run(const char *scenario, const std::vector<std::string> &with, Shares &shares)
{
    const nf::Config config = nf::load_scenario(scenario, with);
    const drive_cfg_t built = nf::build(config);
    Timeline timeline(config);

    do {
        take(diff_tick(timeline.before(), timeline.tick(), built), timeline.now(), shares);
    } while (timeline.step() && shares.worst.empty());
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", shares.worst.c_str(), scenario);
}

static void test_every_tick_of_the_scenarios_is_within_its_roundings()
{
    Shares shares;

    take_run("s1", {}, shares);
    take_run("s1_robust", {"all"}, shares);
    take_run("s2_robust", {"imp"}, shares);
    take_run("s3_robust", {"deadtime"}, shares);
    take_run("s2_motor_b", {"adc"}, shares);
    take_run("s4", {"encoder"}, shares);
    take_run("s5", {"adc"}, shares);
    for (const auto &[quantity, share] : shares.largest) {
        fmt::print("{}: {:.3f} of its tolerance\n", quantity, share);
        TEST_ASSERT_TRUE_MESSAGE(share < EXACT_SHARE || share > LEAST_SHARE, quantity.c_str());
    }
}

static Timeline &running()
{
    static const nf::Config config = nf::load_scenario("s1_robust");
    static Timeline timeline(config);
    timeline.go_to(timeline.run().tick_at(0.5));
    return timeline;
}

static Timeline &driven_by_voltage()
{
    static const nf::Config config = nf::load_scenario("s4");
    static Timeline timeline(config);
    timeline.go_to(timeline.run().tick_at(0.5));
    return timeline;
}

static void expect_first(Timeline &timeline, const char *assignment, const char *module)
{
    const drive_cfg_t built = timeline.run().sim().cfg();
    const std::string name = std::string(assignment).substr(0, std::string(assignment).find(' '));

    TEST_ASSERT_NULL(first_departure(diff_tick(timeline.before(), timeline.tick(), built)));
    (void)set_signal(timeline, assignment, Span::once);
    const Diff diff = diff_tick(timeline.before(), timeline.tick(), built);
    const Comparison *const first = first_departure(diff);
    TEST_ASSERT_NOT_NULL_MESSAGE(first, assignment);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(module, first->module.c_str(), assignment);
    const std::string plain = name.substr(0, name.find(".raw"));
    TEST_ASSERT_TRUE(timeline.release(plain));
    TEST_ASSERT_NULL(first_departure(diff_tick(timeline.before(), timeline.tick(), built)));
}

static void test_a_wrong_result_is_named_by_its_module()
{
    expect_first(running(), "drive.model.observer.volt_gain.raw = 9000", "model");
    expect_first(running(), "drive.model.run_loop.pi_q.kp.raw = 1", "model");
    expect_first(running(), "drive.signals.phase_a = 5", "sampling");
    expect_first(running(), "drive.signals.current_ab.beta = 5", "Clarke");
    expect_first(running(), "drive.signals.current.q = 5", "Park");
    expect_first(running(), "drive.signals.voltage_applied.alpha = 100", "applied voltage");
    expect_first(running(), "drive.observer.alpha_q27 = 1", "observer network");
    expect_first(running(), "drive.observer.current.d = 1", "observer network");
    expect_first(running(), "drive.observer.turned.q = 1", "observer network");
    expect_first(running(), "drive.observer.descent.raw = 3000", "observer training");
    expect_first(running(), "drive.observer.speed = 300", "observer training");
    expect_first(running(), "drive.observer.speed_out = 300", "observer training");
    expect_first(running(), "drive.signals.voltage_limit = 10", "current loop");
    expect_first(running(), "drive.signals.voltage.q = 10", "current loop");
    expect_first(running(), "drive.signals.ratio_ab.alpha = 0.3", "modulator");
    expect_first(running(), "drive.position.turns_q32 = 0.25", "rotor position");
}

static void test_a_wrong_result_of_the_voltage_drive_is_named_by_its_module()
{
    Timeline &timeline = driven_by_voltage();

    TEST_ASSERT_TRUE(timeline.tick().sim->drive().voltage_driven);
    expect_first(timeline, "drive.frame_speed = 500", "angle sensor");
    expect_first(timeline, "drive.compensator.current_angle = 0.1", "phase compensator");
    expect_first(timeline, "drive.compensator.angle = 0.1", "phase compensator");
    expect_first(timeline, "drive.signals.voltage.d = 1", "voltage drive");
    expect_first(timeline, "drive.signals.current_ref.q = 1", "voltage drive");
    while (timeline.before().slow_count != 1U) {
        timeline.step();
    }
    expect_first(timeline, "drive.voltage_magnitude = 5", "voltage magnitude");
    expect_first(timeline, "drive.speed_loop.pi.integral_q26 = 5", "voltage magnitude");
}

static void test_a_wrong_result_of_the_slow_period_is_named_by_its_module()
{
    Timeline &timeline = running();

    while (timeline.before().slow_count != 2U) {
        timeline.step();
    }
    expect_first(timeline, "drive.speed_reference = 10", "speed plan");
    timeline.step();
    expect_first(timeline, "drive.signals.current_ref.q = 9", "speed loop");
    expect_first(timeline, "drive.speed_loop.pi.integral_q26.raw = 0", "speed loop");
}

static void test_a_wrong_configuration_is_named_with_its_word()
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    const drive_cfg_t built = nf::build(config);

    (void)set_signal(timeline, "cfg.speed_loop.pi.kp.raw = 77", Span::once);
    timeline.step();
    const Diff diff = diff_tick(timeline.before(), timeline.tick(), built);
    const Comparison *const first = first_departure(diff);
    TEST_ASSERT_NOT_NULL(first);
    TEST_ASSERT_EQUAL_STRING("configuration", first->module.c_str());
    TEST_ASSERT_EQUAL_STRING("cfg.speed_loop.pi.kp", first->quantity.c_str());
    TEST_ASSERT_EQUAL_DOUBLE(77, first->drive);
    TEST_ASSERT_EQUAL_DOUBLE(built.speed_loop.pi.kp, first->reference);
}

int main()
{
    UNITY_BEGIN();
    RUN_TEST(test_every_tick_of_the_scenarios_is_within_its_roundings);
    RUN_TEST(test_a_wrong_result_is_named_by_its_module);
    RUN_TEST(test_a_wrong_result_of_the_voltage_drive_is_named_by_its_module);
    RUN_TEST(test_a_wrong_result_of_the_slow_period_is_named_by_its_module);
    RUN_TEST(test_a_wrong_configuration_is_named_with_its_word);
    return UNITY_END();
}
