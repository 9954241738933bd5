// SPDX-License-Identifier: MIT
// The loop with its controller: matrices, stability, step responses, the drive's gains.
#include "drive_gains.h"
#include "origin.h"
#include "shipped.h"
#include "testing.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace test;

namespace
{

constexpr double ROUNDING = 1e-12;
// The paper prints gains and poles with three to six digits.
constexpr double POLE_PRINT = 5e-6;
constexpr double ONE_PERCENT = 0.01;

// A motor that is an integrator: speed(n+1) = speed(n) + supply(n) − load(n); the rest decays at
// once.
Discrete integrator()
{
    Discrete d{MotorMatrix::Zero(), MotorInputs::Zero(), 1};
    d.phi(SPEED, SPEED) = 1;
    d.theta(SPEED, LOAD) = -1;
    d.theta(SPEED, SUPPLY) = 1;
    return d;
}

double magnitude(const Discrete &motor, const Gains &gains)
{
    return std::abs(slowest_pole(motor, gains));
}

TEST(the_loop_is_the_motor_under_the_controllers_output)
{
    const Discrete &motor = computed();
    LoopState x;
    x << 0.3, -0.2, 0.5, 0.01, -4;
    const double command = 0.7;
    const Loop loop = close_loop(motor, PUBLISHED);
    const LoopState next = loop.a * x + loop.b.col(SUPPLY) * command + loop.b.col(LOAD) * 2;
    // (34) written out, then (25) and (32).
    const double kt = 0.035 * 0.01;
    const double supply = kt * x[INTEGRAL] + (0.264 + kt) * (command - x[SPEED]);
    const Eigen::Vector4d expected =
        motor.phi * x.head<MOTOR_STATES>() + motor.theta * Eigen::Vector2d(2, supply);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, supply, controller_output(motor, PUBLISHED, x, command));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0,
                              (expected - next.head<MOTOR_STATES>()).cwiseAbs().maxCoeff());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, x[INTEGRAL] + command - x[SPEED], next[INTEGRAL]);
}

TEST(the_controllers_step_response_is_that_of_backward_differences)
{
    // (29): K_p + K_i·T·(n+1) at sample n of a constant error of 1.
    LoopState x = LoopState::Zero();
    for (int n = 0; n < 5; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.264 + 0.035 * 0.01 * (n + 1),
                                  controller_output(computed(), PUBLISHED, x, 1));
        x[INTEGRAL] += 1;
    }
}

TEST(phase_states_integrate_speed_and_leave_the_motor_alone)
{
    const PhaseLoop phase = add_phase_states(computed(), PUBLISHED, 0.9);
    const Loop loop = close_loop(computed(), PUBLISHED);
    Eigen::Matrix<double, PHASE_STATE_COUNT, 1> x;
    x << 0.3, -0.2, 0.5, 0.01, -4, 0.02, 1.5;
    const auto next = (phase.a * x).eval();
    TEST_ASSERT_TRUE(next.head<STATE_COUNT>().isApprox(loop.a * x.head<STATE_COUNT>()));
    TEST_ASSERT_EQUAL_DOUBLE(0.02, next[ALPHA]);                                     // (41)
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1.5 + 0.9 * 0.01 * 0.5 + 0.02, next[THETA]); // (43)
    TEST_ASSERT_TRUE(phase.b.topRows<STATE_COUNT>().isApprox(loop.b));
    TEST_ASSERT_EQUAL_DOUBLE(0, phase.b.bottomRows<2>().cwiseAbs().maxCoeff());
    const auto all = poles(phase.a);
    TEST_ASSERT_EQUAL_INT(2, std::count_if(all.begin(), all.end(), [](const auto &pole) {
                              return std::abs(pole - 1.0) < 1e-9;
                          }));
}

TEST(poles_are_those_of_a_closed_form)
{
    // An integrator under PI: z² − (2 − K_p − K_i)·z + 1 − K_p, and three poles at 0.
    const Gains gains = {0.5, 0.3};
    const auto found = poles(close_loop(integrator(), gains).a);
    const double half = (2 - 0.5 - 0.3) / 2;
    const double imaginary = std::sqrt(0.5 - half * half);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, half, found[0].real());
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, imaginary, std::abs(found[0].imag()));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, std::sqrt(0.5), std::abs(found[1]));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, std::abs(found[2]));
}

TEST(the_edge_of_stability_is_that_of_a_closed_form)
{
    // Jury for that polynomial: 0 < K_p, 0 < K_i < 4 − 2·K_p.
    for (const double kp : {0.1, 0.5, 1.0, 1.9}) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4 - 2 * kp, *largest_ki_per_s(integrator(), kp));
    }
    TEST_ASSERT_FALSE(largest_ki_per_s(integrator(), -0.1).has_value());
    TEST_ASSERT_FALSE(largest_ki_per_s(integrator(), 2.1).has_value());
    const Region region = stable_region(integrator(), 0.5, 21);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0, region.kp.front());
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2, region.kp.back());
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 4 - 2 * region.kp[10], region.ki_per_s[10]);
}

TEST(a_region_without_a_stable_pair_is_empty)
{
    TEST_ASSERT_TRUE(stable_region(integrator(), 3, 21).kp.empty());
}

TEST(the_papers_gains_are_stable_with_both_matrices_and_a_positive_ki)
{
    for (const Discrete &motor : {printed(), computed()}) {
        TEST_ASSERT_TRUE(is_stable(motor, PUBLISHED));
        TEST_ASSERT_TRUE(is_stable(motor, ARBITRARY));
        TEST_ASSERT_FALSE(is_stable(motor, OTHER_SIGN));
    }
    TEST_ASSERT_DOUBLE_WITHIN(POLE_PRINT, 1.00026, magnitude(printed(), OTHER_SIGN));
}

