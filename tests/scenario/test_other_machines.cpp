// SPDX-License-Identifier: MIT
// Machines that differ from their file in more than a value: pole pairs, wires, drifting sensors, a
// propeller.
#include "measured.h"
#include "scenario.h"

extern "C" {
#include "plant.h"
}

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "testing.h"

namespace
{

using Words = std::vector<std::string>;

constexpr double RPM_PER_RAD_S = 30 / 3.14159265358979323846;

// The last tick of a run, and what came before it.
class Last : public nf::TickSink
{
public:
    explicit Last(double full_scale_a) : base_a_(2 * full_scale_a)
    {
    }

    void add(const nf::Tick &tick) override
    {
        constexpr double share = 0.01; // of a low-pass over some electrical turns
        const plant_view_t &t = tick.truth;
        speed_rpm = t.omega_mech_rad_s * RPM_PER_RAD_S;
        torque_nm += share * (t.torque_nm - torque_nm);
        const sample_t seen = nf::measured(tick).sample;
        offset_a[0] += share * (seen.phase_a / 32768.0 * base_a_ - t.i_abc_a[0] - offset_a[0]);
        offset_a[1] += share * (seen.phase_b / 32768.0 * base_a_ - t.i_abc_a[1] - offset_a[1]);
        time_s = tick.time_s;
    }

    double speed_rpm = 0;
    double torque_nm = 0;
    std::array<double, 2> offset_a = {0, 0};
    double time_s = 0;

private:
    double base_a_; // I_b
};

struct Outcome {
    nf::RunResult result;
    Last last;
};

Outcome run(const Words &set)
{
    const nf::Config config = nf::load_scenario("any", {}, set);
    Outcome outcome = {{}, Last(config.board.current_full_scale_a)};
    nf::RunOptions options;
    options.sink = &outcome.last;
    outcome.result = nf::run_scenario(config, options);
    return outcome;
}

const Words UNLOADED = {"scenario.load=[{time_s=0, torque_nm=0}]"};

Words operator+(Words words, const Words &more)
{
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// Twice the pole pairs of the file make half of the speed, and the drive does not see it.
TEST(test_other_pole_pairs_than_the_files_scale_the_speed)
{
    constexpr double CLOSE = 0.01;
    for (const auto &[pairs, share] :
         {std::pair(4, 0.5), std::pair(3, 2.0 / 3), std::pair(1, 2.0)}) {
        const std::string set = "plant.pole_pairs=" + std::to_string(pairs);
        const Words slow = {"scenario.command=[{time_s=0.1, speed_rpm=800}]"};
        const Outcome found = run(UNLOADED + slow + Words{set});
        TEST_ASSERT_EQUAL_size_t_MESSAGE(0, found.result.faults.size(), set.c_str());
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(CLOSE * 800 * share, 800 * share, found.last.speed_rpm,
                                          set.c_str());
        TEST_ASSERT_FALSE_MESSAGE(found.result.metrics.locked, set.c_str());
    }
}

TEST(test_two_exchanged_wires_turn_the_shaft_the_other_way)
{
    constexpr double CLOSE = 2; // rpm
    for (const char *const wires : {"acb", "bac", "cba"}) {
        const Outcome found = run(UNLOADED + Words{std::string("plant.wires=") + wires});
        TEST_ASSERT_EQUAL_size_t_MESSAGE(0, found.result.faults.size(), wires);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(CLOSE, -1800, found.last.speed_rpm, wires);
    }
}

TEST(test_three_wires_in_a_ring_make_no_difference)
{
    const nf::RunResult as_named = run({}).result;
    for (const char *const wires : {"bca", "cab"}) {
        const nf::RunResult turned = run({std::string("plant.wires=") + wires}).result;
        TEST_ASSERT_TRUE_MESSAGE(turned.metrics.locked, wires);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.05, *as_named.metrics.angle_error_rms_deg,
                                          *turned.metrics.angle_error_rms_deg, wires);
    }
}

// A fault of the wire at leg a opens the phase that hangs there.
TEST(test_an_open_wire_is_that_of_the_leg)
{
    const Words open = {"scenario.fault=[{time_s=1, what=\"phase_a_open\"}]"};
    const nf::RunResult found = run(open + Words{"plant.wires=bca"}).result;
    TEST_ASSERT_EQUAL_size_t(1, found.faults.size());
    TEST_ASSERT_EQUAL(run(open).result.faults.front().id, found.faults.front().id);
}

// Calibration takes 2^n samples after power-up: their mean lies half of them late. Half a count is
// rounding, and as much is what the low-pass leaves of the ripple.
TEST(test_the_offset_drifts_from_the_calibration_on)
{
    const Outcome found = run(UNLOADED + Words{"plant.adc_drift_lsb_s=[20, -10]"});
    const nf::Config config = nf::load_scenario("any");
    const double count_a =
        config.board.current_full_scale_a / std::ldexp(1.0, config.board.adc_bits - 1);
    const double since_s = found.last.time_s + config.scenario.prelude_s;
    TEST_ASSERT_TRUE(found.result.metrics.locked);
    TEST_ASSERT_DOUBLE_WITHIN(count_a + 0.1 * 20 * count_a, 20 * since_s * count_a,
                              found.last.offset_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(count_a + 0.1 * 10 * count_a, -10 * since_s * count_a,
                              found.last.offset_a[1]);
}

// T = T_r·(ω/ω_r)², beside the friction of the file: 0.001 N·m·s.
TEST(test_a_propeller_takes_torque_with_the_square_of_the_speed)
{
    for (const char *const shaft : {"plant.shaft_resonance_hz=0", "plant.shaft_resonance_hz=150"}) {
        for (const double rpm : {600.0, 1200.0, 1800.0, -1200.0}) {
            const std::string command =
                "scenario.command=[{time_s=0.1, speed_rpm=" + std::to_string(rpm) + "}]";
            const Outcome found = run(UNLOADED + Words{"plant.fan_torque_nm=4", command, shaft});
            const double share = rpm / 1800;
            const double expected = 4 * share * std::abs(share) + 0.001 * rpm / RPM_PER_RAD_S;
            TEST_ASSERT_TRUE_MESSAGE(found.result.metrics.locked, command.c_str());
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.02 * std::abs(expected), expected,
                                              found.last.torque_nm, command.c_str());
        }
    }
}

} // namespace
