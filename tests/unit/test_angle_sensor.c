/* SPDX-License-Identifier: MIT */
#include "angle_sensor.h"
#include "testing.h"

#include <stdint.h>

#define LIMIT (1 << 28)
#define CHANGE (0x20000000) /* no limit of its own */
#define QUARTER (0x40000000U)
#define EIGHTH (0x20000000U)
#define ZERO (0x01234567U) /* of a sensor that is mounted anyhow */
#define RAMP (1000)        /* change of the speed in a tick */

static angle_sensor_t sensor;

void setUp(void)
{
    sensor = (angle_sensor_t){.speed = 0};
}

static void assert_is(int64_t turns_q32, step_t speed)
{
    TEST_ASSERT_EQUAL_INT64(turns_q32, sensor.position.turns_q32);
    TEST_ASSERT_EQUAL_INT32(speed, sensor.speed);
}

/* e = 2^20: θ̂ += 0 + e/2^3, ω̂ += e/2^8. */
TEST(test_an_error_moves_angle_and_speed_by_their_shares)
{
    angle_sensor_step(&sensor, 1U << 20U, LIMIT, CHANGE);
    assert_is(1 << 17, 1 << 12);
    setUp();
    angle_sensor_step(&sensor, 0U - (1U << 20U), LIMIT, CHANGE);
    assert_is(-(1 << 17), -(1 << 12));
}

/* The step of the tick comes first: at its true speed the loop has no error. */
TEST(test_a_rotor_at_the_speed_of_the_loop_changes_nothing_but_the_angle)
{
    sensor.speed = 12345;
    for (uint32_t k = 1U; k <= 100U; k++) {
        angle_sensor_step(&sensor, 12345U * k, LIMIT, CHANGE);
        assert_is(12345LL * k, 12345);
    }
}

/* Over the end of a turn the error is the shorter way, and whole turns are counted. */
TEST(test_turns_are_counted_over_the_end_of_a_turn)
{
    sensor.position.turns_q32 = 0xFFFFFFFFLL;
    angle_sensor_step(&sensor, 7U, LIMIT, CHANGE);
    assert_is(0x100000000LL, 0); /* e = 8 */
    sensor.position.turns_q32 = 7;
    angle_sensor_step(&sensor, 0xFFFFFFFFU, LIMIT, CHANGE);
    assert_is(6, -1); /* e = −8, rounded down */
}

TEST(test_the_speed_stays_within_its_limit_in_either_direction)
{
    sensor.speed = LIMIT - 1;
    angle_sensor_step(&sensor, (angle_t)LIMIT + QUARTER, LIMIT, CHANGE);
    TEST_ASSERT_EQUAL_INT32(LIMIT, sensor.speed);
    setUp();
    sensor.speed = 1 - LIMIT;
    angle_sensor_step(&sensor, 0U - ((angle_t)LIMIT + QUARTER), LIMIT, CHANGE);
    TEST_ASSERT_EQUAL_INT32(-LIMIT, sensor.speed);
}

/*
 * With x and v the errors of angle and speed before a tick, e = x, and after it x' = x(1 − 1/8) +
 * v', v' = v − x/256 for a rotor at constant acceleration a: v' = v + a − x/256. At rest x = 256·a,
 * less the rounding of two shifts.
 */
TEST(test_at_constant_acceleration_the_angle_lags_by_256_changes_of_the_speed)
{
    uint32_t measured = 0U;
    int32_t speed = 0;
    angle_t ahead = 0U;

    for (uint32_t k = 0U; k < 400U; k++) {
        speed += RAMP;
        measured += (uint32_t)speed;
        ahead = measured - (rotor_position_angle(&sensor.position) + (angle_t)sensor.speed);
        angle_sensor_step(&sensor, measured, LIMIT, CHANGE);
    }
    TEST_ASSERT_UINT32_WITHIN(256U, 256U * (uint32_t)RAMP, ahead);
}

TEST(test_start_is_at_rest_at_its_position)
{
    sensor.speed = 77;
    angle_sensor_start(&sensor, -0x123456789ALL);
    assert_is(-0x123456789ALL, 0);
}

/* The words of the position and of the speed; the last of a negative position at a negative speed.
 */
/* 60° at once: without the limit the speed would rise by 1/32 of them a tick for a while. */
TEST(test_what_the_sensor_corrects_at_once_is_no_speed_beyond_the_limit_of_its_change)
{
    const step_t change = 1000;
    step_t before = 0;

    angle_sensor_start(&sensor, 0);
    for (uint32_t k = 0U; k < 200U; k++) {
        (void)angle_sensor_step(&sensor, 0x2AAAAAABU, LIMIT, change);
        TEST_ASSERT_TRUE(fx_abs(sensor.speed - before) <= change);
        before = sensor.speed;
    }
    TEST_ASSERT_INT32_WITHIN(0x2AAAAAAB / 100, 0x2AAAAAAB,
                             (int32_t)rotor_position_angle(&sensor.position));
}

