/* SPDX-License-Identifier: MIT */
/* Pulse pattern of the simulated inverter: duty, symmetry, dead time. */
#include "inverter.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

#define COUNTS 4250U
#define PERIOD_S 1.0e-4
#define TICK_S (PERIOD_S / (2.0 * COUNTS))
#define DEAD_S 2.0e-6
#define RANDOM_PERIODS 20000

/* A period of 100 us in doubles: a handful of roundings of 2^-53 of it. */
#define ROUNDING_S 1.0e-18

static plant_inverter_t inverter;
static plant_pattern_t pattern;

static void start(double dead_time_s)
{
    const plant_inverter_cfg_t cfg = {1.0 / PERIOD_S, COUNTS, dead_time_s};
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_inverter_init(&inverter, &cfg, &bad), bad);
}

static void period(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t compare[PLANT_LEGS] = {a, b, c};

    plant_inverter_pattern(&inverter, compare, &pattern);
}

/* Time during which a leg's high side is closed. */
static double high_s(unsigned leg)
{
    double sum_s = 0.0;

    for (unsigned k = 0; k < pattern.count; k++) {
        const plant_segment_t *s = &pattern.segment[k];
        sum_s += (((s->high >> leg) & 1U) != 0U) ? s->duration_s : 0.0;
    }
    return sum_s;
}

static void check_segment(unsigned k, double duration_s, unsigned high, unsigned low)
{
    TEST_ASSERT_TRUE(k < pattern.count);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_S, duration_s, pattern.segment[k].duration_s);
    TEST_ASSERT_EQUAL_UINT8(high, pattern.segment[k].high);
    TEST_ASSERT_EQUAL_UINT8(low, pattern.segment[k].low);
}

void setUp(void)
{
    start(0.0);
}

TEST(test_pattern_is_symmetric_about_mid_period)
{
    period(1000, 3000, 2000);
    TEST_ASSERT_EQUAL_UINT(7, pattern.count);
    check_segment(0, 1250.0 * TICK_S, 0, 7);
    check_segment(1, 1000.0 * TICK_S, 2, 5);
    check_segment(2, 1000.0 * TICK_S, 6, 1);
    check_segment(3, 2000.0 * TICK_S, 7, 0);
    check_segment(4, 1000.0 * TICK_S, 6, 1);
    check_segment(5, 1000.0 * TICK_S, 2, 5);
    check_segment(6, 1250.0 * TICK_S, 0, 7);
}

TEST(test_high_time_is_compare_over_counts_of_the_period)
{
    static const uint32_t compares[] = {0, 1, 2, 2125, 4248, 4249, 4250};

    for (size_t k = 0; k < sizeof compares / sizeof compares[0]; k++) {
        const uint32_t compare[PLANT_LEGS] = {compares[k], 2125, COUNTS - compares[k]};
        plant_inverter_pattern(&inverter, compare, &pattern);
        for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_S, PERIOD_S * compare[leg] / COUNTS, high_s(leg));
        }
    }
}

TEST(test_equal_compares_switch_together)
{
    period(2000, 2000, 2000);
    TEST_ASSERT_EQUAL_UINT(3, pattern.count);
    check_segment(1, 4000.0 * TICK_S, 7, 0);
}

TEST(test_compare_beyond_the_counter_is_full_on)
{
    period(5000, 0, UINT32_MAX);
    TEST_ASSERT_EQUAL_UINT(1, pattern.count);
    check_segment(0, PERIOD_S, 5, 2);
}

TEST(test_dead_time_delays_each_turn_on)
{
    start(DEAD_S);
    period(1000, 0, 0);
    TEST_ASSERT_EQUAL_UINT(5, pattern.count);
    check_segment(0, 3250.0 * TICK_S, 0, 7);
    check_segment(1, DEAD_S, 0, 6);
    check_segment(2, 2000.0 * TICK_S - DEAD_S, 1, 6);
    check_segment(3, DEAD_S, 0, 6);
    check_segment(4, 3250.0 * TICK_S - DEAD_S, 0, 7);
}

TEST(test_pulse_shorter_than_the_dead_time_never_closes_its_switch)
{
    start(DEAD_S);
    period(50, 0, 0); /* 100 ticks = 1.18 us */
    TEST_ASSERT_EQUAL_UINT(3, pattern.count);
    check_segment(0, 4200.0 * TICK_S, 0, 7);
    check_segment(1, 100.0 * TICK_S + DEAD_S, 0, 6);
    check_segment(2, 4200.0 * TICK_S - DEAD_S, 0, 7);
}

