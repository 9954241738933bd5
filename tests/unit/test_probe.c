/* SPDX-License-Identifier: MIT */
/*
 * The probe: its words and their limits, the sums of a window, pulses, and how the vector turns.
 * All words are exact.
 */
#include "probe.h"
#include "seeded.h"
#include "testing.h"

#include <stdlib.h>
#include <string.h>

#define SPEED_MAX (536870912) /* 2^29, an eighth of a turn a tick */
#define DELAY (2U)            /* ticks from a demand to the end of the period in which it acts */
#define NUMBER (1L << PROBE_WINDOW_BITS)
#define SUM_MAX (0x7FFE0000)
#define SAMPLES (64)
#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static probe_t probe;
static probe_sample_t sample;

static const dq_t AHEAD = {-3000, 4000}; /* of an EMF: a lag of -19660 */
static const dq_t BEHIND = {3000, 4000};

void setUp(void)
{
    memset(&probe, 0xA5, sizeof probe);
    memset(&sample, 0, sizeof sample);
    probe_reset(&probe);
}

static void set(probe_word_t word, int32_t value)
{
    probe_set(&probe, (uint32_t)word, value);
}

static void note(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        probe_note(&probe, &sample);
    }
}

static void assert_dq(dq_t expected, dq_t value)
{
    TEST_ASSERT_EQUAL_INT32(expected.d, value.d);
    TEST_ASSERT_EQUAL_INT32(expected.q, value.q);
}

/* ---- words ---- */

TEST(test_a_reset_leaves_no_current_no_window_and_the_smallest_divisors)
{
    probe_t expected;

    memset(&expected, 0, sizeof expected);
    expected.emf_full = 1;
    expected.pulse_ticks = 1;
    expected.loop.pi_d.kp_shift = 1U;
    expected.loop.pi_d.ki_shift = 1U;
    expected.loop.pi_q.kp_shift = 1U;
    expected.loop.pi_q.ki_shift = 1U;
    TEST_ASSERT_EQUAL_MEMORY(&expected, &probe, sizeof probe);
    TEST_ASSERT_TRUE(probe_is_done(&probe, 0));
}

/* Sets a word: `field` becomes what is expected, and nothing else changes. */
static void check_word(probe_word_t word, int32_t *field, int32_t value, int32_t expected)
{
    static probe_t before;

    set(word, value);
    TEST_ASSERT_EQUAL_INT32(expected, *field);
    before = probe;
    *field = -1;
    set(word, value);
    TEST_ASSERT_EQUAL_MEMORY(&before, &probe, sizeof probe);
}

TEST(test_each_word_is_stored_and_limited_to_its_range)
{
    static const struct {
        probe_word_t word;
        int32_t *field;
        int32_t lowest;
        int32_t highest;
    } words[] = {
        {PROBE_CURRENT, &probe.current, 0, 16383},
        {PROBE_RATE, &probe.rate, 0, SPEED_MAX},
        {PROBE_RESISTANCE, &probe.loop.resistance_q13, 0, 32767},
        {PROBE_LOSS, &probe.loss, 0, 32767},
        {PROBE_EMF, &probe.emf_full, 1, 32767},
        {PROBE_DAMPING, &probe.damping, 0, SPEED_MAX},
        {PROBE_TRACKING, &probe.tracking, 0, SPEED_MAX},
        {PROBE_PULSE_D, &probe.pulse.d, 0, 32767},
        {PROBE_PULSE_Q, &probe.pulse.q, 0, 32767},
        {PROBE_PULSE_TICKS, &probe.pulse_ticks, 1, 64},
        {PROBE_RAMP, &probe.ramp, 0, SPEED_MAX},
        {PROBE_SPEED, &probe.speed, -SPEED_MAX, SPEED_MAX},
    };

    for (uint32_t k = 0U; k < COUNT(words); k++) {
        const int32_t lowest = words[k].lowest;
        const int32_t highest = words[k].highest;

        check_word(words[k].word, words[k].field, lowest, lowest);
        check_word(words[k].word, words[k].field, highest, highest);
        check_word(words[k].word, words[k].field, lowest + 1, lowest + 1);
        check_word(words[k].word, words[k].field, highest - 1, highest - 1);
        check_word(words[k].word, words[k].field, lowest - 1, lowest);
        check_word(words[k].word, words[k].field, highest + 1, highest);
        check_word(words[k].word, words[k].field, INT32_MIN, lowest);
        check_word(words[k].word, words[k].field, INT32_MAX, highest);
    }
}

TEST(test_the_reactance_is_that_of_both_axes)
{
    static const int32_t values[][2] = {{0, 0},  {1, 1},         {32767, 32767},    {32768, 32767},
                                        {-1, 0}, {INT32_MIN, 0}, {INT32_MAX, 32767}};

    for (uint32_t k = 0U; k < COUNT(values); k++) {
        set(PROBE_REACTANCE, values[k][0]);
        TEST_ASSERT_EQUAL_INT32(values[k][1], probe.loop.reactance_d_q13);
        TEST_ASSERT_EQUAL_INT32(values[k][1], probe.loop.reactance_q_q13);
    }
}

TEST(test_any_word_is_an_angle)
{
    static const int32_t words[] = {0, 1, -1, INT32_MAX, INT32_MIN};
    static const angle_t angles[] = {0U, 1U, 0xFFFFFFFFU, 0x7FFFFFFFU, 0x80000000U};

    for (uint32_t k = 0U; k < COUNT(words); k++) {
        set(PROBE_ANGLE, words[k]);
        TEST_ASSERT_EQUAL_UINT32(angles[k], probe.angle);
    }
}

