/* SPDX-License-Identifier: MIT */
/*
 * Hall signals that were recorded on real motors: sectors of 49° to 70°, accelerations, reversals
 * and standstills.
 */
#include "hall.h"
#include "hall_captures.h"
#include "testing.h"

#include <math.h>
#include <stdint.h>

/* order of the patterns with the angle, the same in all recordings */
#define NEVER_FAST (0x7FFFFFFF)
#define PATTERNS (2U | (3U << 3U) | (1U << 6U) | (5U << 9U) | (4U << 12U) | (6U << 15U))
#define CAPTURES (sizeof(HALL_CAPTURES) / sizeof(HALL_CAPTURES[0]))
#define TURN (65536.0)
#define SECTORS_BEFORE (12U) /* the angle is not compared in the first two turns */
/* An edge counts in the second sample with its pattern, so the angle may be as far beyond it. */
#define SAMPLES_LATE (2.0)
/* an edge counts in the second sample, and corrects the angle by half; from the next on it binds */
#define TAKEN (2U)
/*
 * The middle of a sector of 60° is off by 17.3° in the root of the mean square. Of this the
 * interpolation has to leave no more than a third.
 */
#define RMS_MAX (17.3 / 3.0)

/* begins_q16 has steps of 0.0055°. */
#define ROUNDING_DEG (0.01)

typedef struct {
    double squares;
    uint32_t compared;
    uint32_t troubles;
    uint32_t unknown;
    double
        outside; /* furthest beyond an end of its sector, less what SAMPLES_LATE allows, degrees */
} result_t;

static hall_cfg_t cfg;
static hall_t hall;
static double speed_before_q16; /* in the sample before: an angle that waits stays where it was */

void setUp(void)
{
    hall_start(&hall);
}

static double degrees(double turn_q16)
{
    return remainder(turn_q16 * 360.0 / TURN, 360.0);
}

static uint32_t sector_of(uint32_t pattern)
{
    uint32_t sector = 0U;

    while (((PATTERNS >> (3U * sector)) & 7U) != pattern) {
        sector++;
    }
    return sector;
}

/* Direction of the edge from one entry to the next, 1 or −1. */
static int direction(const hall_capture_t *capture, uint32_t k)
{
    const uint32_t from = sector_of(capture->edge[k].pattern);
    const uint32_t to = sector_of(capture->edge[k + 1U].pattern);

    return (to == ((from + 1U) % 6U)) ? 1 : -1;
}

static double begin_of(const hall_capture_t *capture, uint32_t sector)
{
    return (double)capture->begins_q16[sector % 6U] + ((sector >= 6U) ? TURN : 0.0);
}

static void take_sample(result_t *result, const hall_capture_t *capture, uint32_t k)
{
    speed_before_q16 = fabs((double)hall.speed) / TURN;
    if (!hall_step(&hall, &cfg, (hall_reading_t){.pattern = capture->edge[k].pattern})) {
        result->unknown++;
    }
    if (hall.trouble != (uint8_t)SHAFT_TROUBLE_NONE) {
        result->troubles++;
    }
}

/* How far the angle is out of its sector, in degrees, less what it may for the late edge. */
static double outside(const hall_capture_t *capture, uint32_t sector, double angle_q16)
{
    const double begin = begin_of(capture, sector);
    const double half = (begin_of(capture, sector + 1U) - begin) / 2.0;
    const double late = fmax(fabs((double)hall.speed) / TURN, speed_before_q16) * SAMPLES_LATE;

    return fabs(degrees(angle_q16 - begin - half)) - degrees(half + late);
}

/* One entry: between two edges of one direction the truth is the line through both. */
static void take_entry(result_t *result, const hall_capture_t *capture, uint32_t k)
{
    const uint32_t samples = capture->edge[k].samples;
    const uint32_t sector = sector_of(capture->edge[k].pattern);
    const double begin = begin_of(capture, sector);
    const double end = begin_of(capture, sector + 1U);
    const int way = direction(capture, k);
    const int goes_on = (k >= SECTORS_BEFORE) && (direction(capture, k - 1U) == way);

    for (uint32_t n = 0U; n < samples; n++) {
        take_sample(result, capture, k);
        const double share = ((double)n + 0.5) / (double)samples;
        const double truth =
            (way > 0) ? begin + (share * (end - begin)) : end - (share * (end - begin));
        const double angle = (double)hall.angle / TURN;

        if (goes_on != 0) {
            result->squares += degrees(angle - truth) * degrees(angle - truth);
            result->compared++;
        }
        if ((k > 0U) && (n >= TAKEN)) {
            result->outside = fmax(result->outside, outside(capture, sector, angle));
        }
    }
}

static result_t play(const hall_capture_t *capture)
{
    result_t result = {.outside = -360.0};

    cfg = (hall_cfg_t){.patterns = PATTERNS, .fast_speed = NEVER_FAST};
    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        cfg.edges_q16[k] = capture->begins_q16[k];
    }
    hall_start(&hall);
    for (uint32_t k = 0U; (k + 1U) < capture->edges; k++) {
        take_entry(&result, capture, k);
    }
    return result;
}

TEST(test_recorded_signals_give_the_angle_to_a_third_of_what_the_sector_leaves)
{
    for (uint32_t k = 0U; k < CAPTURES; k++) {
        const result_t result = play(&HALL_CAPTURES[k]);
        const double rms = sqrt(result.squares / result.compared);

        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(RMS_MAX, 0.0, rms, HALL_CAPTURES[k].name);
    }
}

TEST(test_recorded_signals_never_take_the_angle_out_of_their_sector)
{
    for (uint32_t k = 0U; k < CAPTURES; k++) {
        const result_t result = play(&HALL_CAPTURES[k]);

        TEST_ASSERT_TRUE_MESSAGE(result.outside < ROUNDING_DEG, HALL_CAPTURES[k].name);
    }
}

TEST(test_recorded_signals_are_no_trouble_and_known_from_the_second_sample_on)
{
    for (uint32_t k = 0U; k < CAPTURES; k++) {
        const result_t result = play(&HALL_CAPTURES[k]);

        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0U, result.troubles, HALL_CAPTURES[k].name);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(1U, result.unknown, HALL_CAPTURES[k].name);
    }
}
