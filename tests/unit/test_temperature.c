/* SPDX-License-Identifier: MIT */
/* °C of the converter's counts, along a line of points. */
#include "temperature.h"

#include "testing.h"

#include <math.h>

#define COUNTS 4096U

static const temperature_line_t BENT = {
    .points = 4U,
    .at = {{1000, -20000}, {1500, 0}, {3000, 50000}, {3100, 100000}},
};

static void check(const temperature_line_t *line, uint16_t count, int32_t celsius)
{
    TEST_ASSERT_EQUAL_INT32(celsius, temperature_celsius(line, count));
}

TEST(test_each_point_and_half_way_between_two)
{
    check(&BENT, 1000U, -20);
    check(&BENT, 1250U, -10);
    check(&BENT, 1500U, 0);
    check(&BENT, 2250U, 25);
    check(&BENT, 3000U, 50);
    check(&BENT, 3050U, 75);
    check(&BENT, 3100U, 100);
}

TEST(test_beyond_its_ends_it_is_that_of_the_end)
{
    check(&BENT, 0U, -20);
    check(&BENT, 999U, -20);
    check(&BENT, 3101U, 100);
    check(&BENT, 4095U, 100);
}

TEST(test_a_sensor_that_falls_with_the_temperature)
{
    static const temperature_line_t falls = {
        .points = 3U,
        .at = {{4000, 0}, {2000, 40000}, {1000, 120000}},
    };

    check(&falls, 4095U, 0);
    check(&falls, 4000U, 0);
    check(&falls, 3000U, 20);
    check(&falls, 2000U, 40);
    check(&falls, 1500U, 80);
    check(&falls, 1000U, 120);
    check(&falls, 0U, 120);
}

TEST(test_halves_are_rounded_away_from_zero)
{
    static const temperature_line_t line = {.points = 2U, .at = {{0, -2000}, {4000, 2000}}};

    check(&line, 499U, -2);
    check(&line, 500U, -2);
    check(&line, 501U, -1);
    check(&line, 3499U, 1);
    check(&line, 3500U, 2);
}

/*
 * The widest that a board file allows: no product overflows. Truncation and rounding are half a
 * degree and 1 m°C.
 */
TEST(test_the_whole_range_of_a_line)
{
    static const temperature_line_t line = {.points = 2U, .at = {{0, -250000}, {4096, 250000}}};

    for (uint16_t count = 0U; count < COUNTS; count++) {
        const double exact = -250.0 + ((double)count * 500.0 / (double)COUNTS);
        TEST_ASSERT_TRUE(fabs((double)temperature_celsius(&line, count) - exact) <= 0.502);
    }
}

/*
 * A board file may state points whose counts round to one: at either end, or between. The rest of
 * the line is as ever.
 */
TEST(test_two_points_of_one_count_leave_the_rest_of_a_rising_line_as_it_is)
{
    static const temperature_line_t first = {.points = 3U,
                                             .at = {{0, -40000}, {0, -20000}, {4000, 100000}}};
    static const temperature_line_t middle = {
        .points = 4U, .at = {{0, -40000}, {1000, 0}, {1000, 10000}, {4000, 100000}}};
    static const temperature_line_t last = {.points = 3U,
                                            .at = {{0, -40000}, {4000, 100000}, {4000, 120000}}};

    check(&first, 0U, -40);
    check(&first, 1000U, 10);
    check(&first, 4000U, 100);
    check(&first, 4095U, 100);
    check(&middle, 500U, -20);
    check(&middle, 1000U, 0);
    check(&middle, 2000U, 40);
    check(&middle, 4095U, 100);
    check(&last, 2000U, 30);
    check(&last, 4000U, 100);
    check(&last, 4095U, 120);
}

TEST(test_two_points_of_one_count_leave_the_rest_of_a_falling_line_as_it_is)
{
    static const temperature_line_t first = {.points = 3U,
                                             .at = {{4096, -40000}, {4096, -20000}, {96, 100000}}};
    static const temperature_line_t last = {.points = 3U,
                                            .at = {{4000, -40000}, {0, 100000}, {0, 120000}}};

    check(&first, 4095U, -20);
    check(&first, 3096U, 10);
    check(&first, 96U, 100);
    check(&first, 0U, 100);
    check(&last, 4095U, -40);
    check(&last, 2000U, 30);
    check(&last, 0U, 100);
}

/* All that a board file says of its sensor lies below one count: nothing is divided by zero. */
TEST(test_a_line_of_one_count_is_within_its_points)
{
    static const temperature_line_t line = {.points = 2U, .at = {{10, 0}, {10, 2000}}};

    for (uint16_t count = 0U; count < COUNTS; count++) {
        const int32_t celsius = temperature_celsius(&line, count);
        TEST_ASSERT_TRUE(celsius >= 0 && celsius <= 2);
    }
}
