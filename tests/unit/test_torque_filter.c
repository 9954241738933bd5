/* SPDX-License-Identifier: MIT */
/*
 * Torque filter: what stands still passes whole, the notch takes its frequency away, the low-pass
 * what is fast.
 */
#include "torque_filter.h"

#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>

#define CURRENT_MAX (16384)
#define RESULT_MAX (262144)
#define SMOOTH_MAX (67108864)
#define SWING_MAX (134217728)
#define TURN (6.283185307179586)
#define Q15 (32768.0)
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static torque_filter_t filter;

void setUp(void)
{
    torque_filter_start(&filter, 0);
}

/* Centre and width as shares of the sample rate. */
static torque_filter_cfg_t notch_of(double centre, double width)
{
    const double t = tan(TURN / 2.0 * width);

    return (torque_filter_cfg_t){
        .notch_share_q15 = (int32_t)lround(2.0 * t / (1.0 + t) * Q15),
        .notch_turn = {.sin = (int32_t)lround(sin(TURN * centre) * Q15),
                       .cos = (int32_t)lround(cos(TURN * centre) * Q15)},
    };
}

/* From slow and narrow to fast and wide, and both at once. */
static torque_filter_cfg_t example(uint32_t number)
{
    static const struct {
        double centre;
        double width;
        int32_t rate;
    } examples[] = {
        {0.00390625, 0.0004, 0}, {0.00390625, 0.00390625, 0},
        {0.01, 0.005, 0},        {0.1, 0.05, 0},
        {0.1, 0.1, 0},           {0.25, 0.125, 0},
        {0.45, 0.2, 0},          {0.1, 0.0, 32767},
        {0.1, 0.0, 12946},       {0.1, 0.0, 795},
        {0.1, 0.05, 12946},      {0.01, 0.005, 795},
        {0.4, 0.2, 32767},
    };
    torque_filter_cfg_t cfg = notch_of(examples[number].centre, examples[number].width);

    TEST_ASSERT_LESS_THAN_UINT32(COUNT(examples), number);
    cfg.smooth_rate_q15 = examples[number].rate;
    return cfg;
}

#define EXAMPLES (13U)

static int32_t step(const torque_filter_cfg_t *cfg, int32_t current)
{
    return torque_filter_step(&filter, cfg, current);
}

TEST(test_without_a_frequency_it_does_not_act_and_passes_all)
{
    const torque_filter_cfg_t none = {.notch_turn = {.sin = 3, .cos = 4}};
    const torque_filter_cfg_t low_pass = {.smooth_rate_q15 = 1};
    const torque_filter_cfg_t notch = {.notch_share_q15 = 1};

    TEST_ASSERT_FALSE(torque_filter_acts(&none));
    TEST_ASSERT_TRUE(torque_filter_acts(&low_pass));
    TEST_ASSERT_TRUE(torque_filter_acts(&notch));
    for (int32_t current = -CURRENT_MAX; current <= CURRENT_MAX; current += 127) {
        TEST_ASSERT_EQUAL_INT32(current, step(&none, current));
    }
}

TEST(test_the_current_that_it_starts_with_passes_from_the_first_sample_on)
{
    static const int32_t currents[] = {-CURRENT_MAX, -1, 0, 1, 3000, CURRENT_MAX};

    for (uint32_t number = 0U; number < EXAMPLES; number++) {
        const torque_filter_cfg_t cfg = example(number);

        for (uint32_t k = 0U; k < COUNT(currents); k++) {
            (void)step(&cfg, 5000); /* and nothing is left of before */
            torque_filter_start(&filter, currents[k]);
            TEST_ASSERT_EQUAL_INT32(0, filter.swing_q26.d);
            TEST_ASSERT_EQUAL_INT32(0, filter.swing_q26.q);
            for (uint32_t n = 0U; n < 3000U; n++) {
                TEST_ASSERT_EQUAL_INT32(currents[k], step(&cfg, currents[k]));
            }
        }
    }
}

/*
 * The header's transfer function at z = 1 with the integers of the configuration: of the sine and
 * cosine, rounded, the squares do not make 1.
 */
static double gain_at_rest(const torque_filter_cfg_t *cfg)
{
    const double mu = cfg->notch_share_q15 / Q15;
    const double cosine = cfg->notch_turn.cos / Q15;
    const double sine = cfg->notch_turn.sin / Q15;
    const double square = (cosine * cosine) + (sine * sine);

    return (1.0 - (mu / 2.0)) / (1.0 + (mu * (cosine - square) / (1.0 - (2.0 * cosine) + square)));
}

