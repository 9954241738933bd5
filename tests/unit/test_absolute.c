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

/* The same frame for some ticks. */
static bool stand(uint32_t ticks, uint32_t frame)
{
    bool known = false;

    for (uint32_t k = 0U; k < ticks; k++) {
        known = absolute_step(&absolute, &cfg, (uint16_t)frame);
    }
    return known;
}

/* Good frames of a shaft that turns by `step` a tick. */
static void turn_by(int32_t step, uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        shaft = (uint16_t)((int32_t)shaft + step);
        (void)absolute_step(&absolute, &cfg, frame_of(shaft));
    }
}

/* Anew, and for long at this speed. */
static void begin_turning(int32_t step)
{
    absolute_start(&absolute);
    turn_by(step, 20U);
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

/* Each frame comes as far off as one may come: that of a sensor which is out of order. */
TEST(test_frames_that_run_away_leave_the_speed_within_half_a_turn_a_tick_both_ways)
{
    const int32_t half = 0x8000 * 16;

    for (int32_t side = -1; side <= 1; side += 2) {
        absolute_start(&absolute);
        turn_by(side * STEP, 200U);
        for (uint32_t k = 0U; k < 100000U; k++) {
            const int32_t step = absolute.speed / 16;
            const int32_t up = (side < 0) ? (LSB_Q16 - 1) : 0; /* a frame rounds down */

            shaft = (uint16_t)((uint32_t)absolute.angle + (uint32_t)(step + (step / 2) + up));
            (void)absolute_step(&absolute, &cfg, frame_of(shaft));
            TEST_ASSERT_INT32_WITHIN(half, 0, absolute.speed);
        }
        TEST_ASSERT_EQUAL_INT32(side * half, absolute.speed);
    }
}

/* The first frame is as far from 0 as the speed that is made of it. */
TEST(test_zero_and_frame_make_the_exact_angle_to_a_unit)
{
    cfg.zero = 1U;
    (void)absolute_step(&absolute, &cfg, frame_of(1004U));
    TEST_ASSERT_EQUAL_UINT16(2U * 1003U, absolute.ahead);
    (void)absolute_step(&absolute, &cfg, frame_of(1004U));
    TEST_ASSERT_EQUAL_UINT16(1003U, absolute.ahead);
}

TEST(test_zero_and_frame_of_a_reversed_sensor_make_the_exact_angle_to_a_unit)
{
    cfg.zero = 3001U;
    cfg.reversed = 1U;
    stand(2U, frame_of(1000U));
    TEST_ASSERT_EQUAL_UINT16(2001U, absolute.ahead);
}

TEST(test_a_bad_frame_leaves_the_angle_of_a_shaft_at_rest_to_a_unit)
{
    cfg.zero = 1U;
    stand(BRIDGE + 1U, frame_of(1004U));
    stand(1U, frame_of(1004U) ^ 1U);
    TEST_ASSERT_EQUAL_UINT16(1003U, absolute.ahead);
}

/* The angle before the first frame is 0. */
TEST(test_a_frame_counts_as_steady_within_a_sixteenth_of_a_turn_and_not_a_unit_further)
{
    const uint16_t most = 0x10000 / 16;

    for (uint32_t reversed = 0U; reversed <= 1U; reversed++) {
        cfg = (absolute_cfg_t){.reversed = reversed};
        absolute_start(&absolute);
        TEST_ASSERT_TRUE(stand(BRIDGE, frame_of(most)));
        cfg.zero = LSB_Q16 - 1;
        absolute_start(&absolute);
        TEST_ASSERT_FALSE(stand(BRIDGE, frame_of(most + LSB_Q16)));
        TEST_ASSERT_TRUE(stand(1U, frame_of(most + LSB_Q16)));
    }
}

TEST(test_a_bad_frame_while_the_angle_is_looked_for_starts_it_over)
{
    (void)stand(BRIDGE - 1U, frame_of(1000U));
    TEST_ASSERT_FALSE(stand(1U, frame_of(1000U) ^ 0x8000U));
    TEST_ASSERT_FALSE(stand(BRIDGE - 1U, frame_of(1000U)));
    TEST_ASSERT_TRUE(stand(1U, frame_of(1000U)));
}

TEST(test_an_angle_that_is_found_again_is_bridged_as_long_as_the_first_one)
{
    (void)stand(BRIDGE + 1U, frame_of(1000U));
    for (uint32_t k = 0U; k < 2U; k++) {
        TEST_ASSERT_TRUE(stand(BRIDGE, frame_of(1000U) ^ 0x8000U));
        TEST_ASSERT_FALSE(stand(1U, frame_of(1000U) ^ 0x8000U));
        TEST_ASSERT_TRUE(stand(BRIDGE, frame_of(1000U)));
    }
}

TEST(test_one_good_frame_is_enough_for_another_whole_bridge)
{
    (void)turn_good(200U);
    TEST_ASSERT_TRUE(turn_bad(BRIDGE, 1U));
    TEST_ASSERT_TRUE(turn_good(1U));
    TEST_ASSERT_TRUE(turn_bad(BRIDGE, 1U));
    TEST_ASSERT_FALSE(turn_bad(1U, 1U));
}

/* 4 units less in one tick make the mean of 16 a part of a unit less: 7, rounded down. */
TEST(test_the_same_frame_again_is_bad_from_two_lsb_a_tick_on)
{
    turn_by(2 * LSB_Q16, 20U);
    turn_by(0, 1U);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FRAME, absolute.trouble);

    begin_turning(2 * LSB_Q16);
    turn_by(LSB_Q16, 1U);
    turn_by(0, 1U);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, absolute.trouble);
}

TEST(test_a_flagged_frame_is_named_so_wherever_its_angle_is)
{
    (void)turn_good(200U);
    shaft = (uint16_t)(shaft + 0x8000U);
    (void)turn_bad(1U, 0xC000U);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FLAGGED, absolute.trouble);
}

/* 0.35° are 64 units. */
TEST(test_a_frame_of_a_slow_shaft_is_bad_from_a_unit_beyond_64_on)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        begin_turning(0);
        turn_by(side * 64, 1U);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, absolute.trouble);
    }
    begin_turning(0);
    turn_by(48, 1U); /* a speed of 48/16 */
    turn_by(3 + 65, 1U);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FRAME, absolute.trouble);
}

TEST(test_a_frame_of_a_fast_shaft_is_bad_from_an_lsb_beyond_half_its_speed_on)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        for (int32_t way = -1; way <= 1; way += 2) {
            begin_turning(side * 200);
            turn_by((side * 200) + (way * 100), 1U);
            TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, absolute.trouble);
            begin_turning(side * 200);
            turn_by((side * 200) + (way * (100 + LSB_Q16)), 1U);
            TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_FRAME, absolute.trouble);
        }
    }
}

TEST(test_the_speed_takes_a_sixteenth_of_what_a_frame_is_off)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        begin_turning(0);
        turn_by(side * 48, 1U);
        TEST_ASSERT_EQUAL_UINT16((uint16_t)(shaft + (side * 48 / 16)), absolute.ahead);
    }
}
