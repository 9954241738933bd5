/* °C of the converter's counts, along a line of points. */
#include "temperature.h"

#include "unity.h"

#include <math.h>

#define COUNTS 4096U

void setUp(void)
{
}

void tearDown(void)
{
}

static const temperature_line_t BENT = {
    .points = 4U,
    .at = {{1000, -20000}, {1500, 0}, {3000, 50000}, {3100, 100000}},
};

static void check(const temperature_line_t *line, uint16_t count, int32_t celsius)
{
    TEST_ASSERT_EQUAL_INT32(celsius, temperature_celsius(line, count));
}

static void test_each_point_and_half_way_between_two(void)
{
    check(&BENT, 1000U, -20);
    check(&BENT, 1250U, -10);
    check(&BENT, 1500U, 0);
    check(&BENT, 2250U, 25);
    check(&BENT, 3000U, 50);
    check(&BENT, 3050U, 75);
    check(&BENT, 3100U, 100);
}

static void test_beyond_its_ends_it_is_that_of_the_end(void)
{
    check(&BENT, 0U, -20);
    check(&BENT, 999U, -20);
    check(&BENT, 3101U, 100);
    check(&BENT, 4095U, 100);
}

static void test_a_sensor_that_falls_with_the_temperature(void)
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

static void test_halves_are_rounded_away_from_zero(void)
{
    static const temperature_line_t line = {.points = 2U, .at = {{0, -2000}, {4000, 2000}}};

    check(&line, 499U, -2);
    check(&line, 500U, -2);
    check(&line, 501U, -1);
    check(&line, 3499U, 1);
    check(&line, 3500U, 2);
}

/* The widest that a board file allows: no product overflows. Truncation and rounding are half a degree and 1 m°C. */
static void test_the_whole_range_of_a_line(void)
{
    static const temperature_line_t line = {.points = 2U, .at = {{0, -250000}, {4096, 250000}}};

    for (uint16_t count = 0U; count < COUNTS; count++) {
        const double exact = -250.0 + ((double)count * 500.0 / (double)COUNTS);
        TEST_ASSERT_TRUE(fabs((double)temperature_celsius(&line, count) - exact) <= 0.502);
    }
}

static void test_two_points_of_one_count_divide_nothing_by_zero(void)
{
    static const temperature_line_t line = {.points = 3U, .at = {{10, 0}, {10, 1000}, {20, 2000}}};

    for (uint16_t count = 0U; count < COUNTS; count++) {
        const int32_t celsius = temperature_celsius(&line, count);
        TEST_ASSERT_TRUE(celsius >= 0 && celsius <= 2);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_point_and_half_way_between_two);
    RUN_TEST(test_beyond_its_ends_it_is_that_of_the_end);
    RUN_TEST(test_a_sensor_that_falls_with_the_temperature);
    RUN_TEST(test_halves_are_rounded_away_from_zero);
    RUN_TEST(test_the_whole_range_of_a_line);
    RUN_TEST(test_two_points_of_one_count_divide_nothing_by_zero);
    return UNITY_END();
}
