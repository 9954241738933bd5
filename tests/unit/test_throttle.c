/* SPDX-License-Identifier: MIT */
/* From a reading to a demand: against the same steps in double precision. */
#include "fx.h"
#include "seeded.h"
#include "testing.h"
#include "throttle.h"

#include <math.h>

#define ONE (32767.0)
/*
 * Each step rounds towards zero by less than 1 LSB: the position in the range, its stretching
 * behind the dead band, which up to doubles what was lost before, square and cube, the curve, the
 * share.
 */
#define SHARE_LSB (3.0)
#define CURVE_LSB (5.0)

static input_cfg_t cfg;

void setUp(void)
{
    cfg = (input_cfg_t){.low = 1000,
                        .middle = 5000,
                        .high = 11000,
                        .dead_q15 = 0,
                        .expo_q15 = 0,
                        .share_q15 = 32767,
                        .slope_q30 = 1000000};
}

static double exact_share(double reading)
{
    const double side = (reading >= cfg.middle) ? (cfg.high - cfg.middle) : (cfg.middle - cfg.low);
    const double dead = cfg.dead_q15 / ONE;
    double x = (side > 0.0) ? fmin(fabs(reading - cfg.middle) / side, 1.0) : 0.0;

    x = (x > dead) ? ((x - dead) / (1.0 - dead)) : 0.0;
    return (reading >= cfg.middle) ? x : -x;
}

static double exact_curve(double x)
{
    const double expo = cfg.expo_q15 / 32768.0;

    return (((1.0 - expo) * x) + (expo * x * x * x)) * (cfg.share_q15 / ONE);
}

TEST(test_the_ends_the_middle_and_what_lies_beyond)
{
    static const struct {
        uint32_t reading;
        int32_t share;
    } points[] = {{0U, -32767},   {1000U, -32767}, {3000U, -16383}, {5000U, 0},
                  {8000U, 16383}, {11000U, 32767}, {11001U, 32767}, {65535U, 32767}};

    for (uint32_t k = 0U; k < (sizeof points / sizeof points[0]); k++) {
        TEST_ASSERT_EQUAL_INT32(points[k].share, throttle_share(&cfg, points[k].reading));
    }
}

TEST(test_an_input_for_one_way_has_no_demand_at_its_low_end_and_below)
{
    cfg.low = cfg.middle;
    TEST_ASSERT_EQUAL_INT32(0, throttle_share(&cfg, 5000U));
    TEST_ASSERT_EQUAL_INT32(0, throttle_share(&cfg, 4999U));
    TEST_ASSERT_EQUAL_INT32(0, throttle_share(&cfg, 0U));
    TEST_ASSERT_EQUAL_INT32(32767, throttle_share(&cfg, 11000U));
}

TEST(test_within_the_dead_band_the_input_is_at_rest_and_behind_it_the_demand_begins_at_0)
{
    cfg.dead_q15 = 3277; /* 10 %: 600 counts above and 400 below */
    TEST_ASSERT_EQUAL_INT32(0, throttle_share(&cfg, 5600U));
    TEST_ASSERT_INT32_WITHIN(10, 5, throttle_share(&cfg, 5602U));
    TEST_ASSERT_EQUAL_INT32(0, throttle_share(&cfg, 4600U));
    TEST_ASSERT_TRUE(throttle_share(&cfg, 4590U) < 0);
    TEST_ASSERT_EQUAL_INT32(32767, throttle_share(&cfg, 11000U));
    TEST_ASSERT_EQUAL_INT32(-32767, throttle_share(&cfg, 1000U));
}

TEST(test_share_and_curve_are_those_of_double_precision_and_monotone)
{
    seeded_t seed = {5U};

    for (uint32_t k = 0U; k < 400U; k++) {
        int32_t before = -32768;

        cfg.low = seeded_in(&seed, 0, 15000);
        cfg.middle = seeded_in(&seed, cfg.low, 16000);
        cfg.high = seeded_in(&seed, cfg.middle + 1, 32767);
        cfg.dead_q15 = seeded_in(&seed, 0, 16384);
        cfg.expo_q15 = seeded_in(&seed, 0, 32767);
        cfg.share_q15 = seeded_in(&seed, 1, 32767);
        for (uint32_t reading = 0U; reading < 33000U; reading += 97U) {
            const int32_t share = throttle_share(&cfg, reading);
            const int32_t curve = throttle_curve(&cfg, share);

            TEST_ASSERT_DOUBLE_WITHIN(SHARE_LSB, exact_share(reading) * ONE, share);
            TEST_ASSERT_DOUBLE_WITHIN(CURVE_LSB, exact_curve(share / ONE) * ONE, curve);
            TEST_ASSERT_TRUE(curve >= before - 1); /* rounding towards zero may take one LSB */
            before = curve;
        }
    }
}

TEST(test_a_negative_share_is_the_other_direction)
{
    cfg.share_q15 = -16384;
    TEST_ASSERT_EQUAL_INT32(-16384, throttle_curve(&cfg, 32767));
    TEST_ASSERT_EQUAL_INT32(16384, throttle_curve(&cfg, -32767));
    TEST_ASSERT_EQUAL_INT32(0, throttle_curve(&cfg, 0));
}

TEST(test_no_demand_is_no_demand_whatever_the_curve)
{
    for (int32_t expo = 0; expo <= 32767; expo += 127) {
        cfg.expo_q15 = expo;
        TEST_ASSERT_EQUAL_INT32(0, throttle_curve(&cfg, 0));
    }
}

TEST(test_the_demand_follows_by_its_slope_and_does_not_overshoot)
{
    int32_t demand = 0;

    for (uint32_t k = 0U; k < 100U; k++) {
        demand = throttle_slope(&cfg, demand, 32767, 3U);
        TEST_ASSERT_EQUAL_INT32(fx_min((int32_t)(k + 1U) * 3000000, 32767 * 32768), demand);
    }
    demand = throttle_slope(&cfg, demand, -32767, 1U);
    TEST_ASSERT_EQUAL_INT32((100 * 3000000) - 1000000, demand);
}

TEST(test_a_pass_that_comes_late_makes_no_larger_step_than_the_whole)
{
    cfg.slope_q30 = 0x3FFFFFFF;
    TEST_ASSERT_EQUAL_INT32(32767 * 32768, throttle_slope(&cfg, 0x3FFFFFFF, 32767, UINT32_MAX));
    TEST_ASSERT_EQUAL_INT32(
        32767 * 32768,
        throttle_slope(&cfg, throttle_slope(&cfg, -0x3FFFFFFF, 32767, 1U), 32767, 1U));
}
