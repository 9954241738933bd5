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

TEST(test_the_count_stays_within_a_turn_at_its_ends)
{
    (void)move(0);
    (void)move(-1);
    TEST_ASSERT_EQUAL_INT32(COUNTS - 1, encoder.count);
    (void)move(1);
    TEST_ASSERT_EQUAL_INT32(0, encoder.count);
    (void)move(-77);
    TEST_ASSERT_EQUAL_INT32(COUNTS - 77, encoder.count);
    (void)move(76);
    (void)move(1);
    TEST_ASSERT_EQUAL_INT32(0, encoder.count);
}

/* It is near count 0, where no index has been; another one elsewhere would be named if it were. */
static void expect_no_known_place(void)
{
    turn_without_index(COUNTS);
    index_at(100, 100);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    index_at(100, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
}

TEST(test_one_index_after_a_start_is_not_the_known_place)
{
    (void)move(0);
    expect_no_known_place();
}

TEST(test_counts_that_do_not_follow_forget_both_the_place_of_the_index_and_the_odd_one)
{
    learn_index();
    turn_without_index(COUNTS - 200);
    index_at(100, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    for (int32_t k = 0; k < 4; k++) {
        (void)move(0);
    }
    TEST_ASSERT_FALSE(encoder.known);
    expect_no_known_place();
}

TEST(test_an_index_where_the_count_began_is_known_like_any_other)
{
    (void)move(0);
    for (int32_t k = 0; k < 3; k++) {
        turn_without_index(COUNTS - 100);
        index_at(100, 0);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    }
    index_at(100, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
}

TEST(test_an_index_off_by_more_than_two_counts_is_named_on_both_sides)
{
    static const int32_t offs[] = {-3, -2, 2, 3};

    for (uint32_t k = 0U; k < (sizeof(offs) / sizeof(offs[0])); k++) {
        const bool good = (offs[k] >= -2) && (offs[k] <= 2);

        encoder_start(&encoder);
        learn_index();
        turn_without_index(COUNTS - 100);
        index_at(100, 40 - offs[k]);
        TEST_ASSERT_EQUAL_UINT8(good ? SHAFT_TROUBLE_NONE : SHAFT_TROUBLE_INDEX, encoder.trouble);
    }
}

TEST(test_an_index_of_a_reversed_encoder_is_good_wherever_in_the_tick_it_comes)
{
    cfg.reversed = 1U;
    (void)move(0);
    index_at(-100, -40);
    turn_without_index(-(COUNTS - 100));
    index_at(-100, -40);
    turn_without_index(-(COUNTS - 100));
    index_at(-80, -20);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
}

/* An index at count 1100, where the shaft is then; the known place is at 60. */
static void find_odd_index(void)
{
    encoder_start(&encoder);
    learn_index();
    turn_without_index(1000);
    index_at(0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
}

TEST(test_two_odd_indexes_are_at_the_same_place_within_a_sixteenth_of_a_turn)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        find_odd_index();
        turn_without_index(COUNTS);
        index_at(0, side * (COUNTS / 16));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
        find_odd_index();
        turn_without_index(COUNTS);
        index_at(0, side * ((COUNTS / 16) + 1));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    }
}

TEST(test_two_odd_indexes_count_once_the_shaft_has_turned_more_than_half_between_them)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        find_odd_index();
        turn_without_index(side * (COUNTS / 2));
        index_at(0, side * (COUNTS / 2));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
        find_odd_index();
        turn_without_index(side * (COUNTS / 2));
        index_at(side, side * ((COUNTS / 2) + 1));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
    }
}

/* A count a tick, with an index in the last one. */
static void creep_to_index(int32_t counts)
{
    for (int32_t k = 1; k < counts; k++) {
        (void)move(1);
    }
    index_at(1, 0);
}

/* A sixteenth of a turn is one count there. */
TEST(test_two_odd_indexes_of_an_encoder_with_16_counts_are_the_same_within_two_counts)
{
    cfg.counts = 16;
    cfg.scale_q32 = 0x10000000U;
    for (int32_t apart = 2; apart <= 3; apart++) {
        encoder_start(&encoder);
        (void)move(0);
        creep_to_index(16);
        creep_to_index(16);
        creep_to_index(5);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
        creep_to_index(16 + apart);
        TEST_ASSERT_EQUAL_UINT8((apart == 2) ? SHAFT_TROUBLE_COUNTS : SHAFT_TROUBLE_INDEX,
                                encoder.trouble);
    }
}

