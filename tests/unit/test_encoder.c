/* SPDX-License-Identifier: MIT */
/* Encoder: angle from the counter, what the index corrects, names and lets pass. */
#include "encoder.h"
#include "testing.h"

#include <math.h>
#include <stdint.h>

#define COUNTS \
    (4000) /* a turn; no power of two, so that turn and counter wrap at different places */

static encoder_cfg_t cfg;
static encoder_t encoder;
static uint32_t counter; /* as the timer has it, 16 bits of it */

void setUp(void)
{
    cfg = (encoder_cfg_t){
        .counts = COUNTS, .scale_q32 = (uint32_t)(0x100000000ULL / COUNTS), .has_index = 1U};
    encoder_start(&encoder);
    counter = 65000U;
}

/* A tick in which the counter moves, without an index. */
static uint16_t move(int32_t counts)
{
    counter += (uint32_t)counts;
    return encoder_step(&encoder, &cfg, (encoder_reading_t){.counter = (uint16_t)counter});
}

/* A tick in which the counter moves and an index has come `before` counts ago. */
static void index_at(int32_t counts, int32_t before)
{
    counter += (uint32_t)counts;
    (void)encoder_step(&encoder, &cfg,
                       (encoder_reading_t){.counter = (uint16_t)counter,
                                           .index = (uint16_t)(counter - (uint32_t)before),
                                           .indexed = true});
}

static void turn_without_index(int32_t counts)
{
    const int32_t step = (counts > 0) ? 100 : -100;

    encoder.speed = ((cfg.reversed != 0U) ? -step : step) * 16; /* it has been turning */
    for (int32_t k = 0; k < (counts / step); k++) {
        (void)move(step);
    }
}

/* count·2^16/COUNTS, rounded down twice: by less than one unit each. */
static void expect_count(int32_t count)
{
    const int32_t exact = (int32_t)(((int64_t)count * 65536) / COUNTS);

    TEST_ASSERT_INT32_WITHIN(1, exact, (int32_t)move(0));
}

TEST(test_the_angle_begins_at_0_wherever_the_counter_is)
{
    TEST_ASSERT_EQUAL_UINT16(0U, move(0));
}

TEST(test_the_angle_follows_over_the_wraps_of_turn_and_counter_both_ways)
{
    (void)move(0);
    for (int32_t k = 1; k <= 2000; k++) {
        (void)move(77);
        expect_count((77 * k) % COUNTS);
    }
    turn_without_index(-77 * 2000);
    (void)move(-(77 * 2000) % 100);
    expect_count(0);
}

TEST(test_a_reversed_encoder_counts_the_other_way)
{
    cfg.reversed = 1U;
    (void)move(0);
    (void)move(-1000);
    expect_count(1000);
}

TEST(test_a_counter_that_leaps_by_more_than_a_quarter_turn_is_named)
{
    (void)move(0);
    (void)move(COUNTS / 4);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    (void)move((COUNTS / 4) + 1);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
}

/* Two indexes at count 60 of the turn; the shaft is at count 100 then. */
static void learn_index(void)
{
    (void)move(0);
    index_at(100, 40);
    turn_without_index(COUNTS - 100);
    index_at(100, 40);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
}

/* A turn in which `lost` counts get lost. */
static void turn_and_lose(int32_t lost)
{
    turn_without_index(COUNTS - 100);
    index_at(100 - lost, 40);
}

