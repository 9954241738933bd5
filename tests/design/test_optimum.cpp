// SPDX-License-Identifier: MIT
// Cost, its gradient, the barrier, conjugate gradients, and the optimum they find.
#include "barrier.h"
#include "conjugate_gradient.h"
#include "shipped.h"
#include "testing.h"

#include <cmath>
#include <cstring>
#include <functional>

using namespace test;

namespace
{

constexpr double GRADIENT_SHARE = 1e-6;
constexpr Gains PAIRS[] = {{0.264, 0.035}, {0.04, 0.0001}, {-0.3, 0.2}, {0.1, 0.4}};

// Central differences; the step is 1e-4 of a gain's scale, the error its square.
Eigen::Vector2d differences(const std::function<double(const Gains &)> &f, const Gains &at)
{
    constexpr double STEP = 1e-5;
    return {(f({at.kp + STEP, at.ki_per_s}) - f({at.kp - STEP, at.ki_per_s})) / (2 * STEP),
            (f({at.kp, at.ki_per_s + STEP}) - f({at.kp, at.ki_per_s - STEP})) / (2 * STEP)};
}

void expect_same(const Eigen::Vector2d &expected, const Eigen::Vector2d &actual)
{
    TEST_ASSERT_DOUBLE_WITHIN(GRADIENT_SHARE * expected.norm(), 0, (expected - actual).norm());
}

TEST(the_cost_is_the_sum_along_the_response)
{
    CostSettings settings;
    settings.horizon_samples = 40;
    for (const int state : {int(I_D), int(SPEED), int(INTEGRAL)}) {
        for (const int input : {int(LOAD), int(SUPPLY)}) {
            settings.state = state;
            settings.input = input;
            const Response r = step_response(printed(), PUBLISHED, 1, input, 0.4);
            // A command is to be reached, every other state is to stay at 0.
            const double target = state == SPEED && input == SUPPLY ? 1 : 0;
            double sum = 0;
            for (std::size_t n = 0; n < 40; n++) {
                sum += 0.01 * (std::pow(r.states[n][state] - target, 2) +
                               5 * std::pow(r.output_rad_s[n], 2));
            }
            sum += std::pow(r.states[40][state] - target, 2);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12 * sum, sum, cost(printed(), settings, PUBLISHED));
        }
    }
}

TEST(gains_of_zero_leave_the_whole_speed_command_as_error)
{
    CostSettings settings;
    settings.input = SUPPLY;
    settings.horizon_samples = 40;
    settings.q1 = 1.5;
    settings.q3 = 0.7;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 40 * 0.01 * 1.5 + 0.7, cost(computed(), settings, {0, 0}));
}

TEST(the_adjoint_gradient_is_that_of_differences)
{
    CostSettings settings;
    settings.q1 = 1.5;
    settings.q3 = 0.7;
    for (const int horizon : {1, 2, 30, 60}) {
        for (const int state : {int(I_Q), int(SPEED), int(INTEGRAL)}) {
            for (const int input : {int(LOAD), int(SUPPLY)}) {
                settings.horizon_samples = horizon;
                settings.state = state;
                settings.input = input;
                for (const Gains &gains : PAIRS) {
                    const auto f = [&](const Gains &g) { return cost(computed(), settings, g); };
                    const Eigen::Vector2d expected = differences(f, gains);
                    if (expected.norm() > 1e-3) { // else the differences are rounding
                        expect_same(expected, cost_gradient(computed(), settings, gains));
                    }
                }
            }
        }
    }
}

