/* SPDX-License-Identifier: MIT */
/*
 * Oscillation: what goes on swinging is found with its amplitude and time; transients, noise and
 * asked motion are not.
 */
#include "example_cfg.h"
#include "oscillation.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>

#define TWO_PI (6.283185307179586)
#define FULL (16383)

static oscillation_cfg_t cfg;
static oscillation_t state;
static oscillation_in_t in;
static fault_t fault;

void setUp(void)
{
    cfg = example_oscillation_cfg();
    state = (oscillation_t){.now = 0U};
    in = (oscillation_in_t){0, 0};
    fault = (fault_t){.id = FAULT_NONE};
}

static bool step(double current)
{
    in.current = (int32_t)lround(fmin(fmax(current, -FULL), FULL));
    return oscillation_step(&state, &cfg, &in, &fault) != FAULT_NONE;
}

typedef struct {
    double amplitude;
    double period; /* slow periods */
    double mean;
    double damping; /* ζ */
} swing_t;

static double swing_at(const swing_t *swing, uint32_t k)
{
    const double phase = TWO_PI * k / swing->period;

    return swing->mean + (swing->amplitude * exp(-swing->damping * phase) * sin(phase));
}

/* Returns after how many slow periods it is found; 0: not in so many. */
static uint32_t found_after(const swing_t *swing, uint32_t periods)
{
    for (uint32_t k = 1U; k <= periods; k++) {
        if (step(swing_at(swing, k))) {
            return k;
        }
    }
    return 0U;
}

static void assert_found(bool expected, swing_t swing, uint32_t periods)
{
    oscillation_reset(&state);
    TEST_ASSERT_EQUAL(expected, found_after(&swing, periods) > 0U);
}

static const swing_t STEADY = {4000.0, 20.0, 0.0, 0.0};

/*
 * One half-wave to find a direction, one of each direction to compare with, and a part of one to
 * see the last turn.
 */
TEST(test_a_swing_is_found_after_its_half_waves_up_to_a_quarter_of_the_rate)
{
    static const double waves[] = {4.0, 7.3, 20.0, 101.0, 500.0};

    for (uint32_t k = 0U; k < (sizeof waves / sizeof waves[0]); k++) {
        const swing_t swing = {4000.0, waves[k], 3000.0, 0.0};
        const double half = waves[k] / 2.0;
        uint32_t after;

        setUp();
        after = found_after(&swing, 100000U);
        TEST_ASSERT_TRUE(after >= (uint32_t)(20.0 * half));
        TEST_ASSERT_TRUE(after <= (uint32_t)((24.0 * half) + 2.0));
        /* the time of 20 half-waves, each turning point on a grid of one */
        TEST_ASSERT_DOUBLE_WITHIN(2.0, 20.0 * half, state.span);
    }
}

TEST(test_value_and_limit_are_amplitudes_in_the_units_of_the_current)
{
    const swing_t swing = {4000.0, 20.0, -5000.0, 0.0};

    TEST_ASSERT_TRUE(found_after(&swing, 1000U) > 0U);
    TEST_ASSERT_EQUAL(FAULT_OSCILLATION, fault.id);
    TEST_ASSERT_INT32_WITHIN(1, 4000, fault.value);
    TEST_ASSERT_EQUAL_INT32(cfg.amplitude_max, fault.limit);
}

/* Both turning points rounded to a half LSB: a swing is within one of its height. */
TEST(test_a_swing_counts_from_the_amplitude_limit_on)
{
    assert_found(false, (swing_t){cfg.amplitude_max - 1.0, 20.0, 0.0, 0.0}, 10000U);
    assert_found(true, (swing_t){cfg.amplitude_max + 1.0, 20.0, 0.0, 0.0}, 10000U);
}

/* ln 2/(20π) = 0.011: the last of 20 half-waves is half the first. */
TEST(test_a_swing_that_dies_out_is_not_found_whatever_its_height)
{
    cfg.amplitude_max = 10;
    assert_found(false, (swing_t){FULL, 20.0, 0.0, 0.012}, 2000U);
    assert_found(true, (swing_t){FULL, 20.0, 0.0, 0.009}, 2000U);
}

/* Each change begins anew; between them less than 20 half-waves fit. */
TEST(test_a_motion_that_is_asked_for_is_no_swing)
{
    const swing_t swing = {8000.0, 20.0, 0.0, 0.0};

    for (uint32_t k = 1U; k <= 20000U; k++) {
        if ((k % 180U) == 0U) {
            in.motion = -in.motion + 1000;
        }
        TEST_ASSERT_FALSE(step(swing_at(&swing, k)));
    }
}

TEST(test_on_a_ramp_nothing_is_found)
{
    const swing_t swing = {4000.0, 20.0, 2000.0, 0.0};

    for (uint32_t k = 1U; k <= 1000U; k++) {
        in.motion++;
        TEST_ASSERT_FALSE(step(swing_at(&swing, k)));
    }
}