/* Mantissa and shift of each of the four gains: the others stay. */
static void check_gain(int32_t word, int32_t mantissa, uint32_t shift)
{
    static const probe_word_t words[] = {PROBE_GAIN_D, PROBE_GAIN_Q, PROBE_INTEGRAL_D,
                                         PROBE_INTEGRAL_Q};
    int32_t *const mantissas[] = {&probe.loop.pi_d.kp, &probe.loop.pi_q.kp, &probe.loop.pi_d.ki,
                                  &probe.loop.pi_q.ki};
    uint32_t *const shifts[] = {&probe.loop.pi_d.kp_shift, &probe.loop.pi_q.kp_shift,
                                &probe.loop.pi_d.ki_shift, &probe.loop.pi_q.ki_shift};

    for (uint32_t k = 0U; k < COUNT(words); k++) {
        probe_t expected;

        setUp();
        expected = probe;
        set(words[k], word);
        TEST_ASSERT_EQUAL_INT32(mantissa, *mantissas[k]);
        TEST_ASSERT_EQUAL_UINT32(shift, *shifts[k]);
        *mantissas[k] = 0;
        *shifts[k] = 1U;
        TEST_ASSERT_EQUAL_MEMORY(&expected, &probe, sizeof probe);
    }
}

TEST(test_a_gain_is_a_mantissa_of_15_bits_and_a_shift_of_1_to_30)
{
    check_gain((5 << 16) | 1234, 1234, 5U);
    check_gain((1 << 16) | 32767, 32767, 1U);
    check_gain((2 << 16) | 0x8001, 1, 2U); /* bit 15 is none */
    check_gain((30 << 16) | 16384, 16384, 30U);
    check_gain((31 << 16) | 1, 1, 30U);
    check_gain(INT32_MAX, 32767, 30U);
    check_gain(77, 77, 1U);
    check_gain(INT32_MIN | 3, 3, 1U);
}

TEST(test_what_is_no_word_changes_nothing)
{
    static const uint32_t others[] = {0U, 1U, 15U, (uint32_t)PROBE_WORDS, 255U, 0xFFFFFFFFU};
    const probe_t before = probe;

    for (uint32_t k = 0U; k < COUNT(others); k++) {
        probe_set(&probe, others[k], 12345);
        TEST_ASSERT_EQUAL_MEMORY(&before, &probe, sizeof probe);
    }
}

/* ---- a window ---- */

static void check_window(int32_t word, int32_t ticks)
{
    setUp();
    sample.bus = 4;
    set(PROBE_WINDOW, word);
    TEST_ASSERT_FALSE(probe_is_done(&probe, word));
    note((uint32_t)ticks + DELAY - 1U);
    TEST_ASSERT_FALSE(probe_is_done(&probe, word));
    note(1U);
    TEST_ASSERT_TRUE(probe_is_done(&probe, word));
    TEST_ASSERT_FALSE(probe_is_done(&probe, word + NUMBER));
    TEST_ASSERT_EQUAL_INT32(ticks, probe.sums.bus);
    note(10U);
    TEST_ASSERT_EQUAL_INT32(ticks, probe.sums.bus);
}

TEST(test_a_window_has_its_ticks_of_samples_and_closes_two_ticks_behind_them)
{
    check_window(1, 1);
    check_window(2, 2);
    check_window(3, 3);
    check_window(50, 50);
    check_window(131071, 131071);
}

TEST(test_the_ticks_of_a_window_end_at_1_and_131071_whatever_its_number)
{
    check_window(NUMBER, 1);
    check_window(NUMBER + 7, 7);
    check_window(INT32_MIN + 8, 8);
    check_window(INT32_MIN, 1);
    check_window(NUMBER + 131072, 131071);
    check_window(0xFFFFF, 131071);
    check_window(-1, 131071);
}

TEST(test_a_window_opens_once_for_its_word_and_begins_at_zero)
{
    probe_sums_t first;

    sample = (probe_sample_t){.voltage = {5, 6}, .current = {7, -8}, .bus = 9};
    set(PROBE_WINDOW, NUMBER + 4);
    note(3U);
    set(PROBE_WINDOW, NUMBER + 4); /* while it is open */
    note(3U);
    TEST_ASSERT_TRUE(probe_is_done(&probe, NUMBER + 4));
    first = probe.sums;
    TEST_ASSERT_EQUAL_INT32(20, first.voltage.d);
    set(PROBE_WINDOW, NUMBER + 4); /* once it is closed */
    note(6U);
    TEST_ASSERT_EQUAL_MEMORY(&first, &probe.sums, sizeof first);
    set(PROBE_WINDOW, (2 * NUMBER) + 4);
    TEST_ASSERT_FALSE(probe_is_done(&probe, (2 * NUMBER) + 4));
    sample = (probe_sample_t){.voltage = {1, 0}, .current = {7, 0}};
    note(6U);
    TEST_ASSERT_EQUAL_INT32(4, probe.sums.voltage.d);
    TEST_ASSERT_EQUAL_INT32(0, probe.sums.voltage.q);
    TEST_ASSERT_EQUAL_INT32(28, probe.sums.current.d);
    TEST_ASSERT_EQUAL_INT32(0, probe.sums.bus);
    TEST_ASSERT_EQUAL_INT32(0, probe.sums.across);
}

TEST(test_voltage_current_and_a_quarter_of_the_bus_are_summed_up)
{
    static const int32_t bus[] = {32767, 4, 3};

    set(PROBE_WINDOW, 3);
    for (int32_t k = 0; k < 3; k++) {
        sample.voltage = (dq_t){100 * (k + 1), -10 * (k + 1)};
        sample.current = (dq_t){-1000 * (k + 1), 7 * (k + 1)};
        sample.bus = bus[k];
        note(1U);
    }
    note(DELAY);
    assert_dq((dq_t){600, -60}, probe.sums.voltage);
    assert_dq((dq_t){-6000, 42}, probe.sums.current);
    TEST_ASSERT_EQUAL_INT32(8191 + 1 + 0, probe.sums.bus);
}

