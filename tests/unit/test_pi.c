/* PI controller: its law, its limits and what its integral does at them. */
#include "pi.h"
#include "seeded.h"
#include "unity.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))
#define ONE_LSB (2048) /* one LSB of the output in the integral's format */
#define SEEDED_CASES (100000)

static pi_t pi;

void setUp(void)
{
    pi_reset(&pi, 0);
}

void tearDown(void)
{
}

/* kp = 0.5, K_i·T = 2^-10. */
static const pi_cfg_t PLAIN = {.kp = 16384, .kp_shift = 15U, .ki = 16384, .ki_shift = 13U};
static const pi_cfg_t ONLY_KP = {.kp = 16384, .kp_shift = 15U, .ki = 0, .ki_shift = 1U};
static const pi_cfg_t ONLY_KI = {.kp = 0, .kp_shift = 15U, .ki = 16384, .ki_shift = 13U};

static void test_reset_starts_the_output_at_the_given_value(void)
{
    static const int32_t starts[] = {0, 1, -1, 12345, -12345, 32767, -32767};

    for (size_t i = 0; i < COUNT(starts); i++) {
        pi_reset(&pi, starts[i]);
        TEST_ASSERT_EQUAL_INT32(starts[i], pi_step(&pi, &PLAIN, 0, 0, 32767));
    }
}

static void test_proportional_part_is_error_times_gain_rounded_down(void)
{
    TEST_ASSERT_EQUAL_INT32(500, pi_step(&pi, &ONLY_KP, 1000, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(500, pi_step(&pi, &ONLY_KP, 1001, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(-501, pi_step(&pi, &ONLY_KP, -1001, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(-1, pi_step(&pi, &ONLY_KP, -1, 0, 32767));
}

static void test_feed_forward_is_added_as_it_is(void)
{
    TEST_ASSERT_EQUAL_INT32(1500, pi_step(&pi, &ONLY_KP, 1000, 1000, 32767));
    TEST_ASSERT_EQUAL_INT32(-500, pi_step(&pi, &ONLY_KP, 1000, -1000, 32767));
}

static void test_feed_forward_alone_does_not_reach_the_integral(void)
{
    (void)pi_step(&pi, &PLAIN, 0, 30000, 32767);
    TEST_ASSERT_EQUAL_INT32(0, pi_step(&pi, &PLAIN, 0, 0, 32767));
}

static void test_integral_acts_in_the_step_of_its_error(void)
{
    /* Backward difference: I(k) contains e(k). 1024·2^-10 = 1. */
    TEST_ASSERT_EQUAL_INT32(1, pi_step(&pi, &ONLY_KI, 1024, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(2, pi_step(&pi, &ONLY_KI, 1024, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(1, pi_step(&pi, &ONLY_KI, -1024, 0, 32767));
}

static void test_error_of_one_lsb_is_integrated_without_loss(void)
{
    /* 2^-10 a step: one LSB of the output in 1024 steps, on either side. */
    int32_t output = 0;

    for (int32_t i = 0; i < 10240; i++) {
        output = pi_step(&pi, &ONLY_KI, 1, 0, 32767);
    }
    TEST_ASSERT_EQUAL_INT32(10, output);
    for (int32_t i = 0; i < 20480; i++) {
        output = pi_step(&pi, &ONLY_KI, -1, 0, 32767);
    }
    TEST_ASSERT_EQUAL_INT32(-10, output);
}

static void test_gain_of_two_to_the_minus_eleven_still_integrates_one_lsb(void)
{
    /* K_i·T = 2^14 / 2^(14 + 11): 2048 steps for one LSB. */
    const pi_cfg_t slow = {.kp = 0, .kp_shift = 1U, .ki = 16384, .ki_shift = 14U};
    int32_t output = 0;

    for (int32_t i = 0; i < 2047; i++) {
        output = pi_step(&pi, &slow, 1, 0, 32767);
    }
    TEST_ASSERT_EQUAL_INT32(0, output);
    TEST_ASSERT_EQUAL_INT32(1, pi_step(&pi, &slow, 1, 0, 32767));
}

static void test_output_is_limited_on_both_sides_exactly_at_the_limit(void)
{
    TEST_ASSERT_EQUAL_INT32(999, pi_step(&pi, &ONLY_KP, 1998, 0, 1000));
    TEST_ASSERT_EQUAL_INT32(1000, pi_step(&pi, &ONLY_KP, 2000, 0, 1000));
    TEST_ASSERT_EQUAL_INT32(1000, pi_step(&pi, &ONLY_KP, 2002, 0, 1000));
    TEST_ASSERT_EQUAL_INT32(-1000, pi_step(&pi, &ONLY_KP, -2000, 0, 1000));
    TEST_ASSERT_EQUAL_INT32(-1000, pi_step(&pi, &ONLY_KP, -2002, 0, 1000));
}

static void test_limit_of_zero_gives_zero(void)
{
    TEST_ASSERT_EQUAL_INT32(0, pi_step(&pi, &PLAIN, 65535, 1000, 0));
    TEST_ASSERT_EQUAL_INT32(0, pi_step(&pi, &PLAIN, -65535, -1000, 0));
}

static void test_integral_does_not_move_further_into_a_reached_limit(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t i = 0; i < 1000; i++) {
            TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &PLAIN, sign * 30000, 0, 1000));
        }
        TEST_ASSERT_EQUAL_INT32(0, pi.integral_q26);
    }
}

static void test_integral_moves_up_to_an_output_exactly_at_the_limit(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, sign * 999);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &ONLY_KI, sign * 1024, 0, 1000));
        TEST_ASSERT_EQUAL_INT32(sign * 1000 * ONE_LSB, pi.integral_q26);
    }
}

static void test_output_leaves_the_limit_as_soon_as_the_error_turns(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t i = 0; i < 10000; i++) {
            (void)pi_step(&pi, &PLAIN, sign * 3000, 0, 1000);
        }
        TEST_ASSERT_TRUE(sign * pi_step(&pi, &PLAIN, -sign * 10, 0, 1000) < 1000);
    }
}