/* The odd ones are at count 3900, also near 0; the good one comes 160 counts later. */
TEST(test_a_good_index_between_two_odd_ones_keeps_them_from_being_the_same)
{
    learn_index();
    turn_without_index(COUNTS - 200);
    index_at(0, 0);
    turn_without_index(200);
    index_at(0, 40);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
    turn_without_index(COUNTS - 200);
    index_at(0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
    expect_count(3900);
}

TEST(test_an_index_is_missed_one_count_after_two_turns_and_anew_after_two_more)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        encoder_start(&encoder);
        (void)move(0);
        for (int32_t k = 0; k < 3; k++) {
            turn_without_index(side * 2 * COUNTS);
            TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, encoder.trouble);
            (void)move(side);
            TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_INDEX, encoder.trouble);
        }
    }
}

TEST(test_the_counts_from_the_last_index_have_the_sign_of_the_shafts_way)
{
    learn_index();
    (void)move(100);
    TEST_ASSERT_EQUAL_INT32(100, encoder.since);
    (void)move(-300);
    TEST_ASSERT_EQUAL_INT32(-200, encoder.since);
}

/* It says nothing of where the index is: a way counts as a turn at most. */
TEST(test_a_leap_of_three_turns_is_named_but_misses_no_index)
{
    cfg.counts = 64;
    cfg.scale_q32 = 0x4000000U;
    for (int32_t side = -1; side <= 1; side += 2) {
        encoder_start(&encoder);
        (void)move(0);
        (void)move(side * 3 * 64);
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_COUNTS, encoder.trouble);
    }
}

/* speed: in 1/16 counts a tick. strange: after one tick with that way. */
static void expect_strange(int32_t speed, int32_t way, uint8_t strange)
{
    encoder_start(&encoder);
    (void)move(0);
    encoder.speed = speed;
    (void)move(way);
    TEST_ASSERT_EQUAL_UINT8(strange, encoder.strange);
}

/* 2 counts and 4000/4096 of a count: in 1/16 of it 32 + 15. */
TEST(test_a_slow_shaft_may_change_its_speed_by_two_counts_and_a_4096th_of_a_turn_a_tick)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        expect_strange(side, side * 3, 0U);
        expect_strange(0, side * 3, 1U);
    }
}

TEST(test_a_fast_shaft_may_change_its_speed_by_half)
{
    for (int32_t side = -1; side <= 1; side += 2) {
        expect_strange(side * 100 * 16, side * 50, 0U);
        expect_strange(side * 100 * 16, side * 49, 1U);
        expect_strange(side * 100 * 16, side * 150, 0U);
        expect_strange(side * 100 * 16, side * 151, 1U);
    }
}

TEST(test_the_mean_speed_takes_a_sixteenth_of_each_ticks_way)
{
    (void)move(0);
    (void)move(100);
    TEST_ASSERT_EQUAL_INT32(100, encoder.speed); /* 100·16 / 16 */
    (void)move(-100);
    TEST_ASSERT_EQUAL_INT32(-7, encoder.speed); /* 100 − 1700/16, rounded down */
}

TEST(test_half_the_range_of_the_counter_a_tick_is_a_speed_like_any_other)
{
    const int32_t half = 0x8000;

    cfg.has_index = 0U;
    for (uint32_t reversed = 0U; reversed <= 1U; reversed++) {
        cfg.reversed = reversed;
        encoder_start(&encoder);
        (void)move(0);
        encoder.speed = ((reversed != 0U) ? half : -half) * 16;
        (void)move(-half);
        TEST_ASSERT_EQUAL_INT32(((reversed != 0U) ? half : -half) * 16, encoder.speed);
        TEST_ASSERT_TRUE(encoder.known);
    }
}

TEST(test_after_a_loss_the_counter_is_that_of_a_shaft_at_rest_with_four_ticks_again)
{
    (void)move(0);
    encoder.speed = 8 * 16;
    for (int32_t k = 0; k < 4; k++) {
        TEST_ASSERT_TRUE(encoder.known);
        (void)move(0);
    }
    TEST_ASSERT_FALSE(encoder.known);
    TEST_ASSERT_EQUAL_INT32(0, encoder.speed);
    for (int32_t k = 0; k < 3; k++) {
        (void)move(8);
        TEST_ASSERT_TRUE(encoder.known);
    }
    (void)move(8);
    TEST_ASSERT_FALSE(encoder.known);
}