TEST(test_a_flip_of_any_bit_is_seen_until_the_next_tick_and_none_else)
{
    TEST_ASSERT_TRUE(angle_sensor_holds(&sensor));
    angle_sensor_start(&sensor, -0x123456789ALL);
    TEST_ASSERT_TRUE(angle_sensor_holds(&sensor));
    for (uint32_t bit = 0U; bit < 64U; bit++) {
        const uint64_t flip = (uint64_t)1U << bit;

        angle_sensor_step(&sensor, QUARTER, LIMIT, CHANGE);
        TEST_ASSERT_TRUE(angle_sensor_holds(&sensor));
        sensor.position.turns_q32 ^= (int64_t)flip;
        TEST_ASSERT_FALSE(angle_sensor_holds(&sensor));
        sensor.position.turns_q32 ^= (int64_t)flip;
        sensor.speed ^= (step_t)(1U << (bit % 32U));
        TEST_ASSERT_FALSE(angle_sensor_holds(&sensor));
        sensor.speed ^= (step_t)(1U << (bit % 32U));
    }
}

TEST(test_start_forgets_zero_and_lead_of_before)
{
    sensor.zero = 5U;
    sensor.lead = 9;
    angle_sensor_start(&sensor, QUARTER);
    TEST_ASSERT_EQUAL_UINT32(0U, sensor.zero);
    TEST_ASSERT_EQUAL_INT32(0, sensor.lead);
    TEST_ASSERT_EQUAL_INT64(QUARTER, angle_sensor_position(&sensor).turns_q32);
}

/* An eighth of a turn ahead of the loop, in turn 3: the zero moves by an eighth as well. */
TEST(test_after_an_alignment_the_reading_of_before_is_the_angle_aligned_to)
{
    const rotor_position_t aligned = {.turns_q32 = (3LL << 32) + QUARTER + EIGHTH};
    const angle_t reading = QUARTER - ZERO; /* of the loop before */

    angle_sensor_start(&sensor, QUARTER);
    sensor.zero = ZERO;
    sensor.lead = 9;
    angle_sensor_align(&sensor, aligned);
    TEST_ASSERT_TRUE(angle_sensor_holds(&sensor));
    TEST_ASSERT_EQUAL_UINT32(ZERO + EIGHTH, sensor.zero);
    TEST_ASSERT_EQUAL_INT32(0, sensor.lead);
    assert_is(aligned.turns_q32, 0);
    TEST_ASSERT_EQUAL_INT32(0, angle_sensor_step(&sensor, reading, LIMIT, CHANGE));
    assert_is(aligned.turns_q32, 0);
}

static void assert_meets(angle_t loop, int64_t met, int64_t nearest)
{
    angle_sensor_start(&sensor, (7LL << 32) + loop);
    angle_sensor_meet(&sensor, (rotor_position_t){.turns_q32 = met});
    TEST_ASSERT_TRUE(angle_sensor_holds(&sensor));
    TEST_ASSERT_EQUAL_INT64(nearest, sensor.position.turns_q32);
    TEST_ASSERT_EQUAL_INT32(met - nearest, sensor.lead);
    TEST_ASSERT_EQUAL_INT64(met, angle_sensor_position(&sensor).turns_q32);
}

TEST(test_met_the_loop_keeps_its_angle_in_the_nearest_turn_and_the_lead_makes_up_the_rest)
{
    const int64_t turns = 5LL << 32;

    assert_meets(EIGHTH, turns + QUARTER, turns + EIGHTH);
    assert_meets(QUARTER, turns + EIGHTH, turns + QUARTER);
    assert_meets(0U - EIGHTH, turns + EIGHTH, turns - EIGHTH); /* over the end of a turn */
    assert_meets(EIGHTH, turns - EIGHTH, turns + EIGHTH);
}

TEST(test_the_lead_loses_a_64th_in_a_tick_whichever_its_sign)
{
    const int32_t lead = 1 << 20;

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        angle_sensor_start(&sensor, 0);
        sensor.lead = sign * lead;
        (void)angle_sensor_step(&sensor, 0U, LIMIT, CHANGE);
        TEST_ASSERT_EQUAL_INT32(sign * (lead - (lead / 64)), sensor.lead);
        TEST_ASSERT_EQUAL_INT64(sensor.lead, angle_sensor_position(&sensor).turns_q32);
    }
}

TEST(test_a_tick_returns_how_far_the_reading_lies_ahead_of_the_expected_angle)
{
    sensor.speed = 1000;
    sensor.zero = 500U;
    TEST_ASSERT_EQUAL_INT32(300, angle_sensor_step(&sensor, 800U, LIMIT, CHANGE));
    setUp();
    TEST_ASSERT_EQUAL_INT32(-300, angle_sensor_step(&sensor, 0U - 300U, LIMIT, CHANGE));
}