/* The first change is that from the sample before the window. */
TEST(test_noise_is_the_size_of_each_change_from_sample_to_sample)
{
    static const int32_t a[] = {10, 13, 8, 8, 1000};
    static const int32_t b[] = {-5, -5, 5, 4, -1000};

    sample.phase_a = a[0];
    sample.phase_b = b[0];
    note(1U);
    set(PROBE_WINDOW, 3);
    for (uint32_t k = 1U; k < 5U; k++) {
        sample.phase_a = a[k];
        sample.phase_b = b[k];
        note(1U);
    }
    note(1U);
    TEST_ASSERT_EQUAL_INT32(3 + 5 + 0, probe.sums.noise_a);
    TEST_ASSERT_EQUAL_INT32(0 + 10 + 1, probe.sums.noise_b);
}

TEST(test_the_largest_current_across_counts_whatever_its_sign)
{
    static const int32_t across[] = {3, -70, 69, 1000, 1000};

    set(PROBE_WINDOW, 3);
    for (uint32_t k = 0U; k < 5U; k++) {
        sample.current.q = across[k];
        note(1U);
    }
    TEST_ASSERT_EQUAL_INT32(70, probe.sums.across);
}

/* From the first sample to that behind the last: as long as its ticks. */
TEST(test_the_turn_of_the_vector_wraps)
{
    static const int32_t turns[] = {INT32_MAX - 10, INT32_MAX - 5, INT32_MAX, INT32_MIN + 4,
                                    INT32_MIN + 9};

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        setUp();
        set(PROBE_WINDOW, 3);
        for (uint32_t k = 0U; k < 5U; k++) {
            sample.turns_q16 = (sign > 0) ? turns[k] : turns[4U - k];
            note(1U);
        }
        TEST_ASSERT_EQUAL_INT32(sign * 15, probe.sums.turn_q16);
        sample.turns_q16 = 77;
        note(3U);
        TEST_ASSERT_EQUAL_INT32(sign * 15, probe.sums.turn_q16);
    }
}

/* ---- torque ---- */

static int32_t torque(dq_t emf, dq_t current, int32_t speed_q15)
{
    const int32_t number = (probe.window < NUMBER) ? NUMBER : 0;

    sample.emf = emf;
    sample.current = current;
    sample.speed_q15 = speed_q15;
    set(PROBE_WINDOW, number + 1);
    note(1U + DELAY);
    return probe.sums.torque;
}

/* Along and across, with either sign of power and speed. */
static void check_quotient(int32_t power, int32_t speed, int32_t expected)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const dq_t emf = {(sign * power) / 100, (sign * power) % 100};

        TEST_ASSERT_EQUAL_INT32(sign * expected, torque(emf, (dq_t){100, 1}, speed));
        TEST_ASSERT_EQUAL_INT32(-sign * expected,
                                torque((dq_t){emf.q, emf.d}, (dq_t){1, 100}, -speed));
    }
}

TEST(test_the_torque_is_the_power_of_the_emf_over_the_speed_to_the_nearest)
{
    check_quotient(2000000, 300, 6667);
    check_quotient(1999900, 300, 6666);
    check_quotient(3, 2, 2);
    check_quotient(1, 2, 1);
    check_quotient(1, 3, 0);
    check_quotient(5, 3, 2);
    check_quotient(4, 3, 1);
    check_quotient(7, 1, 7);
    check_quotient(0, 5, 0);
}

TEST(test_torque_saturates_as_emf_current_and_quotient_do)
{
    TEST_ASSERT_EQUAL_INT32(0, torque((dq_t){1000, 1000}, (dq_t){1000, 1000}, 0));
    TEST_ASSERT_EQUAL_INT32(32767, torque((dq_t){32767, 0}, (dq_t){16383, 0}, 1));
    TEST_ASSERT_EQUAL_INT32(-32768, torque((dq_t){32767, 0}, (dq_t){16383, 0}, -1));
    TEST_ASSERT_EQUAL_INT32(32766, torque((dq_t){2, 0}, (dq_t){34400, 0}, 1));
    TEST_ASSERT_EQUAL_INT32(16383, torque((dq_t){0, 1}, (dq_t){0, 34400}, 1));
    TEST_ASSERT_EQUAL_INT32(3277, torque((dq_t){0, 100000}, (dq_t){0, 1}, 10));
    TEST_ASSERT_EQUAL_INT32(-3277, torque((dq_t){-100000, 0}, (dq_t){1, 0}, 10));
    /* All at their ends: 32768·16384 twice over 32768. */
    TEST_ASSERT_EQUAL_INT32(32767, torque((dq_t){-100000, -100000}, (dq_t){-34400, -34400}, 32767));
    TEST_ASSERT_EQUAL_INT32(-32768,
                            torque((dq_t){-100000, -100000}, (dq_t){-34400, -34400}, -32768));
}

TEST(test_what_the_legs_lose_is_no_torque)
{
    set(PROBE_LOSS, 40);
    TEST_ASSERT_EQUAL_INT32(100 * 10, torque((dq_t){100, 0}, (dq_t){10, 0}, 1));
    set(PROBE_CURRENT, 1);
    TEST_ASSERT_EQUAL_INT32(60 * 10, torque((dq_t){100, 0}, (dq_t){10, 0}, 1));
    TEST_ASSERT_EQUAL_INT32(100 * 10, torque((dq_t){40, 100}, (dq_t){10, 10}, 1));
}

