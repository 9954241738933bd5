/* SPDX-License-Identifier: MIT */
/* How warm a winding may be when an identification begins: against the sum in double precision. */
#include "example_identify.h"
#include "identify_heat.h"
#include "identify_rest.h"
#include "testing.h"

#define LIMIT (1.2)
#define TENTH (0.1)
#define LEAST (0.25)
#define LARGEST_S (8.0)
#define TAU_S (20.0)            /* of the example, at a shift of 11 */
#define TOLERANCE (1.0 / 256.0) /* the square is Q8, rounded down; T/τ is below 1 */

void setUp(void)
{
    identify_example();
    start();
}

static void assert_begins_at(double most)
{
    TEST_ASSERT_DOUBLE_WITHIN(TOLERANCE, most, identify_heat_most_q24(&identify) / 16777216.0);
}

static double rise(double tau_s)
{
    const double ratio = (double)identify_rest_largest(&identify) / CONTINUOUS;

    return LARGEST_S / tau_s * ratio * ratio;
}

TEST(test_8_s_of_the_largest_current_end_a_tenth_below_the_limit)
{
    for (uint32_t shift = 11U; shift <= 18U; shift++) {
        cfg.derating.heat_rate_shift = shift;
        assert_begins_at(LIMIT - TENTH - rise(TAU_S * (double)(1U << (shift - 11U))));
    }
}

TEST(test_another_slow_period_with_the_same_rate_is_another_time_constant)
{
    cfg.slow_ticks *= 2U;
    assert_begins_at(LIMIT - TENTH - rise(2.0 * TAU_S));
}

TEST(test_another_limit_of_the_heat_is_kept_too)
{
    cfg.derating.heat_max_q14 += 8192; /* 0.5 */
    assert_begins_at(LIMIT + 0.5 - TENTH - rise(TAU_S));
}

TEST(test_a_small_winding_is_not_waited_for_without_end)
{
    for (uint32_t shift = 0U; shift <= 10U; shift++) {
        cfg.derating.heat_rate_shift = shift;
        assert_begins_at(LEAST);
    }
}
