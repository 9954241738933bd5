// SPDX-License-Identifier: MIT
// Elastic shafts that make the drive swing, and what notch and low-pass of the torque current do
// about it.
#include "numbers.h"
#include "rules.h"
#include "scenario.h"
#include "speed_margin.h"

#include <cmath>
#include <string>
#include <vector>

#include "testing.h"
#include <fmt/format.h>

namespace
{

using Words = std::vector<std::string>;

// The bandwidth that the rules give motor A on a rigid shaft, and no slower one with a filter.
const Words RIGID = {"speed_loop.bandwidth_hz=14"};

Words operator+(Words words, const Words &more)
{
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

nf::RunResult run(const Words &set)
{
    return nf::run_scenario(nf::load_scenario("any", {}, set));
}

// Of a run with a step of load.
double dip_rpm(const nf::RunResult &result)
{
    TEST_ASSERT_TRUE(result.metrics.speed_dip_rpm.has_value());
    return result.metrics.speed_dip_rpm.value_or(0);
}

struct Shaft {
    double resonance_hz;
    double damping_pct;
    double ratio; // of the inertias, load over rotor
};

Words words_of(const Shaft &shaft)
{
    return {fmt::format("plant.shaft_resonance_hz={}", shaft.resonance_hz),
            fmt::format("plant.shaft_damping_pct={}", shaft.damping_pct),
            fmt::format("plant.load_inertia_ratio={}", shaft.ratio)};
}

Words notch_at(double hz)
{
    return {fmt::format("speed_loop.notch_hz={:.1f}", hz)};
}

// The step of half the rated torque, and what it makes of a free shaft: J·dω/dt = ΔT for both
// masses, and they swing about that with the amplitude ΔT/(J·2πf).
double free_swing_rpm(double resonance_hz)
{
    return 0.5 * 7.8 / (0.003 * nf::TWO_PI * resonance_hz) / nf::rad_s_from_rpm(1);
}

// Nothing swings, and the dip of a step of load is that of a rigid shaft and the shaft's own swing,
// doubled at most: a loop with 30° of margin and more makes little more than twice of any
// frequency.
void assert_quiet(const nf::RunResult &result, double rigid_dip_rpm, double resonance_hz,
                  const std::string &what)
{
    TEST_ASSERT_EQUAL_size_t_MESSAGE(0, result.faults.size(), what.c_str());
    TEST_ASSERT_FALSE_MESSAGE(result.metrics.limit_cycle, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(result.metrics.locked, what.c_str());
    TEST_ASSERT_TRUE_MESSAGE(dip_rpm(result) < rigid_dip_rpm + 2 * free_swing_rpm(resonance_hz),
                             what.c_str());
}

// OSCILLATION, and its frequency. Ten half-waves of 5 slow periods tell it within 4 %, forty within
// 1 %.
double named_hz(const Words &set)
{
    const nf::RunResult result = run(set + Words{"supervision.oscillation_half_waves=40"});
    TEST_ASSERT_EQUAL_size_t(1, result.faults.size());
    TEST_ASSERT_EQUAL_INT(FAULT_OSCILLATION, result.faults.front().id);
    TEST_ASSERT_TRUE(result.faults.front().swing_hz.has_value());
    return result.faults.front().swing_hz.value_or(0);
}

// Steel: 1 to 2 % of damping. The drive swings at its own bandwidth, and with the notch at what the
// fault names it does not; nor with the resonance 7 % lower or a tenth higher than that of the day
// when the notch was set.
TEST(test_a_notch_at_the_frequency_that_the_fault_names_ends_the_swing)
{
    for (const Shaft &shaft : {Shaft{200, 1, 1}, Shaft{200, 1, 2}, Shaft{250, 1, 2}}) {
        const double hz = named_hz(RIGID + words_of(shaft));
        const double rigid_dip_rpm = dip_rpm(run(RIGID + notch_at(hz)));
        TEST_ASSERT_DOUBLE_WITHIN(0.1 * shaft.resonance_hz, shaft.resonance_hz, hz);
        for (const double off : {0.93, 1.0, 1.1}) {
            const Shaft real = {off * shaft.resonance_hz, shaft.damping_pct, shaft.ratio};
            assert_quiet(run(RIGID + notch_at(hz) + words_of(real)), rigid_dip_rpm,
                         real.resonance_hz,
                         fmt::format("{} Hz with the notch at {:.1f} Hz", real.resonance_hz, hz));
        }
    }
}

// Where the loop's own lag is a quarter of a turn it swings above the resonance. The notch there
// moves the swing to the resonance, and the second fault names that.
TEST(test_below_that_the_second_fault_names_the_resonance)
{
    const Words shaft = RIGID + words_of({110, 1, 2});
    const double first_hz = named_hz(shaft);
    const double second_hz = named_hz(shaft + notch_at(first_hz));
    TEST_ASSERT_TRUE(first_hz > 1.1 * 110);
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * 110, 110, second_hz);
    const double rigid_dip_rpm = dip_rpm(run(RIGID + notch_at(second_hz)));
    assert_quiet(run(shaft + notch_at(second_hz)), rigid_dip_rpm, 110, "second");
}

// A notch would have to know the frequency, and from half of the loop's rate on it does not reach
// it.
TEST(test_a_low_pass_ends_the_swing_of_a_stiff_shaft)
{
    const struct {
        Shaft shaft;
        const char *bandwidth;
        const char *low_pass;
    } cases[] = {
        {{300, 2, 5}, "speed_loop.bandwidth_hz=14", "speed_loop.torque_filter_hz=80"},
        {{520, 0.5, 5}, "speed_loop.bandwidth_hz=25", "speed_loop.torque_filter_hz=180"},
    };
    for (const auto &[shaft, bandwidth, low_pass] : cases) {
        const Words set = words_of(shaft) + Words{bandwidth};
        const nf::RunResult without = run(set + Words{"supervision.oscillation=off"});
        TEST_ASSERT_TRUE(without.metrics.limit_cycle || !without.metrics.locked);
        assert_quiet(run(set + Words{low_pass}), dip_rpm(run({bandwidth, low_pass})),
                     shaft.resonance_hz, low_pass);
    }
}

// The phase margin that nfconfig tells is 0 from the bandwidth on at which the drive swings, within
// a tenth.
TEST(test_the_speed_loop_swings_from_where_on_its_margin_is_none)
{
    for (const Words &filter :
         {Words{}, Words{"speed_loop.notch_hz=120"}, Words{"speed_loop.notch_hz=60"},
          Words{"speed_loop.torque_filter_hz=80"}, Words{"speed_loop.torque_filter_hz=40"}}) {
        const nf::Config fast =
            nf::load_scenario("any", {}, filter + Words{"speed_loop.bandwidth_hz=50"});
        const nf::TuningSettings tuning =
            nf::by_rules(fast.tuning, fast.motor, fast.board, fast.model);
        const double end_hz =
            nf::bandwidth_of_margin(tuning, 1 / fast.board.pwm_frequency_hz, 0, 60);
        const auto swings = [&](double hz) {
            const Words set = {fmt::format("speed_loop.bandwidth_hz={}", hz),
                               "supervision.oscillation=off"};
            return run(filter + set).metrics.limit_cycle;
        };
        TEST_ASSERT_FALSE(swings(0.9 * end_hz));
        TEST_ASSERT_TRUE(swings(1.1 * end_hz));
    }
}

} // namespace