/* At a speed of 10 in either direction. */
static void check_torque(dq_t emf, dq_t current, int32_t expected)
{
    TEST_ASSERT_EQUAL_INT32(expected, torque(emf, current, 10));
    TEST_ASSERT_EQUAL_INT32(-expected, torque(emf, current, -10));
}

/*
 * The power of 500 along and of 100 across, whose EMF of the sample has the R of another current in
 * it: R is 1 at 8192.
 */
TEST(test_r_takes_its_part_of_the_torque_from_the_current_that_flows)
{
    set(PROBE_CURRENT, 100);
    set(PROBE_RESISTANCE, 8192);
    check_torque((dq_t){500 + 30, 0}, (dq_t){130, 0}, 6500);
    check_torque((dq_t){500 - 30, 0}, (dq_t){70, 0}, 3500);
    check_torque((dq_t){500, 0}, (dq_t){100, 0}, 5000);
    check_torque((dq_t){0, 100 + 20}, (dq_t){100, 20}, 200);
    check_torque((dq_t){0, 100 - 20}, (dq_t){100, -20}, -200);
    check_torque((dq_t){500 - 300, 0}, (dq_t){-200, 0}, -10000);
    check_torque((dq_t){500 + 30, 100 + 20}, (dq_t){130, 20}, 6700);
}

/* R·i is rounded down: ±0.9998 and ±1.0002 for a current of 2. */
TEST(test_the_resistance_of_a_torque_is_its_word_in_q13)
{
    set(PROBE_CURRENT, 100);
    set(PROBE_RESISTANCE, 4095);
    TEST_ASSERT_EQUAL_INT32(500 * 102, 2 * torque((dq_t){500, 0}, (dq_t){102, 0}, 2));
    TEST_ASSERT_EQUAL_INT32(501 * 98, 2 * torque((dq_t){500, 0}, (dq_t){98, 0}, 2));
    TEST_ASSERT_EQUAL_INT32(500 * 2, torque((dq_t){0, 500}, (dq_t){0, 2}, 1));
    TEST_ASSERT_EQUAL_INT32(501 * -2, torque((dq_t){0, 500}, (dq_t){0, -2}, 1));
    set(PROBE_RESISTANCE, 4097);
    TEST_ASSERT_EQUAL_INT32(499 * 102, 2 * torque((dq_t){500, 0}, (dq_t){102, 0}, 2));
    TEST_ASSERT_EQUAL_INT32(502 * 98, 2 * torque((dq_t){500, 0}, (dq_t){98, 0}, 2));
    TEST_ASSERT_EQUAL_INT32(499 * 2, torque((dq_t){0, 500}, (dq_t){0, 2}, 1));
    TEST_ASSERT_EQUAL_INT32(502 * -2, torque((dq_t){0, 500}, (dq_t){0, -2}, 1));
}

/* A current beyond 16 bits counts as its end, and so does an EMF less R·i. */
TEST(test_what_r_takes_from_a_torque_saturates)
{
    set(PROBE_RESISTANCE, 8192);
    TEST_ASSERT_EQUAL_INT32(2 * 16383, torque((dq_t){32767 + 2, 0}, (dq_t){34400, 0}, 1));
    TEST_ASSERT_EQUAL_INT32(-2 * 16384, torque((dq_t){2 - 32768, 0}, (dq_t){-34400, 0}, 1));
    TEST_ASSERT_EQUAL_INT32(16383, torque((dq_t){0, 32767 + 1}, (dq_t){0, 34400}, 1));
    TEST_ASSERT_EQUAL_INT32(-16384, torque((dq_t){0, 1 - 32768}, (dq_t){0, -34400}, 1));
    /* 32767·16384/20000 */
    TEST_ASSERT_EQUAL_INT32(-26843, torque((dq_t){30000, 0}, (dq_t){-20000, 0}, 20000));
    TEST_ASSERT_EQUAL_INT32(-26843, torque((dq_t){0, 30000}, (dq_t){0, -20000}, 20000));
}

/* ---- pulses ---- */

static int32_t sign_in(uint32_t tick, uint32_t quarter_ticks)
{
    static const int32_t signs[] = {1, -1, -1, 1};

    return signs[(tick / quarter_ticks) % 4U];
}

/* The windows of the pulses: ticks, ticks of a quarter. */
static const uint32_t WINDOWS[][2] = {{24U, 3U}, {10U, 2U}, {7U, 1U}, {5U, 8U}, {1U, 1U}};

/* As the drive does it: the word, the sample, the demand. */
TEST(test_pulses_are_one_quarter_up_two_down_one_up_again_and_again)
{
    for (uint32_t w = 0U; w < COUNT(WINDOWS); w++) {
        const uint32_t ticks = WINDOWS[w][0];

        setUp();
        set(PROBE_PULSE_D, 1000);
        set(PROBE_PULSE_Q, 30);
        set(PROBE_PULSE_TICKS, (int32_t)WINDOWS[w][1]);
        set(PROBE_WINDOW, (int32_t)ticks);
        for (uint32_t k = 0U; k < (ticks + DELAY - 1U); k++) {
            const int32_t sign = (k < ticks) ? sign_in(k, WINDOWS[w][1]) : 0;
            const dq_t steady = {500 + (int32_t)k, -200 - (int32_t)k};

            note(1U);
            TEST_ASSERT_TRUE(probe_pulses(&probe));
            assert_dq((dq_t){steady.d + (sign * 1000), steady.q + (sign * 30)},
                      probe_voltage(&probe, steady));
        }
        note(1U);
        TEST_ASSERT_FALSE(probe_pulses(&probe));
        TEST_ASSERT_TRUE(probe_is_done(&probe, (int32_t)ticks));
    }
}