TEST(test_low_pulse_shorter_than_the_dead_time_leaves_the_leg_open_into_the_next_period)
{
    start(DEAD_S);
    period(COUNTS, 0, 0);       /* rises at the start */
    period(COUNTS, 0, 0);       /* stays on */
    period(COUNTS - 10U, 0, 0); /* low for 10 ticks at each end */
    check_segment(0, 10.0 * TICK_S + DEAD_S, 0, 6);
    check_segment(1, PERIOD_S - 20.0 * TICK_S - DEAD_S, 1, 6);
    check_segment(2, 10.0 * TICK_S, 0, 6);
    period(COUNTS - 10U, 0, 0);
    check_segment(0, 10.0 * TICK_S + DEAD_S, 0, 6);
}

TEST(test_dead_time_runs_on_across_the_period_end)
{
    const double left_s = DEAD_S - 10.0 * TICK_S;

    start(DEAD_S);
    period(COUNTS - 10U, 0, 0);
    period(0, 0, 0);
    TEST_ASSERT_EQUAL_UINT(2, pattern.count);
    check_segment(0, left_s, 0, 6);
    check_segment(1, PERIOD_S - left_s, 0, 7);
}

TEST(test_steady_full_duty_needs_no_dead_time)
{
    start(DEAD_S);
    period(COUNTS, 0, 0);
    check_segment(0, DEAD_S, 0, 6);
    period(COUNTS, 0, 0);
    TEST_ASSERT_EQUAL_UINT(1, pattern.count);
    check_segment(0, PERIOD_S, 1, 6);
}

TEST(test_off_opens_all_legs_and_forgets_their_commands)
{
    start(DEAD_S);
    period(COUNTS, 0, 0);
    plant_inverter_off(&inverter, &pattern);
    TEST_ASSERT_EQUAL_UINT(1, pattern.count);
    check_segment(0, PERIOD_S, 0, 0);
    period(0, 0, 0);
    TEST_ASSERT_EQUAL_UINT(1, pattern.count);
    check_segment(0, PERIOD_S, 0, 7);
}

/* One leg's switching history over many periods. */
typedef struct {
    bool last;     /* closed switch: high */
    double open_s; /* since the last closed switch */
} history_t;

static void follow(history_t *history, const plant_segment_t *s, unsigned leg)
{
    const bool high = ((s->high >> leg) & 1U) != 0U;
    const bool low = ((s->low >> leg) & 1U) != 0U;

    TEST_ASSERT_FALSE(high && low);
    if (!high && !low) {
        history->open_s += s->duration_s;
        return;
    }
    if (high != history->last) {
        TEST_ASSERT_TRUE(history->open_s >= DEAD_S * (1.0 - 1.0e-9));
    }
    history->last = high;
    history->open_s = 0.0;
}

TEST(test_no_leg_ever_changes_sides_without_its_dead_time)
{
    seeded_t seeded = {12345U};
    history_t history[PLANT_LEGS] = {{false, 0.0}, {false, 0.0}, {false, 0.0}};

    start(DEAD_S);
    for (int k = 0; k < RANDOM_PERIODS; k++) {
        uint32_t compare[PLANT_LEGS];
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            /* Half of them near an end, where pulses are shorter than the dead time. */
            const uint32_t near_end = (uint32_t)seeded_in(&seeded, 0, 200);
            const uint32_t any = (uint32_t)seeded_in(&seeded, 0, (int32_t)COUNTS);
            const uint32_t kind = seeded_u32(&seeded) % 4U;
            compare[leg] = (kind == 0U) ? near_end : (kind == 1U) ? COUNTS - near_end : any;
        }
        plant_inverter_pattern(&inverter, compare, &pattern);
        double sum_s = 0.0;
        TEST_ASSERT_TRUE(pattern.count <= PLANT_SEGMENTS_MAX);
        for (unsigned n = 0; n < pattern.count; n++) {
            TEST_ASSERT_TRUE(pattern.segment[n].duration_s > 0.0);
            sum_s += pattern.segment[n].duration_s;
            for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
                follow(&history[leg], &pattern.segment[n], leg);
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_S, PERIOD_S, sum_s);
    }
}

static void check_refused(double frequency_hz, uint32_t counts, double dead_s, const char *field)
{
    const plant_inverter_cfg_t wrong = {frequency_hz, counts, dead_s};
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_inverter_init(&inverter, &wrong, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    check_refused(0.0, COUNTS, 0.0, "inverter.pwm_frequency_hz");
    check_refused(1.0e4, 1, 0.0, "inverter.timer_counts");
    check_refused(1.0e4, 70000, 0.0, "inverter.timer_counts");
    check_refused(1.0e4, COUNTS, -1.0e-6, "inverter.dead_time_s");
    check_refused(1.0e4, COUNTS, 26.0e-6, "inverter.dead_time_s");
}
