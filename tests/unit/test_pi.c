/* SPDX-License-Identifier: MIT */
/* PI controller: its law, its limits and what its integral does at them. */
#include "exact.h"
#include "fx.h"
#include "pi.h"
#include "seeded.h"
#include "testing.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))
#define ONE_LSB (2048)                       /* one LSB of the output in the integral's format */
#define INTEGRAL_MAX ((32768 * ONE_LSB) - 1) /* +1, one unit short */
#define INTEGRAL_MIN (-32768 * ONE_LSB)      /* −1 */
#define SEEDED_CASES (100000)

static pi_t pi;

void setUp(void)
{
    pi_reset(&pi, 0);
}

/* kp = 0.5, K_i·T = 2^-10. */
static const pi_cfg_t PLAIN = {.kp = 16384, .kp_shift = 15U, .ki = 16384, .ki_shift = 13U};
static const pi_cfg_t ONLY_KP = {.kp = 16384, .kp_shift = 15U, .ki = 0, .ki_shift = 1U};
static const pi_cfg_t ONLY_KI = {.kp = 0, .kp_shift = 15U, .ki = 16384, .ki_shift = 13U};

TEST(test_reset_starts_the_output_at_the_given_value)
{
    static const int32_t starts[] = {0, 1, -1, 12345, -12345, 32767, -32768};

    for (size_t i = 0; i < COUNT(starts); i++) {
        pi_reset(&pi, starts[i]);
        TEST_ASSERT_EQUAL_INT32(starts[i], pi_output(&pi));
        TEST_ASSERT_EQUAL_INT32(fx_max(starts[i], -32767), pi_step(&pi, &PLAIN, 0, 0, 32767));
    }
}

typedef struct {
    const char *name;
    const pi_cfg_t *cfg;
    int32_t start; /* output of the integral before */
    int32_t error;
    int32_t feed_forward;
    int32_t limit;
    int32_t output;
    int32_t integral_q26; /* after it */
} row_t;

/* At ONLY_KI an error of 1024 is one LSB of the output, and one of 1 is 2 units of the integral. */
static const row_t ROWS[] = {
    {"nothing", &PLAIN, 0, 0, 0, 32767, 0, 0},
    {"gain times error", &ONLY_KP, 0, 1000, 0, 32767, 500, 0},
    {"rounded down", &ONLY_KP, 0, 1001, 0, 32767, 500, 0},
    {"rounded down below zero", &ONLY_KP, 0, -1001, 0, 32767, -501, 0},
    {"rounded down to -1", &ONLY_KP, 0, -1, 0, 32767, -1, 0},
    {"feed-forward added as it is", &ONLY_KP, 0, 1000, 1000, 32767, 1500, 0},
    {"feed-forward against the error", &ONLY_KP, 0, 1000, -1000, 32767, -500, 0},
    {"feed-forward beside the integral", &PLAIN, 0, 0, 30000, 32767, 30000, 0},
    {"just short of the limit", &ONLY_KP, 0, 1998, 0, 1000, 999, 0},
    {"at the limit", &ONLY_KP, 0, 2000, 0, 1000, 1000, 0},
    {"beyond the limit", &ONLY_KP, 0, 2002, 0, 1000, 1000, 0},
    {"at the lower limit", &ONLY_KP, 0, -2000, 0, 1000, -1000, 0},
    {"beyond the lower limit", &ONLY_KP, 0, -2002, 0, 1000, -1000, 0},
    {"a limit of zero", &PLAIN, 0, 65535, 1000, 0, 0, 0},
    {"a limit of zero, below it", &PLAIN, 0, -65535, -1000, 0, 0, 0},
    {"no integral into the limit", &PLAIN, 0, 30000, 0, 1000, 1000, 0},
    {"no integral into the lower limit", &PLAIN, 0, -30000, 0, 1000, -1000, 0},
    {"integral up to the limit", &ONLY_KI, 999, 1024, 0, 1000, 1000, 1000 * ONE_LSB},
    {"integral down to the limit", &ONLY_KI, -999, -1024, 0, 1000, -1000, -1000 * ONE_LSB},
    {"integral out of a held limit", &ONLY_KI, 500, -10240, 2000, 1000, 1000, 490 * ONE_LSB},
    {"integral out of a lower one", &ONLY_KI, -500, 10240, -2000, 1000, -1000, -490 * ONE_LSB},
    {"integral short of 1", &ONLY_KI, 32767, 1023, -32000, 32767, 767, INTEGRAL_MAX - 1},
    {"integral at its largest", &ONLY_KI, 32767, 1024, -32000, 32767, 767, INTEGRAL_MAX},
    {"integral beyond 1", &ONLY_KI, 32767, 1025, -32000, 32767, 767, INTEGRAL_MAX},
    {"integral far beyond 1", &ONLY_KI, 32767, 32767, -32000, 32767, 767, INTEGRAL_MAX},
    {"integral short of -1", &ONLY_KI, -32767, -1023, 32000, 32767, -768, INTEGRAL_MIN + 2},
    {"integral at -1", &ONLY_KI, -32767, -1024, 32000, 32767, -768, INTEGRAL_MIN},
    {"integral beyond -1", &ONLY_KI, -32767, -1025, 32000, 32767, -768, INTEGRAL_MIN},
    {"integral far beyond -1", &ONLY_KI, -32767, -32767, 32000, 32767, -768, INTEGRAL_MIN},
};