TEST(test_pulses_are_added_in_a_window_with_a_pulse_voltage_only)
{
    set(PROBE_PULSE_D, 1);
    TEST_ASSERT_FALSE(probe_pulses(&probe));
    set(PROBE_WINDOW, 5);
    TEST_ASSERT_TRUE(probe_pulses(&probe));
    set(PROBE_PULSE_D, 0);
    TEST_ASSERT_FALSE(probe_pulses(&probe));
    set(PROBE_PULSE_Q, 1);
    TEST_ASSERT_TRUE(probe_pulses(&probe));
    note(5U + DELAY);
    TEST_ASSERT_FALSE(probe_pulses(&probe));
}

TEST(test_the_control_sees_its_reference_along_the_pulses_and_the_current_across)
{
    const dq_t reference = {100, 7};
    const dq_t measured = {130, -20};

    set(PROBE_PULSE_D, 1);
    assert_dq((dq_t){100, -20}, probe_controlled(&probe, reference, measured));
    set(PROBE_PULSE_D, 0);
    set(PROBE_PULSE_Q, 1);
    assert_dq((dq_t){130, 7}, probe_controlled(&probe, reference, measured));
}

/* The steady voltage and a pulse of 10000 in the first two ticks of a window. */
static void check_voltage(int32_t steady, int32_t first, int32_t second)
{
    static const probe_word_t axes[] = {PROBE_PULSE_D, PROBE_PULSE_Q};
    const int32_t expected[] = {first, second};

    for (uint32_t k = 0U; k < 4U; k++) {
        const bool along = k < 2U;
        const dq_t v = along ? (dq_t){steady, 5} : (dq_t){5, steady};
        const int32_t with = expected[k % 2U];

        setUp();
        set(axes[k / 2U], 10000);
        set(PROBE_WINDOW, 4);
        note((k % 2U) + 1U);
        assert_dq(along ? (dq_t){with, 5} : (dq_t){5, with}, probe_voltage(&probe, v));
    }
}

TEST(test_the_voltage_of_pulses_saturates)
{
    check_voltage(22767, 32767, 12767);
    check_voltage(22768, 32767, 12768);
    check_voltage(-22767, -12767, -32767);
    check_voltage(-22768, -12768, -32767);
    check_voltage(32767, 32767, 22767);
    check_voltage(-32768, -22768, -32767);
}

/*
 * Sample k of a window is the (k+1)th: what is demanded in tick k changes the current from sample
 * k+1 to k+2.
 */
static void check_changes(uint32_t ticks, uint32_t quarter, bool along)
{
    dq_t current[SAMPLES] = {{0, 0}};
    seeded_t seed = {0x9B0BEU};
    dq_t change = {0, 0};

    for (uint32_t k = 0U; k < (ticks + 6U); k++) {
        current[k] = (dq_t){seeded_in(&seed, -34400, 34400), seeded_in(&seed, -34400, 34400)};
    }
    for (uint32_t k = 0U; k < ticks; k++) {
        const dq_t from = current[k + 1U];
        const dq_t to = current[k + 2U];

        change.d += sign_in(k, quarter) * (to.d - from.d);
        change.q += sign_in(k, quarter) * (to.q - from.q);
    }
    setUp();
    sample.current = (dq_t){12345, -23456};
    note(1U);
    set(along ? PROBE_PULSE_D : PROBE_PULSE_Q, 1);
    set(PROBE_PULSE_TICKS, (int32_t)quarter);
    set(PROBE_WINDOW, (int32_t)ticks);
    for (uint32_t k = 0U; k < (ticks + 6U); k++) {
        sample.current = current[k];
        note(1U);
    }
    assert_dq(change, probe.sums.change);
}

TEST(test_changes_of_the_current_count_with_the_sign_of_the_pulse_two_ticks_before)
{
    for (uint32_t w = 0U; w < COUNT(WINDOWS); w++) {
        check_changes(WINDOWS[w][0], WINDOWS[w][1], true);
        check_changes(WINDOWS[w][0], WINDOWS[w][1], false);
    }
}

/* ---- sums at their ends ---- */

TEST(test_a_sum_that_was_beyond_its_end_counts_from_there)
{
    int32_t *const sums[] = {&probe.sums.voltage.d, &probe.sums.voltage.q, &probe.sums.current.d,
                             &probe.sums.current.q, &probe.sums.bus,       &probe.sums.noise_a,
                             &probe.sums.noise_b,   &probe.sums.torque};
    static const int32_t beyond[][2] = {{INT32_MAX, SUM_MAX},  {SUM_MAX + 1, SUM_MAX},
                                        {SUM_MAX, SUM_MAX},    {SUM_MAX - 1, SUM_MAX - 1},
                                        {INT32_MIN, -SUM_MAX}, {-SUM_MAX - 1, -SUM_MAX},
                                        {-SUM_MAX, -SUM_MAX},  {1 - SUM_MAX, 1 - SUM_MAX}};

    for (uint32_t s = 0U; s < COUNT(sums); s++) {
        for (uint32_t k = 0U; k < COUNT(beyond); k++) {
            setUp();
            set(PROBE_WINDOW, 5);
            sample = (probe_sample_t){.phase_a = 1,
                                      .phase_b = 1,
                                      .current = {1, 1},
                                      .voltage = {1, 1},
                                      .bus = 4,
                                      .emf = {1, 0},
                                      .speed_q15 = 1};
            *sums[s] = beyond[k][0];
            note(1U);
            TEST_ASSERT_EQUAL_INT32(beyond[k][1] + 1, *sums[s]);
        }
    }
}