// The limits 0.337 and 0.168 that this is held against are the last stable points of a scan with
// 200 points from 1e-4 to 100, evenly spaced in the logarithm; the edge itself is between there and
// the next point.
TEST(the_last_stable_ki_of_the_reference_scan_is_found_again)
{
    const struct {
        const Discrete &motor;
        double last;
    } cases[] = {{printed(), 0.337}, {computed(), 0.168}};
    for (const auto &c : cases) {
        double last = 0;
        double next = 0;
        for (int k = 0; k < 200 && next <= 0; k++) {
            const double ki = std::pow(10, -4 + 6 * k / 199.0);
            (is_stable(c.motor, {0.264, ki}) ? last : next) = ki;
        }
        TEST_ASSERT_DOUBLE_WITHIN(ONE_PERCENT * c.last, c.last, last);
        const double edge = *largest_ki_per_s(c.motor, 0.264);
        TEST_ASSERT_TRUE(last <= edge && edge < next);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1, magnitude(c.motor, {0.264, edge}));
    }
}

TEST(stability_ends_at_ki_zero)
{
    for (const double kp : {-0.5, 0.04, 0.264}) {
        TEST_ASSERT_TRUE(is_stable(computed(), {kp, 1e-4}));
        TEST_ASSERT_FALSE(is_stable(computed(), {kp, -1e-4}));
    }
}

TEST(the_edge_of_the_region_has_a_pole_on_the_unit_circle)
{
    const Region region = stable_region(printed(), 0.264, 9);
    TEST_ASSERT_EQUAL_INT(9, region.kp.size());
    for (std::size_t k = 0; k < region.kp.size(); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1,
                                  magnitude(printed(), {region.kp[k], region.ki_per_s[k]}));
    }
}

TEST(an_unstable_pair_is_refused_with_its_eigenvalue)
{
    try {
        require_stable(printed(), OTHER_SIGN, "start");
        TEST_FAIL_MESSAGE("accepted");
    } catch (const UnstableError &error) {
        TEST_ASSERT_EQUAL_STRING("start: K_p = 0.264, K_i = -0.035 1/s: is unstable, eigenvalue "
                                 "1.000263 has magnitude 1.000263; allowed: below 1",
                                 error.what());
    }
    try {
        require_stable(computed(), {0.6, 0.1}, "start");
        TEST_FAIL_MESSAGE("accepted");
    } catch (const UnstableError &error) {
        TEST_ASSERT_NOT_NULL(std::strstr(error.what(), "i has magnitude 1.0"));
    }
}

TEST(a_time_constant_is_that_of_an_exponential)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 2.5, time_constant_s(std::exp(-0.01 / 2.5), 0.01));
}

TEST(a_step_response_starts_at_rest_and_ends_where_it_settles)
{
    const Gains gains = {0.5, 0.3};
    for (const int input : {LOAD, SUPPLY}) {
        const Response r = step_response(integrator(), gains, 1, input, 200);
        TEST_ASSERT_EQUAL_INT(201, r.time_s.size());
        TEST_ASSERT_EQUAL_DOUBLE(0, r.states.front().norm());
        const LoopState end = settled(integrator(), gains, input);
        TEST_ASSERT_DOUBLE_WITHIN(
            1e-9, 0, (end - r.states.back().head<STATE_COUNT>()).cwiseAbs().maxCoeff());
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, input == SUPPLY ? 1 : 0, end[SPEED]);
    }
}

TEST(figures_of_a_response_are_those_of_a_closed_form)
{
    // K_i = 0 and K_p = 0.5 halve the integrator's error at each sample.
    const Gains gains = {0.5, 0};
    const Response r = step_response(integrator(), gains, 0.9, SUPPLY, 3);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.875, r.states[3][SPEED]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0625, r.output_rad_s[3]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.9 * (0.5 + 0.75), r.states[3][THETA]);
    const ResponseFigures f = figures(integrator(), gains, SUPPLY, r);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -0.5, f.peak_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1, f.peak_time_s);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0, f.overshoot_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, std::sqrt((1 + 0.25 + 0.0625 + 0.015625) / 4), f.rms_rad_s);
}

TEST(the_loads_d_current_stays_as_nothing_of_the_phase_loop_reaches_the_motor)
{
    for (const Discrete &motor : {printed(), computed()}) {
        TEST_ASSERT_TRUE(settled(motor, PUBLISHED, LOAD)[I_D] > 0.3);
    }
}

TEST(the_drives_gains_are_volts_per_speed_of_the_papers)
{
    const VoltageLoopGains gains = voltage_loop_gains(PUBLISHED, 3);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.792, gains.kp_v_s_per_rad);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.105, gains.ki_v_per_rad);
    TEST_ASSERT_EQUAL_STRING("# x, for a speed loop that runs every 0.01 s\n[voltage_loop]\n"
                             "kp_v_s_per_rad = 0.792\nki_v_per_rad = 0.105\n",
                             voltage_loop_toml(gains, 0.01, "x").c_str());
}

TEST(gains_that_the_drive_does_not_take_are_refused)
{
    try {
        (void)voltage_loop_gains({-0.603, 0.0792}, 3);
        TEST_FAIL_MESSAGE("accepted");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING(
            "gains for the drive: voltage_loop.kp_v_s_per_rad = -1.809: is too "
            "small; allowed: 0 to 1000 V·s/rad",
            error.what());
    }
}

} // namespace
