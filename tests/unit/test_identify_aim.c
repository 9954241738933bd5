/* SPDX-License-Identifier: MIT */
/* What an experiment asks for: its current, window and gains. */
#include "example_identify.h"
#include "testing.h"

void setUp(void)
{
    identify_example();
    start();
}

TEST(test_a_current_has_no_pulses)
{
    identify_aim_set(&identify, PROBE_PULSE_D, 1);
    identify_aim_set(&identify, PROBE_PULSE_Q, 2);
    identify_aim_current(&identify, 345);
    TEST_ASSERT_EQUAL_INT32(345, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_PULSE_D));
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_PULSE_Q));
}

TEST(test_a_window_has_a_name_a_time_to_settle_and_its_ticks)
{
    identify_aim_window(&identify, "still", 12, 34);
    TEST_ASSERT_EQUAL_STRING("still", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(12, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(34, identify.aim.ticks);
}

TEST(test_a_phase_begins_with_its_first_step_and_a_refusal_is_the_last_phase)
{
    identify.step = 7U;
    identify_aim_phase(&identify, IDENTIFY_SPIN);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
    identify.step = 7U;
    identify_aim_refusal(&identify, "no");
    assert_refused("no");
    TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
}

/*
 * L/8 a tick along the current as a mantissa and a shift; its integral 40 times slower, with 11
 * bits more.
 */
TEST(test_gains_follow_the_inductance_that_was_found)
{
    identify.rest.inductance_q16 = 1441;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((17 << 16) | 18444, word(PROBE_INTEGRAL_D));
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_Q));
    TEST_ASSERT_EQUAL_INT32((17 << 16) | 18444, word(PROBE_INTEGRAL_Q));
}

/* A sixteenth of K_p, and of K_i·T a 256th. */
TEST(test_soft_gains_leave_the_current_across_to_itself)
{
    identify.rest.inductance_q16 = 1441;
    identify_aim_gains(&identify, IDENTIFY_GAINS_SOFT);
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((17 << 16) | 18444, word(PROBE_INTEGRAL_D));
    TEST_ASSERT_EQUAL_INT32((27 << 16) | 23056, word(PROBE_GAIN_Q));
    TEST_ASSERT_EQUAL_INT32((25 << 16) | 18444, word(PROBE_INTEGRAL_Q));
}

/* Four times K_i·T in both axes, and the same K_p. */
TEST(test_quick_gains_have_a_quicker_integral)
{
    identify.rest.inductance_q16 = 1441;
    identify_aim_gains(&identify, IDENTIFY_GAINS_QUICK);
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, word(PROBE_GAIN_Q));
    TEST_ASSERT_EQUAL_INT32((15 << 16) | 18444, word(PROBE_INTEGRAL_D));
    TEST_ASSERT_EQUAL_INT32((15 << 16) | 18444, word(PROBE_INTEGRAL_Q));
}

/* 2·65536/8 in Q16 is a gain of 1/4: 16384 of 2^16, and 32768 of 2^17 is one bit too many. */
TEST(test_a_mantissa_has_15_bits_and_a_shift_is_30_at_most)
{
    identify.rest.inductance_q16 = 2 * 65536;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((16 << 16) | 16384, word(PROBE_GAIN_D));
    identify.rest.inductance_q16 = 32767;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((19 << 16) | 32767, word(PROBE_GAIN_D));
    identify.rest.inductance_q16 = 1;
    identify_aim_gains(&identify, IDENTIFY_GAINS_SOFT);
    TEST_ASSERT_EQUAL_INT32((30 << 16) | (8192 / 4), word(PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((30 << 16) | (8192 / 4 / 16), word(PROBE_GAIN_Q));
}

/* The largest L: K_i needs more halvings than a word has. */
TEST(test_a_gain_beyond_its_word_is_the_largest_that_it_has)
{
    identify.rest.inductance_q16 = INT32_MAX;
    identify_aim_gains(&identify, IDENTIFY_GAINS_FIRM);
    TEST_ASSERT_EQUAL_INT32((3 << 16) | 32767, word(PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((1 << 16) | 32767, word(PROBE_INTEGRAL_D));
}