TEST(test_sums_of_the_pulses_end_likewise)
{
    set(PROBE_WINDOW, 5);
    note(2U);
    probe.sums.change = (dq_t){INT32_MAX, INT32_MIN};
    set(PROBE_PULSE_D, 1);
    sample.current = (dq_t){3, 4};
    note(1U);
    assert_dq((dq_t){SUM_MAX + 3, -SUM_MAX + 4}, probe.sums.change);
}

/* ---- a vector at rest ---- */

static void check_way(angle_t to, angle_t from, int32_t rate, step_t expected)
{
    set(PROBE_ANGLE, (int32_t)to);
    set(PROBE_RATE, rate);
    TEST_ASSERT_EQUAL_INT32(expected, probe_turn(&probe, from, BEHIND, true));
    TEST_ASSERT_EQUAL_INT32(0, probe.lag_q15);
    TEST_ASSERT_EQUAL_INT32(0, probe.own_speed);
}

TEST(test_a_vector_at_rest_goes_the_short_way_to_its_angle_at_its_rate)
{
    check_way(0x10U, 0xFFFFFFF0U, 100, 0x20);
    check_way(0xFFFFFFF0U, 0x10U, 100, -0x20);
    check_way(1000U, 0U, 999, 999);
    check_way(1000U, 0U, 1000, 1000);
    check_way(1000U, 0U, 1001, 1000);
    check_way(0U, 1000U, 999, -999);
    check_way(0x7FFFFFFFU, 0U, SPEED_MAX, SPEED_MAX);
    check_way(0x80000000U, 0U, SPEED_MAX, -SPEED_MAX);
    check_way(0x80000001U, 0U, SPEED_MAX, -SPEED_MAX);
    check_way(5U, 5U, SPEED_MAX, 0);
    check_way(1000U, 0U, 0, 0);
}

/* ---- a vector that turns ---- */

static step_t turn(dq_t emf)
{
    return probe_turn(&probe, 0x12345678U, emf, true);
}

/* With no lag it turns with its own speed. */
TEST(test_the_speed_follows_its_word_along_a_ramp)
{
    static const step_t up[] = {30, 60, 90, 100, 100};
    static const step_t through[] = {70, 40, 10, -20, -50, -50};

    set(PROBE_RAMP, 30);
    set(PROBE_SPEED, 100);
    for (uint32_t k = 0U; k < COUNT(up); k++) {
        TEST_ASSERT_EQUAL_INT32(up[k], turn((dq_t){0, 4000}));
        TEST_ASSERT_EQUAL_INT32(up[k], probe.own_speed);
    }
    set(PROBE_SPEED, -50);
    for (uint32_t k = 0U; k < COUNT(through); k++) {
        TEST_ASSERT_EQUAL_INT32(through[k], turn((dq_t){0, -4000}));
    }
}

/* A vector that turns with `now`, asked for another speed: its speed a tick later. */
static step_t ramped(step_t now, step_t asked, int32_t lag, bool bus_bears)
{
    set(PROBE_RAMP, 100);
    set(PROBE_SPEED, asked);
    probe.own_speed = now;
    probe.lag_q15 = lag;
    (void)probe_turn(&probe, 0U, (dq_t){0, 4000}, bus_bears);
    return probe.own_speed;
}

/* sin 45°. The lag has the sign of the torque that the vector gives the rotor on its way. */
TEST(test_a_ramp_waits_for_a_rotor_that_it_strains)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const step_t now = sign * 500;

        TEST_ASSERT_EQUAL_INT32(sign * 600, ramped(now, sign * 1000, 23170, true));
        TEST_ASSERT_EQUAL_INT32(sign * 500, ramped(now, sign * 1000, 23171, true));
        TEST_ASSERT_EQUAL_INT32(sign * 600, ramped(now, sign * 1000, -23171, true));
        TEST_ASSERT_EQUAL_INT32(sign * 400, ramped(now, sign * 100, -23170, true));
        TEST_ASSERT_EQUAL_INT32(sign * 500, ramped(now, sign * 100, -23171, true));
        TEST_ASSERT_EQUAL_INT32(sign * 400, ramped(now, sign * 100, 23171, true));
        TEST_ASSERT_EQUAL_INT32(sign * 400, ramped(now, -now, 23171, true));
        TEST_ASSERT_EQUAL_INT32(sign * 500, ramped(now, -now, -23171, true));
    }
}

TEST(test_a_ramp_down_waits_for_a_bus_that_bears_no_more_braking)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const step_t now = sign * 500;

        TEST_ASSERT_EQUAL_INT32(sign * 400, ramped(now, sign * 100, 0, true));
        TEST_ASSERT_EQUAL_INT32(sign * 500, ramped(now, sign * 100, 0, false));
        TEST_ASSERT_EQUAL_INT32(sign * 600, ramped(now, sign * 1000, 0, false));
        TEST_ASSERT_EQUAL_INT32(sign * 500, ramped(now, -now, 0, false));
    }
}

TEST(test_a_vector_that_is_stopped_ramps_down_and_then_goes_to_its_angle)
{
    set(PROBE_RATE, 7);
    set(PROBE_ANGLE, 0x12345678 + 1000);
    set(PROBE_RAMP, 100);
    set(PROBE_SPEED, 100);
    TEST_ASSERT_EQUAL_INT32(100, turn(BEHIND));
    set(PROBE_RAMP, 60);
    set(PROBE_SPEED, 0);
    TEST_ASSERT_EQUAL_INT32(40, turn(BEHIND));
    TEST_ASSERT_TRUE(probe.lag_q15 != 0);
    TEST_ASSERT_TRUE(probe.mean_lag_q29 != 0);
    TEST_ASSERT_EQUAL_INT32(7, turn(BEHIND));
    TEST_ASSERT_EQUAL_INT32(0, probe.lag_q15);
    TEST_ASSERT_EQUAL_INT32(0, probe.mean_lag_q29);
}

