// SPDX-License-Identifier: MIT
// A tick computed again: within the roundings as long as nothing is wrong, and at the right
// function or word when something is.
#include "diff.h"
#include "set.h"
#include "timeline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "testing.h"

using nf::debug::Comparison;
using nf::debug::diff_tick;
using nf::debug::first_departure;
using nf::debug::set_signal;
using nf::debug::Span;
using nf::debug::Timeline;

// Each value has to come near its tolerance somewhere, or the tolerance would see nothing. Where
// nothing is rounded, both agree to the last bits of a double: of some units that are converted
// there and back.
static constexpr double LEAST_SHARE = 0.2;
static constexpr double EXACT_SHARE = 1e-9;
static constexpr double LAST_BITS = 8 * std::numeric_limits<double>::epsilon();

// Each function of a control module that the drive calls; configuration, model and state beside
// them.
static constexpr std::size_t SEAMS = 23 + 3;

struct Shares {
    std::set<std::string> functions;
    std::map<std::string, double> largest; // of the tolerance, by quantity
    std::string worst;                     // a row that departs
};

static void take(const std::vector<Comparison> &rows, int64_t tick, Shares &shares)
{
    for (const Comparison &row : rows) {
        const double apart = std::abs(row.drive - row.reference);
        shares.functions.insert(row.module);
        if (row.tolerance > 0 && apart > LAST_BITS * std::abs(row.reference)) {
            double &share = shares.largest[row.module + ' ' + row.quantity];
            share = std::max(share, apart / row.tolerance);
        }
        if (row.departs() && shares.worst.empty()) {
            shares.worst = fmt::format("tick {}: {} {}: {} and {}, tolerance {}", tick, row.module,
                                       row.quantity, row.drive, row.reference, row.tolerance);
        }
    }
}

static void take_run(const char *scenario, const std::vector<std::string> &with, Shares &shares,
                     const std::vector<std::string> &set = {})
{
    const nf::Config config = nf::load_scenario(scenario, with, set);
    const drive_cfg_t built = nf::build(config);
    Timeline timeline(config);

    do {
        take(diff_tick(timeline.before(), timeline.tick(), built), timeline.now(), shares);
    } while (timeline.step() && shares.worst.empty());
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", shares.worst.c_str(), scenario);
}