TEST(the_barrier_is_the_logarithm_over_pairs_of_poles)
{
    const auto all = poles(close_loop(computed(), PUBLISHED).a);
    const double rho = 1.01;
    std::complex<double> product = 1;
    for (const auto &a : all) {
        for (const auto &b : all) {
            product *= 1.0 - a * b / (rho * rho);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -std::log(product.real()), barrier(computed(), PUBLISHED, rho));
}

TEST(the_barriers_gradient_is_that_of_differences)
{
    for (const Gains &gains : PAIRS) {
        // Far enough from the poles for differences: the slope of a logarithm grows without end.
        const double rho = 1.02;
        const auto f = [&](const Gains &g) { return barrier(computed(), g, rho); };
        expect_same(differences(f, gains), barrier_gradient(computed(), gains, rho));
    }
}

TEST(the_barrier_grows_towards_the_edge_of_stability)
{
    const double edge = *largest_ki_per_s(computed(), 0.1);
    double before = barrier(computed(), {0.1, 0.5 * edge}, 1);
    for (const double share : {0.9, 0.99, 0.999, 0.99999}) {
        const double now = barrier(computed(), {0.1, share * edge}, 1);
        TEST_ASSERT_TRUE(now > before);
        before = now;
    }
}

Objective everywhere(std::function<double(const Eigen::VectorXd &)> value,
                     std::function<Eigen::VectorXd(const Eigen::VectorXd &)> gradient)
{
    return {std::move(value), std::move(gradient), [](const Eigen::VectorXd &) { return true; }};
}

TEST(a_quadratic_of_three_variables_takes_three_steps)
{
    Eigen::Matrix3d h;
    h << 4, 1, 0, 1, 3, 1, 0, 1, 10;
    const Eigen::Vector3d at(1, -2, 0.5);
    const Objective f =
        everywhere([&](const Eigen::VectorXd &x) { return (x - at).dot(h * (x - at)) / 2; },
                   [&](const Eigen::VectorXd &x) -> Eigen::VectorXd { return h * (x - at); });
    const Descent d = conjugate_gradient(f, Eigen::Vector3d(8, 7, -9), {1e-6, 20});
    TEST_ASSERT_TRUE(d.converged);
    TEST_ASSERT_EQUAL_INT(3, d.iterations);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, (d.at - at).norm());
}

TEST(a_curved_valley_is_followed_to_its_end)
{
    const Objective rosenbrock = everywhere(
        [](const Eigen::VectorXd &x) {
            return std::pow(1 - x[0], 2) + 100 * std::pow(x[1] - x[0] * x[0], 2);
        },
        [](const Eigen::VectorXd &x) -> Eigen::VectorXd {
            const double bend = x[1] - x[0] * x[0];
            return Eigen::Vector2d(-2 * (1 - x[0]) - 400 * x[0] * bend, 200 * bend);
        });
    const Descent d = conjugate_gradient(rosenbrock, Eigen::Vector2d(-1.2, 1), {1e-8, 5000});
    TEST_ASSERT_TRUE(d.converged);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, (d.at - Eigen::Vector2d(1, 1)).norm());
}

TEST(a_search_never_asks_beyond_what_is_allowed)
{
    // The minimum is at 2; allowed is what is below 1.
    Objective f = everywhere(
        [](const Eigen::VectorXd &x) {
            TEST_ASSERT_TRUE(x[0] < 1);
            return std::pow(x[0] - 2, 2);
        },
        [](const Eigen::VectorXd &x) -> Eigen::VectorXd {
            TEST_ASSERT_TRUE(x[0] < 1);
            return Eigen::VectorXd::Constant(1, 2 * (x[0] - 2));
        });
    f.allowed = [](const Eigen::VectorXd &x) { return x[0] < 1; };
    const Descent d = conjugate_gradient(f, Eigen::VectorXd::Constant(1, -3.0), {1e-9, 50});
    TEST_ASSERT_FALSE(d.converged);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1, d.at[0]);
}

TEST(the_iterations_are_bounded)
{
    const Objective f = everywhere([](const Eigen::VectorXd &x) { return std::cosh(x[0]); },
                                   [](const Eigen::VectorXd &x) -> Eigen::VectorXd {
                                       return Eigen::VectorXd::Constant(1, std::sinh(x[0]));
                                   });
    const Descent d = conjugate_gradient(f, Eigen::VectorXd::Constant(1, 3.0), {0, 1});
    TEST_ASSERT_EQUAL_INT(1, d.iterations);
    TEST_ASSERT_FALSE(d.converged);
}

// The reference: K_p ≈ 0.28 for a unit load step, X = X3 and a horizon of 30 to 60 samples.
constexpr double REFERENCE_KP = 0.28;
constexpr double TEN_PERCENT = 0.1;