TEST(test_a_vector_that_is_to_turn_has_a_lag_before_it_does)
{
    set(PROBE_RATE, 7);
    set(PROBE_SPEED, -100);
    TEST_ASSERT_EQUAL_INT32(0, turn(BEHIND));
    TEST_ASSERT_EQUAL_INT32(19660, probe.lag_q15);
}

/* With its full speed in the first tick. */
static void begin_to_turn(step_t speed)
{
    setUp();
    set(PROBE_RAMP, SPEED_MAX);
    set(PROBE_SPEED, speed);
}

static int32_t lag(dq_t emf)
{
    (void)turn(emf);
    return probe.lag_q15;
}

static void check_lag(dq_t emf, int32_t expected)
{
    begin_to_turn(1000);
    TEST_ASSERT_EQUAL_INT32(expected, lag(emf));
    begin_to_turn(-1000);
    TEST_ASSERT_EQUAL_INT32(-expected, lag(emf));
    begin_to_turn(-1);
    TEST_ASSERT_EQUAL_INT32(-expected, lag(emf));
}

/* 32767·e_d/|e|, both rounded towards 0. */
TEST(test_the_lag_is_the_share_of_the_emf_along_the_vector_with_the_sign_of_the_speed)
{
    check_lag((dq_t){3000, 4000}, 19660);
    check_lag((dq_t){-3000, 4000}, -19660);
    check_lag((dq_t){3000, -4000}, 19660);
    check_lag((dq_t){4000, 3000}, 26213);
    check_lag((dq_t){2000, 4000}, 14654);
    check_lag((dq_t){0, 4000}, 0);
    check_lag((dq_t){0, 0}, 0);
    check_lag((dq_t){1, 0}, 32767);
    check_lag((dq_t){-1, 0}, -32767);
    check_lag((dq_t){100000, 0}, 32767);
    check_lag((dq_t){-100000, 0}, -32767);
    check_lag((dq_t){3000, 100000}, 2987);
    check_lag((dq_t){3000, -100000}, 2987);
}

TEST(test_what_the_legs_lose_is_no_lag_while_a_current_flows)
{
    begin_to_turn(1000);
    set(PROBE_LOSS, 1000);
    TEST_ASSERT_EQUAL_INT32(19660, lag(BEHIND));
    set(PROBE_CURRENT, 1);
    TEST_ASSERT_EQUAL_INT32(14654, lag(BEHIND));
    set(PROBE_LOSS, 32767);
    TEST_ASSERT_EQUAL_INT32(-32767, lag((dq_t){-32768, 0}));
}

TEST(test_an_emf_below_the_full_one_counts_less)
{
    begin_to_turn(1000);
    set(PROBE_EMF, 10000);
    TEST_ASSERT_EQUAL_INT32(9830, lag(BEHIND));
    set(PROBE_EMF, 5001);
    TEST_ASSERT_EQUAL_INT32(19656, lag(BEHIND));
    set(PROBE_EMF, 5000);
    TEST_ASSERT_EQUAL_INT32(19660, lag(BEHIND));
    set(PROBE_EMF, 4999);
    TEST_ASSERT_EQUAL_INT32(19660, lag(BEHIND));
}

#define K_1 (0x100000) /* 2^20: 16 steps for an LSB of the lag */
#define SPEED (1000000)

static step_t turn_for(uint32_t count, dq_t emf)
{
    step_t step = 0;

    for (uint32_t k = 0U; k < count; k++) {
        step = turn(emf);
    }
    return step;
}

static step_t first_step(step_t speed, int32_t damping, dq_t emf)
{
    begin_to_turn(speed);
    set(PROBE_DAMPING, damping);
    return turn(emf);
}

/*
 * floor(K·lag/2^16) of the lag less its mean, which the first tick finds at 0 and the second at
 * 19660/2^14, 1.2.
 */
TEST(test_the_vector_is_damped_by_what_the_lag_is_off_its_mean)
{
    TEST_ASSERT_EQUAL_INT32(-SPEED + (16 * 19660), first_step(-SPEED, K_1, BEHIND));
    TEST_ASSERT_EQUAL_INT32(SPEED - (16 * 19660), first_step(SPEED, K_1, BEHIND));
    TEST_ASSERT_EQUAL_INT32(19660, probe.mean_lag_q29);
    TEST_ASSERT_EQUAL_INT32(SPEED - (16 * (19660 - 1)), turn(BEHIND));
    TEST_ASSERT_EQUAL_INT32(19660 + 19660 - 2, probe.mean_lag_q29);
    TEST_ASSERT_EQUAL_INT32(SPEED, probe.own_speed);
}

/* Half of an LSB is one. */
TEST(test_the_mean_lag_counts_to_the_nearest)
{
    begin_to_turn(SPEED);
    set(PROBE_DAMPING, K_1);
    probe.mean_lag_q29 = 8191;
    TEST_ASSERT_EQUAL_INT32(SPEED, turn((dq_t){0, 4000}));
    probe.mean_lag_q29 = 8192;
    TEST_ASSERT_EQUAL_INT32(SPEED + 16, turn((dq_t){0, 4000}));
    probe.mean_lag_q29 = -8192;
    TEST_ASSERT_EQUAL_INT32(SPEED, turn((dq_t){0, 4000}));
    probe.mean_lag_q29 = -8193;
    TEST_ASSERT_EQUAL_INT32(SPEED - 16, turn((dq_t){0, 4000}));
}