TEST(test_a_step_is_exact_at_its_limits_and_at_those_of_its_integral)
{
    for (size_t i = 0; i < COUNT(ROWS); i++) {
        const row_t *const row = &ROWS[i];

        pi_reset(&pi, row->start);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(
            row->output, pi_step(&pi, row->cfg, row->error, row->feed_forward, row->limit),
            row->name);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(row->integral_q26, pi.integral_q26, row->name);
    }
}

TEST(test_integral_acts_in_the_step_of_its_error)
{
    /* Backward difference: I(k) contains e(k). 1024·2^-10 = 1. */
    TEST_ASSERT_EQUAL_INT32(1, pi_step(&pi, &ONLY_KI, 1024, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(2, pi_step(&pi, &ONLY_KI, 1024, 0, 32767));
    TEST_ASSERT_EQUAL_INT32(1, pi_step(&pi, &ONLY_KI, -1024, 0, 32767));
}

TEST(test_error_of_one_lsb_is_integrated_without_loss)
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

TEST(test_gain_of_two_to_the_minus_eleven_still_integrates_one_lsb)
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

TEST(test_output_leaves_the_limit_as_soon_as_the_error_turns)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t i = 0; i < 10000; i++) {
            (void)pi_step(&pi, &PLAIN, sign * 3000, 0, 1000);
        }
        TEST_ASSERT_TRUE(sign * pi_step(&pi, &PLAIN, -sign * 10, 0, 1000) < 1000);
    }
}

TEST(test_integral_beyond_a_shrunk_limit_is_frozen_until_the_error_turns)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, sign * 20000);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &PLAIN, 0, 0, 1000));
        TEST_ASSERT_EQUAL_INT32(sign * 20000 * ONE_LSB, pi.integral_q26);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &PLAIN, sign * 10000, 0, 1000));
        TEST_ASSERT_EQUAL_INT32(sign * 20000 * ONE_LSB, pi.integral_q26);
        /* 1024·2^-10 = 1 a step out of the limit, from the first step on. */
        TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &PLAIN, -sign * 1024, 0, 1000));
        TEST_ASSERT_EQUAL_INT32(sign * 19999 * ONE_LSB, pi.integral_q26);
        TEST_ASSERT_EQUAL_INT32(sign * 1000, pi_step(&pi, &PLAIN, -sign * 1024, 0, 1000));
        TEST_ASSERT_EQUAL_INT32(sign * 19998 * ONE_LSB, pi.integral_q26);
        TEST_ASSERT_EQUAL_INT32(sign * 19998, pi_step(&pi, &PLAIN, 0, 0, 32767));
    }
}

TEST(test_unwind_gives_the_excess_back)
{
    pi_reset(&pi, 1000);
    pi_unwind(&pi, 300);
    TEST_ASSERT_EQUAL_INT32(700, pi_step(&pi, &PLAIN, 0, 0, 32767));
    pi_unwind(&pi, -300);
    TEST_ASSERT_EQUAL_INT32(1000, pi_step(&pi, &PLAIN, 0, 0, 32767));
}

TEST(test_unwind_saturates_at_one_on_both_sides)
{
    static const int32_t rows[][2] = {
        {32767, -32767 * ONE_LSB}, {1, INTEGRAL_MIN},  {1, INTEGRAL_MIN},
        {32767, INTEGRAL_MIN},     {-32767, -ONE_LSB}, {-32767, 32766 * ONE_LSB},
        {-1, 32767 * ONE_LSB},     {-1, INTEGRAL_MAX}, {-32767, INTEGRAL_MAX},
    };

    for (size_t i = 0; i < COUNT(rows); i++) {
        pi_unwind(&pi, rows[i][0]);
        TEST_ASSERT_EQUAL_INT32(rows[i][1], pi.integral_q26);
    }
}

TEST(test_unwinding_again_and_again_beside_a_held_limit_ends_at_one)
{
    /* Feed-forward alone holds the limit, so the integral cannot end the excess. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&pi, 0);
        for (int32_t k = 0; k < 1000; k++) {
            TEST_ASSERT_EQUAL_INT32(sign * 20000, pi_step(&pi, &PLAIN, 0, sign * 60000, 20000));
            pi_unwind(&pi, sign * 15000);
        }
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? INTEGRAL_MIN : INTEGRAL_MAX, pi.integral_q26);
    }
}

typedef struct {
    int32_t error;
    int32_t feed_forward;
    int32_t limit;
    int32_t start; /* integral before the step */
} step_in_t;