TEST(least_cost_without_regard_to_stability_has_the_references_kp_and_is_unstable)
{
    CostSettings settings = shipped().optimum.cost;
    for (const int horizon : {30, 60}) {
        settings.horizon_samples = horizon;
        const Optimum o = free_optimum(computed(), settings, shipped().optimum.start);
        TEST_ASSERT_TRUE(o.converged);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * REFERENCE_KP, REFERENCE_KP, o.gains.kp);
        TEST_ASSERT_FALSE(is_stable(computed(), o.gains));
    }
}

TEST(the_stable_optimum_is_within_a_tenth_of_the_references_kp)
{
    CostSettings settings = shipped().optimum.cost;
    const double slowest_s = shipped().optimum.slowest_time_constant_s;
    for (const int horizon : {30, 60}) {
        settings.horizon_samples = horizon;
        const Optimum o = stable_optimum(computed(), settings, shipped().optimum.start, slowest_s);
        TEST_ASSERT_TRUE(o.converged);
        TEST_ASSERT_DOUBLE_WITHIN(TEN_PERCENT * REFERENCE_KP, REFERENCE_KP, o.gains.kp);
        const double magnitude = std::abs(slowest_pole(computed(), o.gains));
        TEST_ASSERT_TRUE(time_constant_s(magnitude, 0.01) < slowest_s);
    }
}

TEST(no_pair_on_a_grid_that_meets_the_demand_costs_less_than_the_optimum)
{
    const CostSettings &settings = shipped().optimum.cost;
    const double rho = std::exp(-0.01 / 36);
    const Optimum o = stable_optimum(computed(), settings, shipped().optimum.start, 36);
    double least = 1e9;
    for (int i = 0; i <= 60; i++) {
        for (int k = 1; k <= 60; k++) {
            const Gains gains = {0.35 * i / 60, 0.2 * k / 60};
            if (std::abs(slowest_pole(computed(), gains)) < rho) {
                least = std::min(least, cost(computed(), settings, gains));
            }
        }
    }
    TEST_ASSERT_TRUE(o.cost < least);
    TEST_ASSERT_TRUE(o.cost > 0.95 * least); // the grid is finer than that
}

TEST(the_stable_optimum_does_not_depend_on_the_start)
{
    const CostSettings &settings = shipped().optimum.cost;
    for (const Gains &start : {ARBITRARY, PUBLISHED, Gains{0.2, 0.1}}) {
        const Optimum o = stable_optimum(computed(), settings, start, 36);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.30003, o.gains.kp);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.03611, o.gains.ki_per_s);
    }
}

TEST(every_combination_of_state_and_input_ends_stable_with_a_positive_kp)
{
    CostSettings settings;
    for (int state = 0; state < STATE_COUNT; state++) {
        for (const int input : {int(LOAD), int(SUPPLY)}) {
            settings.state = state;
            settings.input = input;
            for (const Discrete &motor : {printed(), computed()}) {
                const Optimum o = stable_optimum(motor, settings, shipped().optimum.start, 36);
                TEST_ASSERT_TRUE(is_stable(motor, o.gains));
                TEST_ASSERT_TRUE(o.gains.kp > 0);
            }
        }
    }
}

TEST(an_unstable_start_is_refused)
{
    try {
        (void)stable_optimum(computed(), shipped().optimum.cost, OTHER_SIGN, 36);
        TEST_FAIL_MESSAGE("accepted");
    } catch (const UnstableError &error) {
        TEST_ASSERT_NOT_NULL(std::strstr(error.what(), "eigenvalue 1.000277"));
    }
}

TEST(a_start_that_the_drive_does_not_take_is_refused)
{
    try {
        (void)stable_optimum(computed(), shipped().optimum.cost, {-0.1, 0.01}, 36);
        TEST_FAIL_MESSAGE("accepted");
    } catch (const std::runtime_error &error) {
        TEST_ASSERT_EQUAL_STRING("start.kp = -0.1: the search is among what the drive takes; "
                                 "allowed: above 0",
                                 error.what());
    }
}

TEST(a_demand_beyond_all_gains_is_refused_with_the_best_there_is)
{
    try {
        (void)stable_optimum(computed(), shipped().optimum.cost, ARBITRARY, 0.5);
        TEST_FAIL_MESSAGE("accepted");
    } catch (const std::runtime_error &error) {
        TEST_ASSERT_NOT_NULL(
            std::strstr(error.what(), "slowest_time_constant_s: no pair with K_p > 0 found"));
    }
}

} // namespace
