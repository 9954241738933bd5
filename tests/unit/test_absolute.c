/* SPDX-License-Identifier: MIT */
/* Absolute sensor: what is a good frame, how a bad one is bridged, when the angle is lost and
 * found. */
#include "absolute.h"
#include "testing.h"

#include <stdint.h>

#define BRIDGE ABSOLUTE_BRIDGE_TICKS
#define LSB_Q16 (4) /* of the frame's 14 bits */
#define STEP (40)   /* of the shaft a tick, 2^16 a turn: 366 rpm at 10 kHz */

static absolute_cfg_t cfg;
static absolute_t absolute;
static uint16_t shaft; /* the angle that the sensor has read */

void setUp(void)
{
    cfg = (absolute_cfg_t){.zero = 0U};
    absolute_start(&absolute);
    shaft = 10000U;
}

/* A good frame of an angle. */
static uint16_t frame_of(uint16_t angle)
{
    const uint16_t bits = (uint16_t)(angle >> 2U);

    return (uint16_t)(bits | ((__builtin_popcount(bits) & 1) << 15));
}

static bool turn_good(uint32_t ticks)
{
    bool known = false;

    for (uint32_t k = 0U; k < ticks; k++) {
        shaft = (uint16_t)(shaft + STEP);
        known = absolute_step(&absolute, &cfg, frame_of(shaft));
    }
    return known;
}

/* The shaft turns on, and each frame comes with these bits flipped. */
static bool turn_bad(uint32_t ticks, uint16_t flipped)
{
    bool known = false;

    for (uint32_t k = 0U; k < ticks; k++) {
        shaft = (uint16_t)(shaft + STEP);
        known = absolute_step(&absolute, &cfg, (uint16_t)(frame_of(shaft) ^ flipped));
    }
    return known;
}

/* A tick later the shaft is a step further. */
static void expect_angle(int32_t tolerance)
{
    TEST_ASSERT_INT16_WITHIN(tolerance, (int16_t)(shaft + STEP), (int16_t)absolute.ahead);
}

TEST(test_the_angle_is_known_after_as_many_good_frames_as_may_be_bridged)
{
    TEST_ASSERT_FALSE(turn_good(BRIDGE));
    TEST_ASSERT_TRUE(turn_good(1U));
}

/* The speed is the mean of 16 ticks, each off by at most an LSB: the lead is off by as much. */
TEST(test_the_angle_is_a_tick_ahead_of_the_frame)
{
    (void)turn_good(200U);
    expect_angle(2 * LSB_Q16);
}

TEST(test_zero_and_direction_of_the_sensor)
{
    cfg.zero = 3000U;
    cfg.reversed = 1U;
    for (uint32_t k = 0U; k < 20U; k++) {
        (void)absolute_step(&absolute, &cfg, frame_of(1000U));
    }
    TEST_ASSERT_INT32_WITHIN(LSB_Q16, 2000, absolute.ahead);
}

/* While it is bridged, the error of the speed, an LSB at most, counts for each tick. */
TEST(test_each_bit_of_bad_frames_is_found_and_bridged_with_the_last_speed)
{
    for (uint32_t bit = 0U; bit < 16U; bit++) {
        absolute_start(&absolute);
        (void)turn_good(200U);
        TEST_ASSERT_TRUE(turn_bad(BRIDGE, (uint16_t)(1U << bit)));
        expect_angle((int32_t)(BRIDGE + 2U) * LSB_Q16);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FRAME, absolute.trouble);
        TEST_ASSERT_TRUE(turn_good(1U));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, absolute.trouble);
    }
}

TEST(test_a_frame_more_than_the_bridge_loses_the_angle)
{
    (void)turn_good(200U);
    TEST_ASSERT_TRUE(turn_bad(BRIDGE, 1U));
    TEST_ASSERT_FALSE(turn_bad(1U, 1U));
    TEST_ASSERT_FALSE(turn_good(BRIDGE - 1U));
    TEST_ASSERT_TRUE(turn_good(1U));
    expect_angle(20 * LSB_Q16); /* the speed is that of one tick at first */
}

TEST(test_the_error_flag_of_the_sensor_is_named)
{
    (void)turn_good(200U);
    (void)turn_bad(1U, 0xC000U); /* with its parity */
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FLAGGED, absolute.trouble);
}

/* From two LSB a tick on: 82, 302 and 1200 rpm at 10 kHz. */
TEST(test_frames_that_stand_still_while_the_shaft_turns_are_bridged_and_then_lost)
{
    static const uint32_t speeds[] = {9U, 33U, 131U};

    for (uint32_t s = 0U; s < 3U; s++) {
        uint16_t still;

        absolute_start(&absolute);
        for (uint32_t k = 0U; k < 200U; k++) {
            shaft = (uint16_t)(shaft + speeds[s]);
            (void)absolute_step(&absolute, &cfg, frame_of(shaft));
        }
        still = frame_of(shaft);
        for (uint32_t k = 1U; k <= BRIDGE; k++) {
            TEST_ASSERT_TRUE(absolute_step(&absolute, &cfg, still));
            TEST_ASSERT_INT16_WITHIN(10 * LSB_Q16, (int16_t)(shaft + (speeds[s] * (k + 1U))),
                                     (int16_t)absolute.ahead);
        }
        TEST_ASSERT_FALSE(absolute_step(&absolute, &cfg, still));
    }
}

TEST(test_a_wire_that_stays_high_or_low_loses_the_angle_of_a_turning_shaft)
{
    static const uint16_t levels[] = {0x0000U, 0xFFFFU};

    for (uint32_t k = 0U; k < 2U; k++) {
        absolute_start(&absolute);
        shaft = 30000U;
        (void)turn_good(200U);
        for (uint32_t tick = 0U; tick <= BRIDGE; tick++) {
            (void)absolute_step(&absolute, &cfg, levels[k]);
        }
        TEST_ASSERT_FALSE(absolute.known);
    }
}

/* Each frame comes as far ahead as one may come: that of a sensor which is out of order. */
TEST(test_frames_that_run_away_leave_the_speed_within_half_a_turn_a_tick)
{
    (void)turn_good(200U);
    for (uint32_t k = 0U; k < 200000U; k++) {
        const int32_t step = absolute.speed / 16;

        shaft = (uint16_t)((uint32_t)absolute.angle + (uint32_t)(step + (step / 2)));
        (void)absolute_step(&absolute, &cfg, frame_of(shaft));
        TEST_ASSERT_INT32_WITHIN(0x8000 * 16, 0, absolute.speed);
    }
}