/* The slowest example forgets by 1/800 in a sample, so e^-25 of the step is left after 20000. */
TEST(test_a_step_passes_whole_in_the_end)
{
    for (uint32_t number = 0U; number < EXAMPLES; number++) {
        const torque_filter_cfg_t cfg = example(number);
        const double gain = gain_at_rest(&cfg);

        TEST_ASSERT_DOUBLE_WITHIN(1.0 / 1024.0, 1.0, gain);
        torque_filter_start(&filter, -4000);
        for (uint32_t n = 0U; n < 20000U; n++) {
            (void)step(&cfg, 7001);
        }
        for (uint32_t n = 0U; n < 1000U; n++) {
            TEST_ASSERT_DOUBLE_WITHIN(1.0, -4000.0 + (11001.0 * gain), step(&cfg, 7001));
        }
    }
}

/*
 * Largest output over a whole number of periods for a swing of the amplitude 8000 about 2000, after
 * it has settled.
 */
static double amplitude_at(const torque_filter_cfg_t *cfg, double frequency, uint32_t settle,
                           uint32_t samples)
{
    double in_phase = 0.0;
    double across = 0.0;

    torque_filter_start(&filter, 2000);
    for (uint32_t n = 0U; n < (settle + samples); n++) {
        const double turn = TURN * frequency * (double)n;
        const int32_t result = step(cfg, 2000 + (int32_t)lround(8000.0 * cos(turn)));

        if (n >= settle) {
            in_phase += (double)(result - 2000) * cos(turn);
            across += (double)(result - 2000) * sin(turn);
        }
    }
    return hypot(in_phase, across) * 2.0 / (double)samples / 8000.0;
}

/*
 * cos, sin and μ are rounded to 2^-16 of a unit: that moves the centre and the edges of a band of
 * 0.05 by 1/1000 of it.
 */
TEST(test_the_notch_takes_its_frequency_away_and_half_of_the_power_at_its_edges)
{
    const double width = 0.05;
    static const double centres[] = {0.1, 0.2, 0.35};

    for (uint32_t k = 0U; k < COUNT(centres); k++) {
        const torque_filter_cfg_t cfg = notch_of(centres[k], width);
        /*
         * The notch is (1 + A)/2 with an all-pass A, and half of the power is left where A has the
         * phase ±90°: at half the width on both sides of this angle.
         */
        const double half = tan(TURN / 2.0 * width);
        const double middle = acos(cos(TURN * centres[k]) / sqrt(1.0 + (half * half))) / TURN;

        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, amplitude_at(&cfg, centres[k], 4000U, 4000U));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, sqrt(0.5),
                                  amplitude_at(&cfg, middle - (width / 2.0), 4000U, 40000U));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, sqrt(0.5),
                                  amplitude_at(&cfg, middle + (width / 2.0), 4000U, 40000U));
    }
}

/*
 * Of 8000 each sample leaves 3/4; the states are rounded down by a LSB of Q26 and the result to
 * nearest.
 */
TEST(test_the_low_pass_follows_a_step_by_its_share)
{
    const torque_filter_cfg_t cfg = {.smooth_rate_q15 = 8192};
    double left = 8000.0;

    for (uint32_t n = 0U; n < 100U; n++) {
        left *= 0.75;
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 8000.0 - left, step(&cfg, 8000));
    }
}

/* Whatever swing is left from another configuration. */
TEST(test_the_smallest_share_makes_a_notch_and_none_makes_none)
{
    const torque_filter_cfg_t none = {.notch_turn = {.sin = 0, .cos = 32767}};
    const torque_filter_cfg_t smallest = {.notch_share_q15 = 1,
                                          .notch_turn = {.sin = 0, .cos = 32767}};

    filter.swing_q26.d = 10 * 2048;
    TEST_ASSERT_EQUAL_INT32(5, step(&none, 5));
    TEST_ASSERT_EQUAL_INT32(10 * 2048, filter.swing_q26.d);
    TEST_ASSERT_EQUAL_INT32(-5, step(&smallest, 5));
}

/* 1025 LSB of Q26 less 2, and less none: just below a half, and a half. */
TEST(test_the_result_is_rounded_to_nearest)
{
    const torque_filter_cfg_t slow = {.smooth_rate_q15 = 1};

    filter.smooth_q26 = 1025;
    TEST_ASSERT_EQUAL_INT32(0, step(&slow, 0));
    filter.smooth_q26 = 1024;
    TEST_ASSERT_EQUAL_INT32(1, step(&slow, 1));
}