/* To an LSB of the lag, 16 steps: below 2^14 of its own the mean no longer moves. */
TEST(test_a_constant_lag_does_not_slow_the_vector_down)
{
    begin_to_turn(SPEED);
    set(PROBE_DAMPING, K_1);
    TEST_ASSERT_INT32_WITHIN(16, SPEED, turn_for(200000U, BEHIND));
    TEST_ASSERT_INT32_WITHIN(16384, 16384 * 19660, probe.mean_lag_q29);
}

TEST(test_damping_takes_or_adds_half_of_the_speed_at_most)
{
    TEST_ASSERT_EQUAL_INT32(1000001 - 500000, first_step(1000001, SPEED_MAX, BEHIND));
    TEST_ASSERT_EQUAL_INT32(1000001 + 500000, first_step(1000001, SPEED_MAX, AHEAD));
    TEST_ASSERT_EQUAL_INT32(-1000001 + 500000, first_step(-1000001, SPEED_MAX, BEHIND));
    TEST_ASSERT_EQUAL_INT32(-1000001 - 500000, first_step(-1000001, SPEED_MAX, AHEAD));
}

/*
 * 3·2^14 ticks bring the mean to 0.95 of 32767. Against it the lag is −1.95, which counts as −1:
 * 2^16·(−1).
 */
TEST(test_a_lag_that_is_off_its_mean_by_more_than_one_counts_as_one)
{
    begin_to_turn(SPEED);
    set(PROBE_DAMPING, 0x10000);
    (void)turn_for(3U << 14U, (dq_t){4000, 0});
    TEST_ASSERT_EQUAL_INT32(SPEED + 32768, turn((dq_t){-4000, 0}));
}

/* ---- tracking ---- */

TEST(test_tracking_moves_the_own_speed_by_the_whole_lag)
{
    begin_to_turn(SPEED);
    TEST_ASSERT_EQUAL_INT32(SPEED, turn(BEHIND)); /* a mean that is not 0 */
    set(PROBE_RAMP, 0);
    set(PROBE_TRACKING, K_1);
    TEST_ASSERT_EQUAL_INT32(SPEED - (16 * 19660), turn(BEHIND));
    TEST_ASSERT_EQUAL_INT32(SPEED - (16 * 19660), probe.own_speed);
    TEST_ASSERT_EQUAL_INT32(SPEED - (32 * 19660), turn(BEHIND));
    TEST_ASSERT_EQUAL_INT32(19660 + 19658 + 19657, probe.mean_lag_q29);
}

/*
 * The first 2^15 ticks bring the mean to 0.86 of the lag: without tracking it would be taken off.
 */
TEST(test_tracking_damps_with_the_whole_lag)
{
    begin_to_turn(SPEED);
    (void)turn_for(1U << 15U, BEHIND);
    set(PROBE_DAMPING, K_1);
    set(PROBE_RAMP, 0);
    set(PROBE_TRACKING, 1);
    TEST_ASSERT_EQUAL_INT32(SPEED - (16 * 19660), turn(BEHIND));
}

/* Within 2^-15 of the whole lag, to which its steps no longer reach. */
TEST(test_the_mean_of_a_lag_that_stays_is_that_lag)
{
    begin_to_turn(SPEED);
    (void)turn_for(400000U, (dq_t){4000, 0});
    TEST_ASSERT_INT32_WITHIN(16384, 16384 * 32767, probe.mean_lag_q29);
    (void)turn_for(400000U, (dq_t){-4000, 0});
    TEST_ASSERT_INT32_WITHIN(16384, -16384 * 32767, probe.mean_lag_q29);
    probe.mean_lag_q29 = (-16384 * 32767) + 1;
    (void)turn((dq_t){-4000, 0});
    TEST_ASSERT_EQUAL_INT32(-16384 * 32767, probe.mean_lag_q29); /* rounded down */
}

/* 8/K = 2^bits: K = 0.03125 a tick for 2^8, which is a word of 2·0.03125·2^32/(2·pi). */
TEST(test_the_mean_is_the_longer_the_weaker_the_damping)
{
    static const struct {
        int32_t damping;
        uint32_t bits;
    } means[] = {
        {SPEED_MAX, 8U}, {42722830, 8U},  {42722829, 9U}, {21361415, 9U},
        {21361414, 10U}, {10680707, 10U}, {5340353, 11U}, {2670176, 12U},
        {1335088, 13U},  {1335087, 14U},  {0, 14U},
    };

    for (uint32_t k = 0U; k < COUNT(means); k++) {
        (void)first_step(SPEED, means[k].damping, BEHIND);
        TEST_ASSERT_EQUAL_INT32((19660 * 16384) >> means[k].bits, probe.mean_lag_q29);
    }
}

TEST(test_no_speed_is_beyond_an_eighth_of_a_turn_a_tick)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin_to_turn(sign * SPEED_MAX);
        set(PROBE_TRACKING, SPEED_MAX);
        TEST_ASSERT_EQUAL_INT32(sign * SPEED_MAX, turn((dq_t){-4000, 0}));
        TEST_ASSERT_EQUAL_INT32(sign * SPEED_MAX, probe.own_speed);
        set(PROBE_TRACKING, 0);
        set(PROBE_DAMPING, SPEED_MAX);
        TEST_ASSERT_EQUAL_INT32(sign * SPEED_MAX, turn((dq_t){-4000, 0}));
        TEST_ASSERT_EQUAL_INT32(sign * SPEED_MAX, probe.own_speed);
    }
}