static void test_integral_still_moves_out_of_a_limit_that_feed_forward_holds(void)
{
    pi_reset(&pi, 500);
    TEST_ASSERT_EQUAL_INT32(1000, pi_step(&pi, &ONLY_KI, -10240, 2000, 1000));
    TEST_ASSERT_EQUAL_INT32(490 * ONE_LSB, pi.integral_q26);
    pi_reset(&pi, -500);
    TEST_ASSERT_EQUAL_INT32(-1000, pi_step(&pi, &ONLY_KI, 10240, -2000, 1000));
    TEST_ASSERT_EQUAL_INT32(-490 * ONE_LSB, pi.integral_q26);
}

static void test_integral_stays_within_the_limit(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t i = 0; i < 200; i++) {
            /* The feed-forward keeps the output off the limit, so only the integral's own bound acts. */
            (void)pi_step(&pi, &ONLY_KI, sign * 32767, -sign * 900, 1000);
        }
        TEST_ASSERT_TRUE(sign * (pi.integral_q26 / ONE_LSB) <= 1000);
        TEST_ASSERT_TRUE(sign * (pi.integral_q26 / ONE_LSB) >= 999);
    }
}

static void test_integral_comes_within_a_limit_that_has_shrunk(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, sign * 20000);
        (void)pi_step(&pi, &PLAIN, 0, 0, 1000);
        TEST_ASSERT_EQUAL_INT32(sign * 1000 * ONE_LSB, pi.integral_q26);
    }
}

static void test_integral_comes_within_a_shrunk_limit_while_the_error_pushes_into_it(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, sign * 20000);
        (void)pi_step(&pi, &PLAIN, sign * 10000, 0, 1000);
        TEST_ASSERT_EQUAL_INT32(sign * 1000 * ONE_LSB, pi.integral_q26);
    }
}

static void test_unwind_gives_the_excess_back(void)
{
    pi_reset(&pi, 1000);
    pi_unwind(&pi, 300, 32767);
    TEST_ASSERT_EQUAL_INT32(700, pi_step(&pi, &PLAIN, 0, 0, 32767));
    pi_unwind(&pi, -300, 32767);
    TEST_ASSERT_EQUAL_INT32(1000, pi_step(&pi, &PLAIN, 0, 0, 32767));
}

