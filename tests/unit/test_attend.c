/* SPDX-License-Identifier: MIT */
/*
 * An ordinary tick leaves attend_step() out: from any state within state.def, with any frame, that
 * changes no word of the state but those that attend_sensor() changes, where there is a sensor.
 */
#include "any_state.h"
#include "attend.h"
#include "drive.h"
#include "example_cfg.h"
#include "instant.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"

#include <string.h>

#define STATES (40000)
#define CURRENT_MAX_COUNT (3891) /* (16384 + protection.current_max) / 8 = 3891.25 */

static drive_cfg_t cfg;
static seeded_t seed;

void setUp(void)
{
    seed = (seeded_t){0xA77E9U};
}

static drive_in_t any_frame(void)
{
    return (drive_in_t){
        .command = {.target = seeded_i32(&seed),
                    .mode = (uint8_t)seeded_in(&seed, 0, 255),
                    .request = (uint8_t)seeded_in(&seed, 0, 255)},
        .adc_ia = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_ib = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_bus = (uint16_t)seeded_in(&seed, 0, 65535),
        .adc_temperature = (uint16_t)seeded_in(&seed, 0, 65535),
        .angle = (uint16_t)seeded_in(&seed, 0, 65535),
        .flags = (uint16_t)seeded_in(&seed, 0, 65535),
    };
}

/*
 * In RUN, with nothing in state or frame that ends it at once, but for the current of one phase in
 * eight.
 */
static void make_ordinary(drive_t *drive, drive_in_t *in)
{
    drive->state = DRIVE_STATE_RUN;
    drive->limits = protection_limits(&cfg.protection, true);
    drive->sensors.offset_a = 16384;
    drive->sensors.offset_b = 16384;
    state_guard_keep_measured(&drive->state_guard, drive);
    in->command.request = DRIVE_REQUEST_RUN;
    in->flags = 0U;
    in->adc_ia = (uint16_t)seeded_in(&seed, 1400, 2700);
    in->adc_ib = (uint16_t)seeded_in(&seed, 1400, 2700);
    in->adc_bus = (uint16_t)seeded_in(&seed, 2700, 2900);
    if (seeded_in(&seed, 0, 7) == 0) {
        in->adc_ia = (uint16_t)(CURRENT_MAX_COUNT + seeded_in(&seed, 0, 1));
        in->adc_ib = 2048U;
    }
}

/* Returns whether this tick is an ordinary one. */
static bool leaves_nothing_out(const drive_t *from, const drive_in_t *in)
{
    const bool ordinary = attend_is_ordinary(from, in, instant_sample(from, in));

    if (ordinary) {
        drive_t attended = *from;
        drive_t expected = *from;
        const bool goes_on =
            !drive_has_sensor(from) || attend_sensor(&expected, in, instant_sample(from, in));

        TEST_ASSERT_EQUAL(goes_on, attend_step(&attended, in, instant_sample(from, in)));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &attended, sizeof attended);
    }
    return ordinary;
}

TEST(test_a_tick_of_any_frame_is_ordinary_only_where_nothing_is_to_be_attended_to)
{
    for (int32_t with = 0; with < 2; with++) {
        cfg = (with == 0) ? example_drive_cfg() : example_drive_cfg_with_startup();
        for (int32_t k = 0; k < STATES; k++) {
            const drive_t from = any_state(&seed, &cfg);
            const drive_in_t in = any_frame();

            (void)leaves_nothing_out(&from, &in);
        }
    }
}

TEST(test_what_an_ordinary_tick_leaves_out_would_change_nothing_but_what_the_sensor_does)
{
    int32_t count = 0;

    for (int32_t k = 0; k < STATES; k++) {
        drive_t from;
        drive_in_t in;

        cfg = ((k & 1) != 0) ? example_drive_cfg_with_startup() : example_drive_cfg();
        if ((k & 2) != 0) {
            cfg.voltage_drive = example_voltage_drive_cfg();
        }
        if ((k & 12) == 12) {
            cfg.sampling.sensor_pole_pairs = 2U;
        }
        from = any_state(&seed, &cfg);
        in = any_frame();
        make_ordinary(&from, &in);
        count += leaves_nothing_out(&from, &in) ? 1 : 0;
    }
    TEST_ASSERT_GREATER_THAN_INT32(STATES / 2, count);
    TEST_ASSERT_LESS_THAN_INT32(STATES, count);
}

TEST(test_no_tick_in_which_something_is_to_be_attended_to_is_ordinary)
{
    drive_t from;
    drive_in_t in;

    cfg = example_drive_cfg();
    for (uint32_t bit = 0U; bit < 8U; bit++) {
        from = any_state(&seed, &cfg);
        in = any_frame();
        make_ordinary(&from, &in);
        in.adc_ia = 2048U;
        in.adc_ib = 2048U;
        TEST_ASSERT_TRUE(attend_is_ordinary(&from, &in, instant_sample(&from, &in)));
        in.command.request ^= (uint8_t)(1U << bit);
        TEST_ASSERT_FALSE(attend_is_ordinary(&from, &in, instant_sample(&from, &in)));
        in.command.request = DRIVE_REQUEST_RUN;
        in.flags = (uint16_t)(1U << bit);
        TEST_ASSERT_FALSE(attend_is_ordinary(&from, &in, instant_sample(&from, &in)));
    }
}
