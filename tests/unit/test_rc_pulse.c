/* SPDX-License-Identifier: MIT */
/*
 * Servo pulses: widths and rates that a receiver or a servo tester has, and pulses that are none.
 *
 * Facts. A servo tester sends 1000 to 2000 µs (some 800 to 2200 µs) every 20 ms. Flight controllers
 * send the same pulses with 50 to 490 Hz.
 */
#include "rc_pulse.h"
#include "seeded.h"
#include "testing.h"

#define MS (10000U) /* in 1/HAL_PULSE_HZ */
#define US (10U)

static const input_cfg_t CFG = {
    .kind = (uint32_t)INPUT_KIND_RC_PULSE, .least = 8000, .most = 22000}; /* 0.8 to 2.2 ms */

static rc_pulse_t rc;
static input_signal_t signal;
static uint32_t time;

void setUp(void)
{
    rc = (rc_pulse_t){0};
    input_signal_init(&signal, 0U);
    time = 123U;
}

/* A pulse that begins `period` after the one before it. */
static void pulse(uint32_t period, uint32_t width)
{
    time += period;
    rc_pulse_take(&rc, &(hal_pulse_t){.start = time, .width = width}, &CFG, &signal, 1U);
}

static void pulses(uint32_t count, uint32_t period, uint32_t width)
{
    for (uint32_t k = 0U; k < count; k++) {
        pulse(period, width);
    }
}

static bool is_there(void)
{
    return signal.lost == (uint8_t)INPUT_LOST_NOT;
}

TEST(test_widths_of_a_servo_tester_are_read_at_every_rate_of_a_receiver)
{
    static const uint32_t widths_us[] = {800U, 1000U, 1500U, 2000U, 2200U};
    static const uint32_t rates_hz[] = {50U, 100U, 333U, 400U, 490U};

    for (uint32_t k = 0U; k < 25U; k++) {
        const uint32_t width = widths_us[k % 5U] * US;
        const uint32_t period = HAL_PULSE_HZ / rates_hz[k / 5U];

        if ((width + (50U * US)) < period) { /* 2.2 ms do not fit 490 Hz */
            setUp();
            pulses(9U, period, width); /* the first one has no period */
            TEST_ASSERT_TRUE(is_there());
            TEST_ASSERT_EQUAL_UINT32(width, input_signal_value(&signal));
        }
    }
}

TEST(test_a_width_or_a_rate_outside_its_range_is_no_pulse)
{
    static const struct {
        uint32_t period;
        uint32_t width;
    } bad[] = {{20U * MS, 7999U},
               {20U * MS, 22001U},
               {20U * MS, 1U},
               {20U * MS, 0U},
               {20U * MS, 10U * MS},
               {(19U * MS) / 10U - 1U, 15000U},
               {(25U * MS) + 1U, 15000U},
               {1000U * MS, 15000U}};

    for (uint32_t k = 0U; k < (sizeof bad / sizeof bad[0]); k++) {
        setUp();
        pulses(20U, bad[k].period, bad[k].width);
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SHAPE, signal.lost);
    }
    setUp();
    pulses(9U, 25U * MS, 8000U);
    TEST_ASSERT_TRUE(is_there());
}

TEST(test_a_glitch_in_the_pause_changes_no_value)
{
    static const uint32_t widths[] = {1U, 500U, 12000U, 22001U};

    for (uint32_t k = 0U; k < 4U; k++) {
        setUp();
        pulses(10U, 20U * MS, 15000U);
        (void)input_signal_was_noisy(&signal);
        pulse(10U * MS, widths[k]);
        TEST_ASSERT_TRUE(input_signal_was_noisy(&signal));
        pulse(10U * MS, 15000U);
        TEST_ASSERT_TRUE(is_there());
        TEST_ASSERT_EQUAL_UINT32(15000U, input_signal_value(&signal));
    }
}

TEST(test_a_period_that_is_a_quarter_off_the_one_before_is_bad_and_a_steady_one_is_not)
{
    pulses(10U, 16U * MS, 15000U);
    (void)input_signal_was_noisy(&signal);
    pulse(20U * MS, 15000U);
    pulse(15U * MS, 15000U);
    TEST_ASSERT_FALSE(input_signal_was_noisy(&signal));
    pulse((15U * MS * 5U) / 4U + 2U, 15000U);
    TEST_ASSERT_TRUE(input_signal_was_noisy(&signal));
    pulse((15U * MS * 15U) / 16U - 4U, 15000U);
    TEST_ASSERT_TRUE(input_signal_was_noisy(&signal));
}

/*
 * Random widths at random times, as of a receiver that is switched off. Some 17 % look good, and
 * 0.17^8 is 7e-7; a start needs half a second of that at rest, and without a single bad pulse.
 */
TEST(test_noise_is_hardly_ever_a_signal)
{
    seeded_t seed = {4242U};
    const uint32_t runs = testing_runs(300000U, 30000000U);
    uint32_t there = 0U;

    for (uint32_t k = 0U; k < runs; k++) {
        pulse((uint32_t)seeded_in(&seed, 1000, 300000), (uint32_t)seeded_in(&seed, 5000, 25000));
        there += is_there() ? 1U : 0U;
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(runs / 10000U, there);
}

TEST(test_a_glitch_close_to_a_pulse_spoils_that_pulse_too)
{
    pulses(9U, 20U * MS, 15000U);
    pulse(19U * MS, 500U);
    pulse(1U * MS, 16000U);
    TEST_ASSERT_EQUAL_UINT8(2U, signal.bad);
    TEST_ASSERT_EQUAL_UINT32(15000U, input_signal_value(&signal));
}

TEST(test_a_pulse_that_a_glitch_has_split_is_no_pulse)
{
    pulses(9U, 20U * MS, 15000U);
    pulse(20U * MS, 7000U);
    pulse(7100U, 7900U);
    TEST_ASSERT_EQUAL_UINT8(2U, signal.bad);
    TEST_ASSERT_EQUAL_UINT32(15000U, input_signal_value(&signal));
}

TEST(test_the_time_of_the_pulses_may_wrap)
{
    time = UINT32_MAX - (50U * MS);
    pulses(9U, 20U * MS, 15000U);
    TEST_ASSERT_TRUE(is_there());
    TEST_ASSERT_EQUAL_UINT32(8U, signal.count); /* the first one has no period */
}