static void test_unwind_stops_at_the_limit_on_both_sides(void)
{
    pi_reset(&pi, 0);
    pi_unwind(&pi, 32767, 1000);
    TEST_ASSERT_EQUAL_INT32(-1000 * ONE_LSB, pi.integral_q26);
    pi_unwind(&pi, -32767, 1000);
    TEST_ASSERT_EQUAL_INT32(1000 * ONE_LSB, pi.integral_q26);
    pi_reset(&pi, -32767);
    pi_unwind(&pi, 32767, 32767);
    TEST_ASSERT_EQUAL_INT32(-32767 * ONE_LSB, pi.integral_q26);
    pi_reset(&pi, 32767);
    pi_unwind(&pi, -32767, 32767);
    TEST_ASSERT_EQUAL_INT32(32767 * ONE_LSB, pi.integral_q26);
    pi_unwind(&pi, 5, 0);
    TEST_ASSERT_EQUAL_INT32(0, pi.integral_q26);
}

static void test_unwinding_again_and_again_beside_a_held_limit_stays_within_it(void)
{
    /* Feed-forward alone holds the limit, so the integral cannot end the excess. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t k = 0; k < 1000; k++) {
            const int32_t output = pi_step(&pi, &PLAIN, 0, sign * 60000, 20000);

            TEST_ASSERT_EQUAL_INT32(sign * 20000, output);
            pi_unwind(&pi, sign * 15000, 20000);
            TEST_ASSERT_TRUE(abs(pi.integral_q26) <= (20000 * ONE_LSB));
        }
    }
}

static int64_t floor_div_pow2(int64_t x, uint32_t n)
{
    const int64_t divisor = (int64_t)1 << n;
    const int64_t quotient = x / divisor;

    return ((x % divisor) < 0) ? (quotient - 1) : quotient;
}

static int64_t clamp64(int64_t x, int64_t limit)
{
    int64_t result = x;

    if (x > limit) {
        result = limit;
    } else if (x < -limit) {
        result = -limit;
    }
    return result;
}

/* The documented law in 64 bits, where nothing can overflow. */
static int64_t output_by_the_law(int64_t integral_q26, const pi_cfg_t *cfg, int64_t error,
                                 int64_t feed_forward, int64_t limit)
{
    const int64_t integral =
        clamp64(integral_q26 + floor_div_pow2(error * cfg->ki, cfg->ki_shift), limit * ONE_LSB);
    const int64_t proportional = floor_div_pow2(error * cfg->kp, cfg->kp_shift);

    return clamp64(proportional + floor_div_pow2(integral, 11U) + feed_forward, limit);
}

/* The same before the limit, with the integral as it was. */
static int64_t sum_by_the_law(int64_t integral_q26, const pi_cfg_t *cfg, int64_t error,
                              int64_t feed_forward)
{
    return floor_div_pow2(error * cfg->kp, cfg->kp_shift) + floor_div_pow2(integral_q26, 11U) +
           feed_forward;
}

static void test_no_sum_overflows_at_the_ends_of_all_ranges(void)
{
    static const int32_t errors[] = {-65535, -1, 0, 1, 65535};
    static const int32_t feed_forwards[] = {-131072, 0, 131072};
    static const int32_t limits[] = {0, 1, 32767};
    static const int32_t integrals[] = {-32767 * ONE_LSB, 0, 32767 * ONE_LSB};
    static const pi_cfg_t cfgs[] = {
        {.kp = 32767, .ki = 32767, .kp_shift = 1U, .ki_shift = 1U},
        {.kp = 32767, .ki = 32767, .kp_shift = 30U, .ki_shift = 30U},
        {.kp = 0, .ki = 0, .kp_shift = 1U, .ki_shift = 1U},
    };

    for (size_t i = 0; i < COUNT(errors) * COUNT(feed_forwards) * COUNT(limits); i++) {
        const int32_t error = errors[i % COUNT(errors)];
        const int32_t feed_forward = feed_forwards[(i / COUNT(errors)) % COUNT(feed_forwards)];
        const int32_t limit = limits[i / (COUNT(errors) * COUNT(feed_forwards))];

        for (size_t j = 0; j < COUNT(integrals) * COUNT(cfgs); j++) {
            const pi_cfg_t *const cfg = &cfgs[j % COUNT(cfgs)];
            const int32_t start = integrals[j / COUNT(cfgs)];

            pi.integral_q26 = start;
            TEST_ASSERT_EQUAL_INT64(output_by_the_law(start, cfg, error, feed_forward, limit),
                                    pi_step(&pi, cfg, error, feed_forward, limit));
        }
    }
}

static void test_seeded_steps_follow_the_law_from_any_state(void)
{
    seeded_t seed = {0x600DCAFEU};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const pi_cfg_t cfg = {
            .kp = seeded_in(&seed, 0, 32767),
            .ki = seeded_in(&seed, 0, 32767),
            .kp_shift = (uint32_t)seeded_in(&seed, 1, 30),
            .ki_shift = (uint32_t)seeded_in(&seed, 1, 30),
        };
        const int32_t error = seeded_in(&seed, -65535, 65535);
        const int32_t feed_forward = seeded_in(&seed, -131072, 131072);
        const int32_t limit = seeded_in(&seed, 0, 32767);
        const int32_t start = seeded_in(&seed, -limit * ONE_LSB, limit * ONE_LSB);
        const int64_t expected = output_by_the_law(start, &cfg, error, feed_forward, limit);
        int32_t output = 0;

        pi.integral_q26 = start;
        output = pi_step(&pi, &cfg, error, feed_forward, limit);
        TEST_ASSERT_EQUAL_INT64(expected, output);
        TEST_ASSERT_TRUE((pi.integral_q26 >= (-limit * ONE_LSB)) &&
                         (pi.integral_q26 <= (limit * ONE_LSB)));
        /* With the old integral already beyond the limit, the integral may come back from it only. */
        if (sum_by_the_law(start, &cfg, error, feed_forward) > limit) {
            TEST_ASSERT_TRUE(pi.integral_q26 <= start);
        } else if (sum_by_the_law(start, &cfg, error, feed_forward) < -limit) {
            TEST_ASSERT_TRUE(pi.integral_q26 >= start);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reset_starts_the_output_at_the_given_value);
    RUN_TEST(test_proportional_part_is_error_times_gain_rounded_down);
    RUN_TEST(test_feed_forward_is_added_as_it_is);
    RUN_TEST(test_feed_forward_alone_does_not_reach_the_integral);
    RUN_TEST(test_integral_acts_in_the_step_of_its_error);
    RUN_TEST(test_error_of_one_lsb_is_integrated_without_loss);
    RUN_TEST(test_gain_of_two_to_the_minus_eleven_still_integrates_one_lsb);
    RUN_TEST(test_output_is_limited_on_both_sides_exactly_at_the_limit);
    RUN_TEST(test_limit_of_zero_gives_zero);
    RUN_TEST(test_integral_does_not_move_further_into_a_reached_limit);
    RUN_TEST(test_integral_moves_up_to_an_output_exactly_at_the_limit);
    RUN_TEST(test_output_leaves_the_limit_as_soon_as_the_error_turns);
    RUN_TEST(test_integral_still_moves_out_of_a_limit_that_feed_forward_holds);
    RUN_TEST(test_integral_stays_within_the_limit);
    RUN_TEST(test_integral_comes_within_a_limit_that_has_shrunk);
    RUN_TEST(test_integral_comes_within_a_shrunk_limit_while_the_error_pushes_into_it);
    RUN_TEST(test_unwind_gives_the_excess_back);
    RUN_TEST(test_unwind_stops_at_the_limit_on_both_sides);
    RUN_TEST(test_unwinding_again_and_again_beside_a_held_limit_stays_within_it);
    RUN_TEST(test_no_sum_overflows_at_the_ends_of_all_ranges);
    RUN_TEST(test_seeded_steps_follow_the_law_from_any_state);
    return UNITY_END();
}
