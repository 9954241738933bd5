/* SPDX-License-Identifier: MIT */
/* When an input is there, when it is lost and why, and which of its readings counts. */
#include "input_signal.h"
#include "testing.h"

#include <string.h>

#define TIMEOUT (100U)

static input_signal_t signal;

void setUp(void)
{
    input_signal_init(&signal, 0U);
}

static void good(uint32_t count, uint32_t tick)
{
    for (uint32_t k = 0U; k < count; k++) {
        input_signal_good(&signal, 500U, tick);
    }
}

TEST(test_a_signal_is_there_after_eight_good_readings_in_a_row)
{
    good(7U, 1U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SILENT, signal.lost);
    input_signal_bad(&signal, INPUT_LOST_SHAPE, INPUT_SIGNAL_ANY);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SHAPE, signal.lost);
    good(7U, 1U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SHAPE, signal.lost);
    good(1U, 1U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
}

TEST(test_a_present_signal_bears_bad_readings_until_its_time_runs_out)
{
    good(8U, 10U);
    for (uint32_t k = 0U; k < 300U; k++) {
        input_signal_bad(&signal, INPUT_LOST_LOW, INPUT_SIGNAL_ANY);
    }
    input_signal_step(&signal, 10U + TIMEOUT, TIMEOUT);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
    input_signal_step(&signal, 11U + TIMEOUT, TIMEOUT);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_LOW, signal.lost);
}

TEST(test_what_was_wrong_before_a_good_reading_is_not_the_reason_of_a_silence)
{
    good(8U, 10U);
    input_signal_bad(&signal, INPUT_LOST_CHECKSUM, INPUT_SIGNAL_ANY);
    good(1U, 20U);
    input_signal_step(&signal, 21U + TIMEOUT, TIMEOUT);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SILENT, signal.lost);
}

TEST(test_bad_pulses_in_a_row_lose_a_signal_at_once)
{
    good(8U, 10U);
    for (uint32_t k = 0U; k < 7U; k++) {
        input_signal_bad(&signal, INPUT_LOST_CHECKSUM, INPUT_SIGNAL_BAD);
    }
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
    good(1U, 10U);
    for (uint32_t k = 0U; k < 8U; k++) {
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
        input_signal_bad(&signal, INPUT_LOST_CHECKSUM, INPUT_SIGNAL_BAD);
    }
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_CHECKSUM, signal.lost);
    good(7U, 10U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_CHECKSUM, signal.lost);
}

/* 2^32 ticks of a silent input must not look like a fresh one. */
TEST(test_a_silence_of_any_length_is_one)
{
    uint32_t tick = UINT32_MAX - 50U;

    good(8U, tick);
    for (uint32_t k = 0U; k < 70U; k++) {
        tick += 0x04000000U;
        input_signal_step(&signal, tick, TIMEOUT);
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SILENT, signal.lost);
    }
}

TEST(test_one_wrong_reading_of_three_has_no_effect)
{
    static const uint32_t wrong[] = {0U, 65535U};

    for (uint32_t k = 0U; k < 6U; k++) {
        good(3U, 1U);
        for (uint32_t at = 0U; at < 3U; at++) {
            input_signal_good(&signal, (at == (k / 2U)) ? wrong[k % 2U] : 500U, 1U);
            TEST_ASSERT_EQUAL_UINT32(500U, input_signal_value(&signal));
        }
    }
    input_signal_good(&signal, 600U, 1U);
    input_signal_good(&signal, 600U, 1U);
    TEST_ASSERT_EQUAL_UINT32(600U, input_signal_value(&signal));
}

TEST(test_noise_is_told_once)
{
    TEST_ASSERT_FALSE(input_signal_was_noisy(&signal));
    input_signal_bad(&signal, INPUT_LOST_SHAPE, INPUT_SIGNAL_ANY);
    good(8U, 1U);
    TEST_ASSERT_TRUE(input_signal_was_noisy(&signal));
    TEST_ASSERT_FALSE(input_signal_was_noisy(&signal));
}

TEST(test_each_reason_has_a_text_of_its_own)
{
    for (uint32_t a = 0U; a < (uint32_t)INPUT_LOSSES; a++) {
        for (uint32_t b = 0U; b < a; b++) {
            TEST_ASSERT_NOT_EQUAL(0, strcmp(input_signal_text(a), input_signal_text(b)));
        }
    }
    TEST_ASSERT_EQUAL_STRING("no signal", input_signal_text(255U));
}