TEST(test_every_tick_of_the_scenarios_is_within_its_roundings)
{
    Shares shares;

    take_run("s1", {}, shares);
    take_run("s1_robust", {"all"}, shares);
    take_run("s2_robust", {"imp"}, shares,
             {"observer.feedback=0.08", "plant.saliency_scale=1.1", "speed_loop.notch_hz=150",
              "speed_loop.torque_filter_hz=200"});
    take_run("s3_robust", {"deadtime"}, shares);
    take_run("s2_motor_b", {"adc"}, shares);
    take_run("s4", {"encoder"}, shares);
    take_run("s5", {"adc"}, shares);
    TEST_ASSERT_EQUAL_size_t(SEAMS, shares.functions.size());
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

static Timeline &with_a_notch()
{
    static const nf::Config config =
        nf::load_scenario("s1_robust", {}, {"speed_loop.notch_hz=150"});
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

static std::vector<Comparison> diff_now(Timeline &timeline)
{
    return diff_tick(timeline.before(), timeline.tick(), timeline.run().sim().cfg());
}

// What the firmware's function computes from the next call on, for this name.
static std::string spoiled;

template <typename Number> static Number spoil(const char *function, Number value, Number by)
{
    return static_cast<Number>(value + (spoiled == function ? by : 0));
}

extern "C" {
decltype(transforms_clarke) __real_transforms_clarke;
decltype(nn_observer_predict) __real_nn_observer_predict;
decltype(nn_observer_train) __real_nn_observer_train;
decltype(speed_loop_step) __real_speed_loop_step;
decltype(pi_step) __real_pi_step;
decltype(phase_compensator_step) __real_phase_compensator_step;
decltype(torque_filter_step) __real_torque_filter_step;
decltype(virtual_resistance_step) __real_virtual_resistance_step;
decltype(current_loop_step) __real_current_loop_step;
decltype(modulator_compare) __real_modulator_compare;

ab_t __wrap_transforms_clarke(int32_t a, int32_t b)
{
    const ab_t v = __real_transforms_clarke(a, b);
    return {v.alpha, spoil("transforms_clarke", v.beta, 2)};
}

void __wrap_nn_observer_predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                                ab_t voltage, sincos_t angle)
{
    __real_nn_observer_predict(obs, cfg, measured, voltage, angle);
    obs->alpha_q27 = spoil("nn_observer_predict", obs->alpha_q27, 1 << 18);
}

void __wrap_nn_observer_train(nn_observer_t *obs, const nn_observer_cfg_t *cfg)
{
    __real_nn_observer_train(obs, cfg);
    obs->speed_out = spoil("nn_observer_train", obs->speed_out, 5);
}

int32_t __wrap_speed_loop_step(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                               step_t measured, torque_range_t range)
{
    const int32_t torque = __real_speed_loop_step(loop, cfg, reference, measured, range);
    return spoil("speed_loop_step", torque, 40);
}

int32_t __wrap_pi_step(pi_t *pi, const pi_cfg_t *cfg, int32_t error, int32_t forward, int32_t limit)
{
    return spoil("pi_step", __real_pi_step(pi, cfg, error, forward, limit), 4);
}

int32_t __wrap_phase_compensator_step(phase_compensator_t *comp, const phase_compensator_cfg_t *cfg,
                                      dq_t current, angle_t rotor, step_t speed, bool forwards)
{
    const int32_t lead = __real_phase_compensator_step(comp, cfg, current, rotor, speed, forwards);
    comp->angle = spoil("phase_compensator_step", comp->angle, 4U);
    return lead;
}

int32_t __wrap_torque_filter_step(torque_filter_t *filter, const torque_filter_cfg_t *cfg,
                                  int32_t current)
{
    return spoil("torque_filter_step", __real_torque_filter_step(filter, cfg, current), 1);
}

dq_t __wrap_virtual_resistance_step(virtual_resistance_t *res, const virtual_resistance_cfg_t *cfg,
                                    dq_t current)
{
    const dq_t drop = __real_virtual_resistance_step(res, cfg, current);
    return {drop.d, spoil("virtual_resistance_step", drop.q, 1 << 15)};
}

dq_t __wrap_current_loop_step(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                              dq_t measured, int32_t limit)
{
    const dq_t v = __real_current_loop_step(loop, cfg, reference, measured, limit);
    return {spoil("current_loop_step", v.d, 10), v.q};
}

void __wrap_modulator_compare(const modulator_cfg_t *cfg, ab_t ratio, compare_t *out)
{
    __real_modulator_compare(cfg, ratio, out);
    out->phase[1] = spoil("modulator_compare", out->phase[1], uint16_t{400});
}
}

static void expect_function(Timeline &timeline, const char *function)
{
    TEST_ASSERT_NULL(first_departure(diff_now(timeline)));
    spoiled = function;
    const std::vector<Comparison> rows = diff_now(timeline);
    spoiled.clear();
    TEST_ASSERT_NOT_NULL_MESSAGE(first_departure(rows), function);
    TEST_ASSERT_EQUAL_STRING(function, first_departure(rows)->module.c_str());
}

static void to_end_of_slow_period(Timeline &timeline)
{
    while (timeline.before().slow_count != 1U) {
        timeline.step();
    }
}

TEST(test_a_function_that_computes_wrongly_is_named)
{
    Timeline &run = running();
    Timeline &voltage = driven_by_voltage();

    for (const char *const function :
         {"transforms_clarke", "nn_observer_predict", "nn_observer_train", "current_loop_step",
          "modulator_compare"}) {
        expect_function(run, function);
    }
    expect_function(voltage, "phase_compensator_step");
    expect_function(voltage, "virtual_resistance_step");
    to_end_of_slow_period(run);
    expect_function(run, "speed_loop_step");
    Timeline &notch = with_a_notch();
    to_end_of_slow_period(notch);
    expect_function(notch, "torque_filter_step");
    to_end_of_slow_period(voltage);
    expect_function(voltage, "pi_step");
}

static void expect_first(Timeline &timeline, const char *assignment, const char *module)
{
    const std::string name = std::string(assignment).substr(0, std::string(assignment).find(' '));
    const std::string plain = name.substr(0, name.find(".raw"));

    TEST_ASSERT_NULL(first_departure(diff_now(timeline)));
    (void)set_signal(timeline, assignment, Span::once);
    const std::vector<Comparison> rows = diff_now(timeline);
    const Comparison *const first = first_departure(rows);
    TEST_ASSERT_NOT_NULL_MESSAGE(first, assignment);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(module, first->module.c_str(), assignment);
    TEST_ASSERT_EQUAL_STRING(plain.substr(plain.size() - first->quantity.size()).c_str(),
                             first->quantity.c_str());
    TEST_ASSERT_TRUE(timeline.release(plain));
    TEST_ASSERT_NULL(first_departure(diff_now(timeline)));
}

TEST(test_a_wrong_word_is_named)
{
    expect_first(running(), "drive.motor.model.observer.volt_gain.raw = 9000", "model");
    expect_first(running(), "drive.motor.model.observer.feedback_q15.raw = 9000", "model");
    expect_first(running(), "drive.motor.model.run_loop.pi_q.kp.raw = 1", "model");
    expect_first(running(), "drive.bus = 5", "state");
    expect_first(running(), "drive.control.current_loop.constant.d.raw = 9", "state");
    expect_first(running(), "drive.control.current_loop.reactance_q14.q.raw = 9", "state");
    expect_first(running(), "drive.rotor.observer.half_step_q15.raw = 9", "state");
    expect_first(running(), "drive.rotor.observer.alpha_q27 = 1", "state");
    expect_first(running(), "drive.rotor.observer.rotated_error.q = 1", "state");
    expect_first(running(), "drive.control.voltage.q = 10", "state");
    expect_first(running(), "drive.control.ratio_next.alpha = 0.3", "state");
    expect_first(running(), "drive.rotor.position.turns_q32 = 0.25", "state");
    expect_first(running(), "drive.motion.speed_loop.pi.integral_q26.raw = 0", "state");
    expect_first(driven_by_voltage(), "drive.vector.step = 500", "state");
    expect_first(driven_by_voltage(), "drive.voltage_drive.compensator.angle = 0.1", "state");
    expect_first(driven_by_voltage(), "drive.voltage_drive.magnitude = 5", "state");
    expect_first(driven_by_voltage(), "drive.voltage_drive.damping.mean_q30.q = 1", "state");
}

TEST(test_a_wrong_configuration_is_named_with_its_word)
{
    const nf::Config config = nf::load_scenario("s1_robust");
    Timeline timeline(config);
    const drive_cfg_t built = nf::build(config);

    (void)set_signal(timeline, "cfg.speed_loop.pi.kp.raw = 77", Span::once);
    timeline.step();
    const std::vector<Comparison> diff = diff_tick(timeline.before(), timeline.tick(), built);
    const Comparison *const first = first_departure(diff);
    TEST_ASSERT_NOT_NULL(first);
    TEST_ASSERT_EQUAL_STRING("configuration", first->module.c_str());
    TEST_ASSERT_EQUAL_STRING("cfg.speed_loop.pi.kp", first->quantity.c_str());
    TEST_ASSERT_EQUAL_DOUBLE(77, first->drive);
    TEST_ASSERT_EQUAL_DOUBLE(built.speed_loop.pi.kp, first->reference);
}
