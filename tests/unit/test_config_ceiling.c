/* SPDX-License-Identifier: MIT */
/*
 * The ceilings of an image: each limit that another configuration lifts is named, and what protects
 * as well or better is not.
 */
#include "config_ceiling.h"

#include "example_cfg.h"
#include "testing.h"

static drive_cfg_t image;
static drive_cfg_t cfg;

void setUp(void)
{
    image = example_drive_cfg();
    image.derating.temperature = (fade_t){.zero = 3000, .gain = 300, .shift = 4U};
    image.derating.temperature_lowest = 100;
    image.derating.temperature_highest = 4000;
    image.derating.temperature_periods = 25U;
    image.derating.heat = (fade_t){.zero = 16384, .gain = 500, .shift = 2U};
    image.derating.heat_rate = 20000;
    image.derating.heat_rate_shift = 9U;
    cfg = image;
}

static void assert_crossed(const char *path, bool with_motor)
{
    TEST_ASSERT_EQUAL_STRING(path, config_ceiling_crossed(&image, &cfg, with_motor));
    cfg = image;
}

/* One more than the image has is too much; one less is not. */
static void assert_most(const char *path, int32_t *setting, bool is_of_motor)
{
    *setting += 1;
    assert_crossed(path, true);
    *setting += 1;
    assert_crossed(is_of_motor ? NULL : path, false);
    *setting -= 1;
    assert_crossed(NULL, true);
}

TEST(test_the_images_own_configuration_crosses_nothing)
{
    assert_crossed(NULL, true);
    assert_crossed(NULL, false);
}

TEST(test_no_limit_of_the_board_is_lifted)
{
    assert_most("protection.current_max", &cfg.protection.current_max, false);
    assert_most("protection.bus_max", &cfg.protection.bus_max, false);
    assert_most("protection.offset_max", &cfg.protection.offset_max, false);
    assert_most("derating.temperature_highest", &cfg.derating.temperature_highest, false);
    cfg.derating.temperature_lowest--;
    assert_crossed("derating.temperature_lowest", false);
    cfg.derating.temperature_lowest++;
    assert_crossed(NULL, false);
}

TEST(test_an_angle_that_no_sensor_tells_is_believed_by_no_other_configuration_than_the_images)
{
    cfg.sampling.sensor_pole_pairs = 4U;
    assert_crossed("sensor.kind", false);
    cfg.sampling.sensor_pole_pairs = 4U;
    cfg.sensor.kind = SENSOR_KIND_ABSOLUTE;
    assert_crossed(NULL, true);
    image.sampling.sensor_pole_pairs = 4U; /* of a binding with an angle */
    cfg = image;
    assert_crossed(NULL, true);
    image.sensor.kind = SENSOR_KIND_ABSOLUTE;
    assert_crossed("sensor.kind", false);
}

/* An image whose motor is an example knows the limits of no motor. */
TEST(test_no_limit_of_the_motor_is_lifted_where_the_image_knows_it)
{
    assert_most("derating.current_max", &cfg.derating.current_max, true);
    assert_most("derating.current_continuous", &cfg.derating.current_continuous, true);
    assert_most("derating.heat_max_q14", &cfg.derating.heat_max_q14, true);
    cfg.derating.heat_gain--;
    assert_crossed("derating.heat_gain", true);
    cfg.derating.heat_shift--;
    assert_crossed("derating.heat_gain", true);
    cfg.derating.heat_gain++;
    assert_crossed(NULL, true);
    cfg.derating.heat.zero++;
    assert_crossed("derating.heat", true);
}

/* At a hot stage the counts are high with a positive gain, and low with a negative one. */
TEST(test_a_temperature_is_neither_higher_nor_on_the_other_side)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        image.derating.temperature.gain = side * 300;
        cfg = image;
        cfg.derating.temperature.zero += side;
        assert_crossed("derating.temperature", false);
        cfg.derating.temperature.zero -= side;
        assert_crossed(NULL, false);
        cfg.derating.temperature.gain = 0;
        assert_crossed("derating.temperature", false);
        cfg.derating.temperature.gain = -side;
        assert_crossed("derating.temperature", false);
    }
    image.derating.temperature.gain = 0;
    cfg = image;
    cfg.derating.temperature.zero = 65535;
    assert_crossed(NULL, false);
}

/* Twice the slow period has half as many periods in the same time, and twice the rate. */
TEST(test_times_are_compared_whatever_the_slow_period_is)
{
    cfg.derating.temperature_periods = 26U;
    assert_crossed(NULL, false);
    cfg.derating.temperature_periods = 27U;
    assert_crossed("derating.temperature_periods", false);
    cfg.slow_ticks = 2U * image.slow_ticks;
    cfg.derating.temperature_periods = 13U;
    cfg.derating.heat_rate_shift = 8U;
    assert_crossed(NULL, true);
    cfg.slow_ticks = 2U * image.slow_ticks;
    cfg.derating.temperature_periods = 14U;
    assert_crossed("derating.temperature_periods", false);
    cfg.slow_ticks = 2U * image.slow_ticks;
    cfg.derating.temperature_periods = 13U;
    assert_crossed("derating.heat_rate", true);
}

/* 20000 − 19 is off by less than one of 1024, − 20 by more. */
TEST(test_a_rate_may_be_off_by_its_rounding)
{
    cfg.derating.heat_rate -= 19;
    assert_crossed(NULL, true);
    cfg.derating.heat_rate -= 20;
    assert_crossed("derating.heat_rate", true);
    cfg.derating.heat_rate = 0;
    assert_crossed("derating.heat_rate", true);
}