/* Its gain is 1 at half of the sample rate too. */
TEST(test_the_notch_leaves_what_alternates_from_sample_to_sample)
{
    const torque_filter_cfg_t cfg = notch_of(0.1, 0.05);

    for (uint32_t n = 0U; n < 400U; n++) {
        const int32_t current = ((n % 2U) == 0U) ? 6000 : -6000;
        const int32_t result = step(&cfg, current);

        if (n > 200U) {
            TEST_ASSERT_INT32_WITHIN(1, current, result);
        }
    }
}

TEST(test_low_pass_and_notch_act_one_behind_the_other)
{
    const torque_filter_cfg_t notch = notch_of(0.1, 0.05);
    const torque_filter_cfg_t low_pass = {.smooth_rate_q15 = 12946};
    torque_filter_cfg_t both = notch;
    torque_filter_t first;
    torque_filter_t second;

    both.smooth_rate_q15 = low_pass.smooth_rate_q15;
    torque_filter_start(&first, 0);
    torque_filter_start(&second, 0);
    for (uint32_t n = 0U; n < 300U; n++) {
        const int32_t current = ((n % 50U) < 20U) ? 9000 : -2000;
        const int32_t behind =
            torque_filter_step(&second, &notch, torque_filter_step(&first, &low_pass, current));

        /*
         * Between the two the result of the first is rounded to nearest, and that of the second is.
         */
        TEST_ASSERT_INT32_WITHIN(2, behind, step(&both, current));
    }
}

/* Roundings do not keep a swing up: after a swing as large as can be, nothing moves any more. */
TEST(test_no_swing_stays_after_a_swing)
{
    for (uint32_t number = 0U; number < EXAMPLES; number++) {
        const torque_filter_cfg_t cfg = example(number);
        int32_t lowest = CURRENT_MAX;
        int32_t highest = -CURRENT_MAX;

        setUp();
        for (uint32_t n = 0U; n < 2000U; n++) {
            (void)step(&cfg, ((n % 7U) < 3U) ? CURRENT_MAX : -CURRENT_MAX);
        }
        for (uint32_t n = 0U; n < 30000U; n++) {
            const int32_t result = step(&cfg, 100);

            if (n >= 25000U) {
                lowest = (result < lowest) ? result : lowest;
                highest = (result > highest) ? result : highest;
            }
        }
        TEST_ASSERT_INT32_WITHIN(1, 100, lowest);
        TEST_ASSERT_EQUAL_INT32(lowest, highest);
    }
}

static int32_t any_sign(seeded_t *seeded, int32_t most)
{
    return seeded_in(seeded, -most, most);
}

TEST(test_any_state_and_configuration_stays_within_what_is_stated)
{
    seeded_t seeded = {7U};

    for (uint32_t k = 0U; k < 300000U; k++) {
        const torque_filter_cfg_t cfg = {
            .smooth_rate_q15 = seeded_in(&seeded, 0, 32767),
            .notch_share_q15 = seeded_in(&seeded, 0, 32767),
            .notch_turn = {.sin = any_sign(&seeded, 32767), .cos = any_sign(&seeded, 32767)},
        };

        filter.origin = any_sign(&seeded, CURRENT_MAX);
        filter.smooth_q26 = any_sign(&seeded, SMOOTH_MAX);
        filter.swing_q26 = (dq_t){any_sign(&seeded, SWING_MAX), any_sign(&seeded, SWING_MAX)};
        TEST_ASSERT_TRUE(abs(step(&cfg, any_sign(&seeded, CURRENT_MAX))) <= RESULT_MAX);
        TEST_ASSERT_TRUE(abs(filter.smooth_q26) <= SMOOTH_MAX);
        TEST_ASSERT_TRUE((abs(filter.swing_q26.d) <= SWING_MAX) &&
                         (abs(filter.swing_q26.q) <= SWING_MAX));
    }
}

/* Turned by an eighth, a vector along the diagonal has all of its length, √2, in one part. */
TEST(test_the_swing_saturates_at_both_ends_in_both_parts)
{
    static const int32_t ends[] = {SWING_MAX - 1, -SWING_MAX};

    for (uint32_t k = 0U; k < 4U; k++) {
        const int32_t end = ends[k / 2U];
        const bool forwards = (k % 2U) == 0U;
        const torque_filter_cfg_t cfg = {
            .notch_share_q15 = 1, .notch_turn = {.sin = forwards ? 23170 : -23170, .cos = 23170}};

        filter.swing_q26 = (dq_t){end, end};
        (void)step(&cfg, 0);
        TEST_ASSERT_EQUAL_INT32(end, forwards ? filter.swing_q26.q : filter.swing_q26.d);
    }
}
