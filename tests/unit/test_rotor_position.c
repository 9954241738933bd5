/* SPDX-License-Identifier: MIT */
/* Rotor position: exact integration, wrap of the angle, count of turns. */
#include "rotor_position.h"
#include "seeded.h"
#include "testing.h"

#include <stdint.h>

#define ONE_TURN_Q32 ((int64_t)1 << 32)
#define SEEDED_STEPS (200000)

static rotor_position_t position;

void setUp(void)
{
    rotor_position_reset(&position, 0U);
}

TEST(test_reset_puts_the_rotor_at_the_angle_within_turn_zero)
{
    static const angle_t angles[] = {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU};

    for (uint32_t i = 0U; i < (sizeof angles / sizeof angles[0]); i++) {
        rotor_position_reset(&position, angles[i]);
        TEST_ASSERT_EQUAL_HEX32(angles[i], rotor_position_angle(&position));
        TEST_ASSERT_EQUAL_INT64((int64_t)angles[i], position.turns_q32);
    }
}

TEST(test_step_forward_over_the_end_of_a_turn_wraps_the_angle_and_counts_up)
{
    rotor_position_reset(&position, 0xFFFFFFFFU);
    rotor_position_step(&position, 3);
    TEST_ASSERT_EQUAL_HEX32(2U, rotor_position_angle(&position));
    TEST_ASSERT_EQUAL_INT64(ONE_TURN_Q32 + 2, position.turns_q32);
}

TEST(test_step_backward_over_zero_wraps_the_angle_and_counts_down)
{
    rotor_position_reset(&position, 1U);
    rotor_position_step(&position, -3);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFEU, rotor_position_angle(&position));
    TEST_ASSERT_EQUAL_INT64(-2, position.turns_q32);
}

TEST(test_largest_steps_are_taken_in_both_directions)
{
    rotor_position_step(&position, INT32_MAX);
    TEST_ASSERT_EQUAL_HEX32(0x7FFFFFFFU, rotor_position_angle(&position));
    rotor_position_step(&position, INT32_MIN);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFFU, rotor_position_angle(&position));
    TEST_ASSERT_EQUAL_INT64(-1, position.turns_q32);
}

TEST(test_constant_speed_of_one_unit_neither_rounds_nor_drifts)
{
    for (int32_t i = 0; i < SEEDED_STEPS; i++) {
        rotor_position_step(&position, -1);
    }
    TEST_ASSERT_EQUAL_INT64(-SEEDED_STEPS, position.turns_q32);
}

TEST(test_seeded_speeds_there_and_back_return_to_the_start)
{
    seeded_t there = {0x5EEDU};
    seeded_t back = {0x5EEDU};
    int64_t sum = 12345;

    rotor_position_reset(&position, 12345U);
    for (int32_t i = 0; i < SEEDED_STEPS; i++) {
        const step_t speed = seeded_in(&there, -INT32_MAX, INT32_MAX);

        sum += speed;
        rotor_position_step(&position, speed);
        TEST_ASSERT_EQUAL_HEX32((uint32_t)((uint64_t)sum & 0xFFFFFFFFU),
                                rotor_position_angle(&position));
    }
    for (int32_t i = 0; i < SEEDED_STEPS; i++) {
        rotor_position_step(&position, -seeded_in(&back, -INT32_MAX, INT32_MAX));
    }
    TEST_ASSERT_EQUAL_INT64(12345, position.turns_q32);
}

TEST(test_turn_count_wraps_at_both_ends)
{
    position.turns_q32 = INT64_MAX;
    rotor_position_step(&position, 1);
    TEST_ASSERT_EQUAL_INT64(INT64_MIN, position.turns_q32);
    rotor_position_step(&position, -1);
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, position.turns_q32);
}

/* Rounded down; 2^15 turns later the word is the same. */
TEST(test_turns_in_q16_are_rounded_down_and_wrap)
{
    static const struct {
        int64_t turns_q32;
        int32_t turns_q16;
    } rows[] = {
        {0x12345FFFFLL, 0x12345},
        {-1, -1},
        {-0x10000, -1},
        {-0x10001, -2},
        {0x7FFFFFFFFFFFLL, INT32_MAX},
        {0x800000000000LL, INT32_MIN},
        {0x1000000010000LL, 1},
    };

    for (size_t k = 0U; k < (sizeof rows / sizeof rows[0]); k++) {
        position.turns_q32 = rows[k].turns_q32;
        TEST_ASSERT_EQUAL_HEX32(rows[k].turns_q16, rotor_position_turns_q16(&position));
    }
}