TEST(test_two_indexes_bring_lost_counts_back_and_the_first_one_names_them)
{
    learn_index();
    turn_and_lose(30);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    expect_count(70);
    turn_and_lose(0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
    expect_count(100);
}

TEST(test_an_index_brings_the_lost_counts_of_a_reversed_encoder_back_too)
{
    cfg.reversed = 1U;
    (void)move(0);
    index_at(-100, -40);
    turn_without_index(-(COUNTS - 100));
    index_at(-100, -40);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    for (int32_t k = 0; k < 2; k++) {
        turn_without_index(-(COUNTS - 100));
        index_at((k == 0) ? -70 : -100, -40);
    }
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
    expect_count(100);
}

TEST(test_counts_that_get_lost_in_each_turn_are_brought_back)
{
    learn_index();
    for (int32_t k = 0; k < 10; k++) {
        turn_and_lose(30);
        TEST_ASSERT_NOT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    }
    expect_count(100);
}

TEST(test_an_index_off_by_two_counts_is_good_and_changes_nothing)
{
    learn_index();
    turn_without_index(COUNTS - 100);
    index_at(100, 38);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    expect_count(100);
}

/* Anywhere in the turn, also close to the index. */
TEST(test_a_pulse_that_disturbs_the_index_changes_nothing)
{
    for (int32_t at = 0; at < COUNTS; at += 100) {
        encoder_start(&encoder);
        learn_index();
        turn_without_index(at);
        index_at(0, 0);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
        expect_count((100 + at) % COUNTS);
        turn_without_index(COUNTS - at);
        index_at(0, 40);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
        expect_count(100);
    }
}

TEST(test_pulses_that_disturb_the_index_and_follow_each_other_change_nothing)
{
    learn_index();
    turn_without_index(1000);
    encoder.speed = 16;
    for (int32_t k = 0; k < 20; k++) {
        index_at(1, 0);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    }
    expect_count(1120);
}

TEST(test_a_pulse_before_the_first_index_is_not_taken_for_it)
{
    (void)move(0);
    turn_without_index(1000);
    index_at(0, 0);
    turn_without_index(COUNTS - 1000);
    index_at(100, 40);
    turn_and_lose(0);
    turn_and_lose(0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    expect_count(100);
}

TEST(test_an_index_far_off_counts_only_when_it_comes_there_twice)
{
    learn_index();
    turn_without_index(1000);
    index_at(0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    expect_count(1100);
    turn_without_index(COUNTS);
    index_at(0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
    expect_count(60);
}

TEST(test_a_single_index_far_off_is_forgotten_by_a_good_one)
{
    learn_index();
    turn_without_index(1000);
    index_at(0, 0);
    turn_without_index(COUNTS - 1000);
    index_at(0, 40);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    turn_without_index(1000);
    index_at(0, 0);
    expect_count(1100);
}

TEST(test_two_turns_without_an_index_are_named_once)
{
    uint32_t named = 0U;

    encoder.speed = 100 * 16;
    for (int32_t k = 0; k < 90; k++) {
        (void)move(100);
        named += (encoder.trouble == (uint8_t)SHAFT_TROUBLE_INDEX) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(1U, named);
}

/* 8 counts a tick, 1172 rpm at 10 kHz: then it stands still, or dithers by a count. */
TEST(test_a_counter_that_does_not_follow_the_shaft_loses_the_angle_within_four_ticks)
{
    for (int32_t dither = 0; dither <= 1; dither++) {
        encoder_start(&encoder);
        encoder.speed = 8 * 16;
        for (int32_t k = 0; k < 200; k++) {
            (void)move(8);
            TEST_ASSERT_TRUE(encoder.known);
        }
        for (int32_t k = 0; k < 3; k++) {
            (void)move(((k & 1) != 0) ? dither : -dither);
            TEST_ASSERT_TRUE(encoder.known);
        }
        (void)move(0);
        TEST_ASSERT_FALSE(encoder.known);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
        (void)move(0);
        TEST_ASSERT_TRUE(encoder.known);
    }
}

/* 0.05 counts a tick more in each tick: 30000 rad/s² at 20 kHz and 4096 counts. */
TEST(test_the_acceleration_of_a_small_motor_and_its_reversal_lose_nothing)
{
    int32_t at = 0;

    for (int32_t k = 0; k < 1200; k++) {
        const int32_t from_top = k - 600;
        const int32_t to = 9000 - ((from_top * from_top) / 40); /* turns back at 600 */

        if (k == 0) {
            at = to - 30; /* it has its speed already */
            encoder.speed = 30 * 16;
        }
        (void)move(to - at);
        at = to;
        TEST_ASSERT_TRUE(encoder.known);
    }
}

/* 0 to 3000 rad/s with 30000 rad/s² at 20 kHz, and back, for few and many counts. */
TEST(test_the_acceleration_of_a_small_motor_loses_nothing_with_any_number_of_counts)
{
    static const int32_t turns[] = {64, 1024, 4096, 16384, 65532};

    for (uint32_t k = 0U; k < (sizeof(turns) / sizeof(turns[0])); k++) {
        const double gain = 30000.0 / (20000.0 * 20000.0) / 6.283185307 * turns[k];
        double speed = 0.0;
        double at = 0.0;

        cfg.counts = turns[k];
        cfg.scale_q32 = (uint32_t)(0x100000000ULL / (uint32_t)turns[k]);
        encoder_start(&encoder);
        for (int32_t tick = 0; tick < 8000; tick++) {
            const int32_t before = (int32_t)floor(at);

            speed += ((tick % 4000) < 2000) ? gain : -gain;
            at += speed;
            (void)move((int32_t)floor(at) - before);
            TEST_ASSERT_TRUE(encoder.known);
        }
    }
}

TEST(test_an_encoder_without_an_index_misses_none)
{
    cfg.has_index = 0U;
    encoder.speed = 100 * 16;
    for (int32_t k = 0; k < 90; k++) {
        (void)move(100);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    }
}

/* A fan at 6000 rpm counts as far within 90 minutes. */
TEST(test_an_encoder_without_an_index_counts_beyond_a_whole_word)
{
    const int32_t step = 30000;
    const uint32_t ticks = 0x80000000U / 30000U + 10U;

    cfg.has_index = 0U;
    (void)move(0);
    for (uint32_t k = 0U; k < ticks; k++) {
        (void)move(step);
    }
    expect_count((int32_t)(((int64_t)ticks * step) % COUNTS));
    TEST_ASSERT_TRUE(encoder.known);
}