TEST(test_a_change_of_the_motion_forgets_what_was_counted)
{
    TEST_ASSERT_EQUAL_UINT32(0U, found_after(&STEADY, 190U));
    TEST_ASSERT_TRUE(state.halves > 10U);
    in.motion = 1;
    TEST_ASSERT_FALSE(step(0.0));
    TEST_ASSERT_EQUAL_UINT32(0U, state.halves);
    TEST_ASSERT_TRUE(found_after(&STEADY, 1000U) > 200U);
}

/*
 * Half-waves of 10 and of 35 in turn, so that each is unlike the last one of its direction: loads
 * that come and go.
 */
TEST(test_half_waves_of_unlike_lengths_are_no_swing)
{
    double level = 4000.0;

    for (uint32_t k = 0U; k < 1000U; k++) {
        const uint32_t hold = ((k % 4U) < 2U) ? 10U : 35U;

        level = -level;
        for (uint32_t n = 0U; n < hold; n++) {
            TEST_ASSERT_FALSE(step(level));
        }
    }
}

/* A square wave of 1 to 2 is a swing: what saturates is not symmetric. */
TEST(test_an_asymmetric_swing_is_found)
{
    bool found = false;

    for (uint32_t k = 0U; (k < 40U) && !found; k++) {
        const uint32_t hold = ((k % 2U) == 0U) ? 5U : 10U;

        for (uint32_t n = 0U; n < hold; n++) {
            found = found || step(((k % 2U) == 0U) ? 6000.0 : -1000.0);
        }
    }
    TEST_ASSERT_TRUE(found);
}

/* Ripple above the limit on a swing of five times its height, and no frequency in common. */
TEST(test_ripple_does_not_hide_a_large_swing)
{
    const swing_t swing = {10000.0, 50.0, 0.0, 0.0};
    const swing_t ripple = {2000.0, 3.7, 0.0, 0.0};
    bool found = false;

    for (uint32_t k = 1U; (k <= 1000U) && !found; k++) {
        found = step(swing_at(&swing, k) + swing_at(&ripple, k));
    }
    TEST_ASSERT_TRUE(found);
    TEST_ASSERT_DOUBLE_WITHIN(20.0, 500.0,
                              state.span); /* a turning point is off by ripple at most */
}

/* Uniform noise turns every one or two slow periods, whatever its size. */
TEST(test_noise_is_no_swing_whatever_its_size)
{
    seeded_t seed = {2463534242U};

    for (int32_t size = 1; size <= 4; size++) {
        const int32_t largest = fx_min(size * cfg.amplitude_max, 16384);

        for (uint32_t k = 0U; k < 100000U; k++) {
            TEST_ASSERT_FALSE(step(seeded_in(&seed, -largest, largest)));
        }
    }
}

/*
 * A half-wave, and a sixth of a wave until it has come back by a quarter of its height: 500 of 750
 * slow periods.
 */
TEST(test_what_is_slower_than_the_longest_half_wave_is_no_swing)
{
    assert_found(false, (swing_t){8000.0, 760.0, 0.0, 0.0}, 50000U);
    assert_found(true, (swing_t){8000.0, 740.0, 0.0, 0.0}, 50000U);
}

TEST(test_after_a_swing_is_found_the_count_begins_anew)
{
    const uint32_t first = found_after(&STEADY, 1000U);

    TEST_ASSERT_TRUE(first > 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, state.halves);
    TEST_ASSERT_TRUE(found_after(&STEADY, 1000U) >= 200U);
}

TEST(test_the_clock_may_wrap)
{
    state.now = UINT32_MAX - 100U;
    (void)step(0.0);
    in.motion = 1; /* begins anew at this time */
    TEST_ASSERT_FALSE(step(0.0));
    TEST_ASSERT_TRUE(found_after(&STEADY, 1000U) > 0U);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 200.0, state.span);
}

TEST(test_reset_forgets_everything_that_was_seen)
{
    const swing_t swing = {4000.0, 20.0, 100.0, 0.0};
    const oscillation_t fresh = state;

    in.motion = 1000;
    TEST_ASSERT_TRUE(found_after(&swing, 1000U) > 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, found_after(&swing, 195U));
    oscillation_reset(&state);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &state, sizeof state);
}

/* Whatever the samples are, the state stays within the ranges that state.def says. */
TEST(test_the_state_stays_in_its_ranges_for_any_samples)
{
    seeded_t seed = {88172645U};

    for (uint32_t k = 0U; k < 200000U; k++) {
        cfg.amplitude_max = ((k % 1000U) < 500U) ? 1 : FULL;
        in.current = seeded_in(&seed, -16384, 16384);
        in.motion = ((k % 300U) == 0U) ? seeded_in(&seed, -0x20000000, 0x20000000) : in.motion;
        (void)oscillation_step(&state, &cfg, &in, &fault);
        TEST_ASSERT_TRUE(state.halves < cfg.halves_max);
        TEST_ASSERT_INT32_WITHIN(16384, 0, state.extreme);
        TEST_ASSERT_INT32_WITHIN(16384, 0, state.turned);
        TEST_ASSERT_INT32_WITHIN(16384, 16384, state.highest);
        TEST_ASSERT_INT32_WITHIN(16383, 16383, state.back);
    }
}