/* One step, beside the documented law in 64 bits, where nothing can overflow. */
static void assert_step_follows_the_law(const pi_cfg_t *cfg, const step_in_t *in)
{
    const int64_t added = floor_div_pow2((int64_t)in->error * cfg->ki, cfg->ki_shift);
    const int64_t moved = clamp64(in->start + added, INTEGRAL_MIN, INTEGRAL_MAX);
    const int64_t sum = floor_div_pow2((int64_t)in->error * cfg->kp, cfg->kp_shift) +
                        floor_div_pow2(moved, 11U) + in->feed_forward;
    const bool frozen =
        ((sum > in->limit) && (moved > in->start)) || ((sum < -in->limit) && (moved < in->start));
    int32_t output = 0;

    pi.integral_q26 = in->start;
    output = pi_step(&pi, cfg, in->error, in->feed_forward, in->limit);
    TEST_ASSERT_EQUAL_INT64(clamp64(sum, -in->limit, in->limit), output);
    TEST_ASSERT_EQUAL_INT64(frozen ? in->start : moved, pi.integral_q26);
}

TEST(test_no_sum_overflows_at_the_ends_of_all_ranges)
{
    static const int32_t errors[] = {-65535, -1, 0, 1, 65535};
    static const int32_t feed_forwards[] = {-131072, 0, 131072};
    static const int32_t limits[] = {0, 1, 32767};
    static const int32_t integrals[] = {INTEGRAL_MIN, 0, INTEGRAL_MAX};
    static const pi_cfg_t cfgs[] = {
        {.kp = 32767, .ki = 32767, .kp_shift = 1U, .ki_shift = 1U},
        {.kp = 32767, .ki = 32767, .kp_shift = 30U, .ki_shift = 30U},
        {.kp = 0, .ki = 0, .kp_shift = 1U, .ki_shift = 1U},
    };

    for (size_t i = 0; i < COUNT(errors) * COUNT(feed_forwards) * COUNT(limits); i++) {
        step_in_t in = {
            .error = errors[i % COUNT(errors)],
            .feed_forward = feed_forwards[(i / COUNT(errors)) % COUNT(feed_forwards)],
            .limit = limits[i / (COUNT(errors) * COUNT(feed_forwards))],
        };

        for (size_t j = 0; j < COUNT(integrals) * COUNT(cfgs); j++) {
            in.start = integrals[j / COUNT(cfgs)];
            assert_step_follows_the_law(&cfgs[j % COUNT(cfgs)], &in);
        }
    }
}

TEST(test_seeded_steps_follow_the_law_from_any_state)
{
    seeded_t seed = {0x600DCAFEU};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const pi_cfg_t cfg = {
            .kp = seeded_in(&seed, 0, 32767),
            .ki = seeded_in(&seed, 0, 32767),
            .kp_shift = (uint32_t)seeded_in(&seed, 1, 30),
            .ki_shift = (uint32_t)seeded_in(&seed, 1, 30),
        };
        const step_in_t in = {
            .error = seeded_in(&seed, -65535, 65535),
            .feed_forward = seeded_in(&seed, -131072, 131072),
            .limit = seeded_in(&seed, 0, 32767),
            .start = seeded_in(&seed, INTEGRAL_MIN, INTEGRAL_MAX),
        };

        assert_step_follows_the_law(&cfg, &in);
    }
}

TEST(test_output_without_error_is_what_the_next_step_gives_and_changes_nothing)
{
    seeded_t seed = {0x0075EEDU};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        pi_t before;

        (void)pi_step(&pi, &PLAIN, seeded_in(&seed, -65535, 65535), 0, 32767);
        before = pi;
        TEST_ASSERT_EQUAL_INT32(pi_step(&pi, &PLAIN, 0, 0, 32767),
                                fx_clamp(pi_output(&before), -32767, 32767));
        TEST_ASSERT_EQUAL_INT32(before.integral_q26, pi.integral_q26);
    }
}

/* The sum is rounded down twice, in its proportional part and in the integral. */
TEST(test_a_step_is_made_of_its_three_parts)
{
    seeded_t seed = {0x9A27U};

    for (int32_t k = 0; k < 2000; k++) {
        const int32_t error = seeded_in(&seed, -65535, 65535);
        const int32_t forward = seeded_in(&seed, -30000, 30000);
        const int32_t limit = seeded_in(&seed, 0, 32767);
        int32_t integral = 0;
        int32_t sum = 0;
        pi_t parts;

        pi_reset(&pi, ((k % 4) == 0) ? 32767 : seeded_in(&seed, -32768, 32767));
        parts = pi;
        integral = pi_integral(&parts, &PLAIN, error);
        TEST_ASSERT_EQUAL_INT32(fx_sat27(pi.integral_q26 + fx_asr(error * 16384, 13U)), integral);
        TEST_ASSERT_TRUE((integral >= INTEGRAL_MIN) && (integral <= INTEGRAL_MAX));
        sum = pi_sum(&PLAIN, error, integral);
        TEST_ASSERT_EQUAL_INT32(fx_asr(error * 16384, 15U) + fx_asr(integral, 11U), sum);
        TEST_ASSERT_EQUAL_INT32(pi_step(&pi, &PLAIN, error, forward, limit),
                                pi_limit(&parts, integral, sum + forward, limit));
        TEST_ASSERT_EQUAL_INT32(pi.integral_q26, parts.integral_q26);
    }
}
