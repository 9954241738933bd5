/* SPDX-License-Identifier: MIT */
/* Texts of the faults: complete, on one line, and safe for any number. */
#include "fault_text.h"
#include "testing.h"

#include <string.h>

#define ADVICE_MAX (120U) /* characters: a line of a terminal beside its indent */

TEST(test_every_fault_has_a_name_of_its_own)
{
    for (int32_t id = 0; id < (int32_t)FAULT_COUNT; id++) {
        const char *const name = fault_text((fault_id_t)id)->name;

        TEST_ASSERT_NOT_NULL(name);
        TEST_ASSERT_EQUAL_size_t(strlen(name), strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ_"));
        for (int32_t other = 0; other < id; other++) {
            TEST_ASSERT_TRUE(strcmp(name, fault_text((fault_id_t)other)->name) != 0);
        }
    }
}

static void assert_one_line(const char *advice)
{
    TEST_ASSERT_NOT_NULL(advice);
    TEST_ASSERT_NOT_NULL_MESSAGE(strchr(advice, ';'), advice);
    TEST_ASSERT_NOT_NULL_MESSAGE(strchr(advice, ':'), advice);
    TEST_ASSERT_TRUE_MESSAGE(strlen(advice) <= ADVICE_MAX, advice);
    for (const char *c = advice; *c != '\0'; c++) {
        TEST_ASSERT_TRUE_MESSAGE((*c >= ' ') && (*c <= '~'), advice);
    }
}

TEST(test_every_fault_has_one_line_of_cause_and_next_check_whatever_is_known)
{
    for (int32_t id = 1; id < (int32_t)FAULT_COUNT; id++) {
        assert_one_line(fault_advice((fault_id_t)id, 0U));
        for (uint32_t sign = 0U; sign < (uint32_t)FAULT_SIGNS; sign++) {
            assert_one_line(fault_advice((fault_id_t)id, (uint32_t)1U << sign));
        }
    }
}

TEST(test_a_sign_changes_the_advice_of_its_faults_only)
{
    const uint32_t turn = (uint32_t)1U << (uint32_t)FAULT_SIGN_SHAFT;

    TEST_ASSERT_NOT_NULL(strstr(fault_advice(FAULT_OSCILLATION, 0U), "notch_hz"));
    TEST_ASSERT_NOT_NULL(strstr(fault_advice(FAULT_OSCILLATION, turn), "pulsates"));
    TEST_ASSERT_EQUAL_PTR(fault_advice(FAULT_STALL, 0U), fault_advice(FAULT_STALL, turn));
}

TEST(test_a_derated_torque_goes_before_what_a_swing_looks_like)
{
    const uint32_t both =
        ((uint32_t)1U << (uint32_t)FAULT_SIGN_SHAFT) | (1UL << (uint32_t)FAULT_SIGN_DERATED_BUS);

    TEST_ASSERT_NOT_NULL(strstr(fault_advice(FAULT_OSCILLATION, both), "low bus"));
}

TEST(test_a_number_that_is_no_fault_has_the_text_of_none)
{
    TEST_ASSERT_EQUAL_PTR(fault_text(FAULT_NONE), fault_text(FAULT_COUNT));
    TEST_ASSERT_EQUAL_PTR(fault_text(FAULT_NONE), fault_text((fault_id_t)200));
    TEST_ASSERT_EQUAL_STRING("no fault", fault_advice(FAULT_NONE, UINT32_MAX));
    TEST_ASSERT_EQUAL_STRING("no fault", fault_advice((fault_id_t)200, UINT32_MAX));
}

TEST(test_numbers_of_recorded_faults_do_not_move)
{
    static const char *const names[] = {"NONE",        "BREAK",        "OVERCURRENT",
                                        "OVERVOLTAGE", "UNDERVOLTAGE", "CURRENT_OFFSET"};

    for (int32_t id = 0; id < 6; id++) {
        TEST_ASSERT_EQUAL_STRING(names[id], fault_text((fault_id_t)id)->name);
    }
}
