/* SPDX-License-Identifier: MIT */
#include "fault_log.h"
#include "testing.h"

#include <string.h>

static fault_log_t log_;

void setUp(void)
{
    fault_log_init(&log_);
    fault_log_power_up(&log_);
}

static void add(uint32_t number)
{
    const fault_t fault = {
        .id = FAULT_OVERVOLTAGE, .value = (int32_t)number, .limit = -1, .tick = number};

    fault_log_fault(&log_, &fault);
}

TEST(test_an_entry_says_what_when_and_how_much)
{
    const fault_t fault = {.id = FAULT_STALL, .value = -5, .limit = 1000, .tick = 77U};

    log_.seconds = 12345U;
    fault_log_fault(&log_, &fault);
    TEST_ASSERT_EQUAL_HEX32(0x00010000U | FAULT_STALL, fault_log_entry(&log_, 0U)->what);
    TEST_ASSERT_EQUAL_UINT32(12345U, fault_log_entry(&log_, 0U)->seconds);
    TEST_ASSERT_EQUAL_UINT32((uint32_t)-5, fault_log_entry(&log_, 0U)->value);
    TEST_ASSERT_EQUAL_UINT32(1000U, fault_log_entry(&log_, 0U)->limit);
}

TEST(test_a_reset_is_an_entry)
{
    const hal_reset_t reset = {.reason = HAL_RESET_WATCHDOG, .exception = 3U};

    fault_log_reset(&log_, reset);
    TEST_ASSERT_EQUAL_HEX32(0x00010300U | FAULT_LOG_RESET | HAL_RESET_WATCHDOG,
                            fault_log_entry(&log_, 0U)->what);
}

TEST(test_it_has_the_last_32_entries_and_counts_all)
{
    for (uint32_t k = 0U; k < 100U; k++) {
        TEST_ASSERT_EQUAL_UINT32((k < FAULT_LOG_ENTRIES) ? k : FAULT_LOG_ENTRIES,
                                 fault_log_size(&log_));
        add(k);
        TEST_ASSERT_EQUAL_UINT32(k + 1U, log_.count);
        for (uint32_t age = 0U; age < fault_log_size(&log_); age++) {
            TEST_ASSERT_EQUAL_UINT32(k - age, fault_log_entry(&log_, age)->value);
        }
        TEST_ASSERT_TRUE(fault_log_is_whole(&log_));
    }
}

TEST(test_each_bit_that_flips_is_seen)
{
    uint8_t *const bytes = (uint8_t *)&log_;

    add(1U);
    for (uint32_t at = 0U; at < sizeof log_; at++) {
        for (uint32_t bit = 0U; bit < 8U; bit++) {
            bytes[at] ^= (uint8_t)(1U << bit);
            TEST_ASSERT_FALSE(fault_log_is_whole(&log_));
            bytes[at] ^= (uint8_t)(1U << bit);
        }
    }
    TEST_ASSERT_TRUE(fault_log_is_whole(&log_));
}

TEST(test_a_power_up_begins_its_time_and_keeps_the_entries)
{
    add(4U);
    log_.seconds = 9U;
    log_.saves = 3U;
    log_.saved = 2U;
    fault_log_power_up(&log_);
    TEST_ASSERT_TRUE(fault_log_is_whole(&log_));
    TEST_ASSERT_EQUAL_UINT32(2U, log_.power_up);
    TEST_ASSERT_EQUAL_UINT32(0U, log_.seconds);
    TEST_ASSERT_EQUAL_UINT32(0U, log_.saves);
    TEST_ASSERT_EQUAL_UINT32(0U, log_.saved);
    TEST_ASSERT_EQUAL_UINT32(4U, fault_log_entry(&log_, 0U)->value);
}

TEST(test_its_words_are_all_of_it)
{
    fault_log_t copy;

    add(5U);
    (void)memset(&copy, 0xA5, sizeof copy);
    for (uint32_t at = 0U; at < FAULT_LOG_WORDS; at++) {
        fault_log_set_word(&copy, at, fault_log_word(&log_, at));
    }
    TEST_ASSERT_EQUAL_MEMORY(&log_, &copy, sizeof copy);
}

static void assert_told(const char *words, hal_reset_t reset)
{
    text_t text = {0};

    fault_log_tell_reset(&text, reset);
    text.characters[text.length] = '\0';
    TEST_ASSERT_EQUAL_STRING(words, text.characters);
}

TEST(test_the_reasons_of_a_reset_have_names)
{
    static const char *const names[HAL_RESETS] = {"unknown",  "supply",   "pin",
                                                  "software", "watchdog", "of another kind"};

    for (uint32_t k = 0U; k <= HAL_RESETS; k++) {
        assert_told(names[(k < HAL_RESETS) ? k : 0U],
                    (hal_reset_t){.reason = (hal_reset_reason_t)k});
    }
}

TEST(test_an_exception_that_stopped_the_run_is_told_with_its_number)
{
    assert_told("watchdog after exception 3",
                (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 3U});
    assert_told("pin after exception 255",
                (hal_reset_t){.reason = HAL_RESET_PIN, .exception = 255U});
}
