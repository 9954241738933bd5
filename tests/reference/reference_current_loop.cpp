// SPDX-License-Identifier: MIT
// Current loop beside its twin.
#include "settings_under_test.h"
#include "twin_current_loop.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Q15;
using nf::reference::Seeded;
using nf::reference::Setup;
using nf::twin::Vector;

// Voltage in LSB of U_b. PI: two parts rounded down, 2. Decoupling: reactance rounded down, then
// its product, 2; EMF and R·i* rounded down, 1 each. Integral: 1/2048 LSB a step, not contracted.
static constexpr double PI_LSB = 2.0;
static constexpr double CROSS_LSB = 2.0;
static constexpr double EMF_LSB = 1.0;
static constexpr double RESISTANCE_LSB = 1.0;
static constexpr double INTEGRAL_LSB_PER_STEP = 1.0 / 2048.0;
// Square root rounded down.
static constexpr double ROOT_LSB = 1.0;

static constexpr double LEAST_SHARE = 0.15;

static double lsb(const Setup &s, double volt)
{
    return volt / s.bases.voltage_v * Q15;
}

static dq_t planned_step(current_loop_t &loop, const Setup &s, dq_t reference, dq_t measured,
                         int32_t speed_q15, int32_t limit)
{
    current_loop_plan(&loop, &s.cfg.current_loop, reference, speed_q15);
    return current_loop_step(&loop, &s.cfg.current_loop, reference, measured, limit);
}

static Vector exact_step(nf::twin::CurrentLoop &twin, const Setup &s, dq_t reference, dq_t measured,
                         int32_t speed_q15, double limit_v)
{
    const auto plan = twin.plan(s.current(reference), s.speed_of_q15(speed_q15));
    return twin.step(plan, s.current(reference), s.current(measured), limit_v);
}

static void compare_without_limit(const nf::MotorSettings &motor)
{
    constexpr int STEPS = 2000;
    const Setup s(motor, nf::reference::board(), nf::reference::tuning());
    Seeded seeded(1);
    current_loop_t loop;
    nf::twin::CurrentLoop twin(nf::reference::current_loop_params(s));
    double worst = 0;

    loop = current_loop_t{};
    for (int k = 0; k < STEPS; k++) {
        const dq_t measured = {seeded.in(-2000, 2000), seeded.in(-8000, 8000)};
        const dq_t reference = {measured.d + seeded.in(-300, 300),
                                measured.q + seeded.in(-300, 300)};
        const int32_t speed = seeded.in(-12000, 12000);
        const dq_t v = planned_step(loop, s, reference, measured, speed, 32766);
        const Vector exact = exact_step(twin, s, reference, measured, speed, s.voltage(32766));

        TEST_ASSERT_FALSE(twin.cut());
        worst = std::max({worst, std::abs(v.d - lsb(s, exact.x())), // its bound is 1 LSB less
                          std::abs(v.q - lsb(s, exact.y()))});
    }
    figure_check("current loop beside its twin, LSB", worst,
                 PI_LSB + CROSS_LSB + EMF_LSB + RESISTANCE_LSB + STEPS * INTEGRAL_LSB_PER_STEP,
                 LEAST_SHARE);
}

TEST(test_voltage_without_limit_stays_within_the_roundings_of_the_twin)
{
    compare_without_limit(nf::reference::motor_a());
    compare_without_limit(nf::reference::motor_b());
}

// At the circle v_q = √(limit² − v_d²): an error of v_d counts |v_d/v_q| times. The cut sets the
// integral to what makes the sum equal to that bound, so the roundings of the sum enter the
// integral once and are replaced, not added, by the next cut; away from the circle the integral
// keeps them.
TEST(test_voltage_at_the_circle_stays_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 2000;
    const Setup s(nf::reference::motor_a(), nf::reference::board(), nf::reference::tuning());
    Seeded seeded(3);
    current_loop_t loop;
    nf::twin::CurrentLoop twin(nf::reference::current_loop_params(s));
    // Decoupling takes about 4900 for d of 12000; EMF and resistance take 10600 for q, which is cut
    // at about 10950: by the circle and not by its own limit.
    const int32_t limit = 12000;
    const int32_t speed = 8000;
    const double sum =
        PI_LSB + CROSS_LSB + EMF_LSB + RESISTANCE_LSB + STEPS * INTEGRAL_LSB_PER_STEP;
    double worst = 0;
    double steepest = 0;
    int cuts = 0;

    loop = current_loop_t{};
    for (int k = 0; k < STEPS; k++) {
        const dq_t measured = {seeded.in(-200, 200), seeded.in(19500, 20500)};
        const int32_t push = (k / 50) % 2 == 0 ? 300 : -100;
        const dq_t reference = {measured.d + seeded.in(-50, 50),
                                measured.q + push + seeded.in(-50, 50)};
        const dq_t v = planned_step(loop, s, reference, measured, speed, limit);
        const Vector exact = exact_step(twin, s, reference, measured, speed, s.voltage(limit));

        TEST_ASSERT_FALSE(twin.pi_d().frozen() || twin.pi_q().frozen());
        if (twin.cut()) {
            cuts++;
            steepest = std::max(steepest, std::abs(exact.x() / exact.y()));
        }
        worst =
            std::max({worst, std::abs(v.d - lsb(s, exact.x())), std::abs(v.q - lsb(s, exact.y()))});
    }
    TEST_ASSERT_INT_WITHIN(STEPS * 4 / 10, STEPS / 2, cuts);
    figure_check("current loop at the circle beside its twin, LSB", worst,
                 2.0 * sum + ROOT_LSB + steepest * sum, LEAST_SHARE);
}
