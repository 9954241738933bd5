// SPDX-License-Identifier: MIT
// PI controller beside its twin.
#include "settings_under_test.h"
#include "twin_pi.h"

#include "figure.h"
#include "testing.h"

#include <algorithm>
#include <cmath>

using nf::reference::Seeded;

// The output rounds the proportional part and the integral down, 1 LSB each.
static constexpr double OUTPUT_LSB = 2.0;
// The integral rounds each product down to 1/2048 LSB, and nothing contracts that.
static constexpr double INTEGRAL_LSB_PER_STEP = 1.0 / 2048.0;

static constexpr double LEAST_SHARE = 0.2;

static const pi_cfg_t CFG = {26537, 26678, 13, 7}; // 3.239, 0.1018

// In LSB.
static nf::twin::Pi::Params twin_params()
{
    return nf::reference::pi_params(CFG, nf::reference::Q15, nf::reference::Q15);
}

TEST(test_unlimited_steps_stay_within_the_roundings_of_the_twin)
{
    constexpr int STEPS = 2000;
    Seeded seeded(1);
    pi_t pi;
    nf::twin::Pi twin(twin_params());
    double worst = 0;

    pi_reset(&pi, 0);
    for (int k = 0; k < STEPS; k++) {
        // Alternating in sign on average, so that no limit is reached.
        const int32_t error = seeded.in(-1000, 1000);
        const int32_t feed_forward = seeded.in(-5000, 5000);
        const double exact = twin.step(error, feed_forward, 32767);

        worst = std::max(worst, std::abs(pi_step(&pi, &CFG, error, feed_forward, 32767) - exact));
        TEST_ASSERT_TRUE(std::abs(exact) < 32700);
    }
    figure_check("PI beside its twin, LSB", worst, OUTPUT_LSB + STEPS * INTEGRAL_LSB_PER_STEP,
                 LEAST_SHARE);
}

// With limits the two may disagree in a step whether the output has reached one. Such a step moves
// one integral and not the other, by K_i·T·|e|: added to the bound when it happens, seen in the
// integrals.
TEST(test_limited_steps_stay_within_the_roundings_of_the_twin)
{
    Seeded seeded(2);
    double worst = 0;

    for (int run = 0; run < 50; run++) {
        pi_t pi;
        nf::twin::Pi twin(twin_params());
        double integral_bound = 0;
        int32_t error = 0;

        pi_reset(&pi, 0);
        for (int k = 0; k < 500; k++) {
            const int32_t before = pi.integral_q26;
            const int32_t limit = 6000 + 2000 * (k / 100 % 3);
            error = (k % 20 == 0) ? seeded.in(-3000, 3000) : error;
            const double exact = twin.step(error, 0, limit);
            const int32_t output = pi_step(&pi, &CFG, error, 0, limit);
            const bool frozen = pi.integral_q26 == before;

            integral_bound += INTEGRAL_LSB_PER_STEP;
            if (frozen != twin.frozen()) {
                integral_bound += std::abs(error) * twin_params().ki_t;
            }
            worst = std::max(worst, std::abs(output - exact) / (OUTPUT_LSB + integral_bound));
        }
    }
    figure_check("limited PI beside its twin, share of the running bound", worst, 1.0, LEAST_SHARE);
}

// A feed-forward against the integral keeps the output off its limit, so that the integral reaches
// its own: ±1 as in the twin, which ends the rounding errors gathered on the way. The upper end is
// one unit short of 1.
TEST(test_saturated_integral_equals_the_twin)
{
    for (const int32_t sign : {1, -1}) {
        pi_t pi;
        nf::twin::Pi twin(twin_params());

        pi_reset(&pi, 0);
        for (int k = 0; k < 2000; k++) {
            // 0.1018 a step: full scale after 322 steps of 1000.
            (void)twin.step(sign * 1000, -sign * 33000, 32767);
            (void)pi_step(&pi, &CFG, sign * 1000, -sign * 33000, 32767);
        }
        TEST_ASSERT_EQUAL_DOUBLE(sign * nf::reference::Q15, twin.integral());
        TEST_ASSERT_DOUBLE_WITHIN(1.0 / 2048.0, twin.integral(), pi.integral_q26 / 2048.0);
    }
}

// An integral that a shrunk limit leaves outside is frozen in both until the error turns.
TEST(test_integral_beyond_a_shrunk_limit_equals_the_twin)
{
    for (const int32_t sign : {1, -1}) {
        pi_t pi;
        nf::twin::Pi twin(twin_params());
        int frozen = 0;

        pi_reset(&pi, sign * 20000);
        twin.reset(sign * 20000);
        for (int k = 0; k < 100; k++) {
            const int32_t error = sign * (k % 10 == 9 ? -100 : 50);
            const double exact = twin.step(error, 0, 5000);

            TEST_ASSERT_EQUAL_DOUBLE(exact, pi_step(&pi, &CFG, error, 0, 5000));
            frozen += twin.frozen() ? 1 : 0;
        }
        TEST_ASSERT_EQUAL_INT(90, frozen);
        TEST_ASSERT_DOUBLE_WITHIN(10 * INTEGRAL_LSB_PER_STEP, twin.integral(),
                                  pi.integral_q26 / 2048.0);
    }
}
