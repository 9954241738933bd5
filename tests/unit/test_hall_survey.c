/* SPDX-License-Identifier: MIT */
/*
 * The survey of Hall signals: what it sums while a vector turns, and when it is complete.
 */
#include "hall_survey.h"
#include "testing.h"

#include <math.h>
#include <string.h>

#define TURN_TICKS (360)
#define PI (3.14159265358979323846)
/* A sine of the firmware is off by 2 LSB at most, the angle by 1 of 2^16 of a turn. */
#define SINE_LSB (2.0 + (32768.0 * 2.0 * PI / 65536.0))

static hall_survey_t survey;

void setUp(void)
{
    memset(&survey, 0, sizeof survey);
}

static int32_t turns_q16(int32_t tick)
{
    return (int32_t)lround(65536.0 * tick / TURN_TICKS);
}

/* Signal 1 is high from 30° to 210°, signal 2 from 100° to 340°, signal 3 never. */
static uint32_t levels_at(int32_t tick)
{
    const int32_t deg = ((tick % TURN_TICKS) + TURN_TICKS) % TURN_TICKS;

    return (((deg >= 30) && (deg < 210)) ? 1U : 0U) | (((deg >= 100) && (deg < 340)) ? 2U : 0U);
}

static void run(int32_t from, int32_t ticks, int32_t direction)
{
    for (int32_t k = 0; k < ticks; k++) {
        const int32_t tick = from + (direction * k);

        hall_survey_step(&survey, levels_at(tick), turns_q16(tick));
    }
}

static void assert_signal(uint32_t k, double from_deg, double to_deg, int32_t turns)
{
    const hall_survey_signal_t *const signal = &survey.signals[k];
    double cosines = 0.0;
    double sines = 0.0;

    for (double deg = from_deg; deg < to_deg; deg += 1.0) {
        cosines += 32768.0 * turns * cos(deg * PI / 180.0);
        sines += 32768.0 * turns * sin(deg * PI / 180.0);
    }
    TEST_ASSERT_EQUAL_INT32(turns * (int32_t)(to_deg - from_deg), signal->high);
    TEST_ASSERT_DOUBLE_WITHIN(SINE_LSB * signal->high, cosines, signal->middle.d);
    TEST_ASSERT_DOUBLE_WITHIN(SINE_LSB * signal->high, sines, signal->middle.q);
}

TEST(test_before_its_begin_it_is_complete)
{
    TEST_ASSERT_TRUE(hall_survey_is_done(&survey));
}

TEST(test_it_lasts_its_ticks_and_the_one_in_which_it_notes_the_turn)
{
    hall_survey_begin(&survey, 10U);
    for (int32_t k = 0; k < 11; k++) {
        TEST_ASSERT_FALSE(hall_survey_is_done(&survey));
        hall_survey_step(&survey, 7U, -100 + (3 * k));
    }
    TEST_ASSERT_TRUE(hall_survey_is_done(&survey));
    TEST_ASSERT_EQUAL_INT32(-100, survey.start_q16);
    TEST_ASSERT_EQUAL_INT32(30, survey.turn_q16);
    for (uint32_t k = 0U; k < HALL_SURVEY_SIGNALS; k++) {
        TEST_ASSERT_EQUAL_INT32(10, survey.signals[k].high);
    }
}

TEST(test_the_sums_point_to_the_middle_and_tell_the_width_both_ways)
{
    for (int32_t direction = -1; direction <= 1; direction += 2) {
        hall_survey_begin(&survey, 3U * TURN_TICKS);
        run(17, (3 * TURN_TICKS) + 1, direction);
        TEST_ASSERT_TRUE(hall_survey_is_done(&survey));
        assert_signal(0U, 30.0, 210.0, 3);
        assert_signal(1U, 100.0, 340.0, 3);
        assert_signal(2U, 0.0, 0.0, 3);
        TEST_ASSERT_EQUAL_INT32(turns_q16(17), survey.start_q16);
        TEST_ASSERT_INT32_WITHIN(1, direction * 3 * 65536, survey.turn_q16);
    }
}

TEST(test_the_angle_may_wrap)
{
    hall_survey_begin(&survey, 2U);
    hall_survey_step(&survey, 0U, INT32_MAX);
    hall_survey_step(&survey, 0U, INT32_MIN);
    hall_survey_step(&survey, 0U, INT32_MIN + 9);
    TEST_ASSERT_EQUAL_INT32(10, survey.turn_q16);
}

/* A vector that rests at 0° and at 180°, with signals that are high all the time. */
TEST(test_the_longest_survey_does_not_overflow)
{
    for (int32_t half = 0; half < 2; half++) {
        hall_survey_begin(&survey, HALL_SURVEY_TICKS_MAX);
        for (int32_t k = 0; k <= HALL_SURVEY_TICKS_MAX; k++) {
            hall_survey_step(&survey, 7U, 32768 * half);
        }
        TEST_ASSERT_TRUE(hall_survey_is_done(&survey));
        TEST_ASSERT_INT32_WITHIN(2 * HALL_SURVEY_TICKS_MAX, (half == 0) ? INT32_MAX : -INT32_MAX,
                                 survey.signals[2].middle.d);
        TEST_ASSERT_EQUAL_INT32(HALL_SURVEY_TICKS_MAX, survey.signals[2].high);
    }
}

TEST(test_a_new_one_begins_from_zero)
{
    hall_survey_begin(&survey, 2U);
    hall_survey_step(&survey, 7U, 5);
    hall_survey_begin(&survey, 1U);
    hall_survey_step(&survey, 1U, 7);
    hall_survey_step(&survey, 1U, 8);
    TEST_ASSERT_EQUAL_INT32(1, survey.signals[0].high);
    TEST_ASSERT_EQUAL_INT32(0, survey.signals[1].high);
    TEST_ASSERT_EQUAL_INT32(7, survey.start_q16);
}
