/* SPDX-License-Identifier: MIT */
/*
 * The sum of three currents: by how much a sensor may be off, and that offsets, noise and few
 * samples are no fault.
 */
#include "current_sum.h"
#include "example_cfg.h"
#include "testing.h"

#include <math.h>

#define TWO_PI (6.283185307179586)
#define AMPLITUDE (4000.0) /* Q15 of I_b */
#define WINDOW (640U)

static supervision_cfg_t cfg;
static current_sum_t state;
static fault_t fault;

void setUp(void)
{
    cfg = example_supervision_cfg();
    fault = (fault_t){.id = FAULT_NONE};
    current_sum_reset(&state);
}

/*
 * One window of a turning vector. gain: what each sensor reads; zero: what the sum is off without
 * current.
 */
static fault_id_t window(const double gain[3], double amplitude, int32_t zero)
{
    fault_id_t id = FAULT_NONE;

    for (uint32_t k = 0U; k < WINDOW; k++) {
        double phase[3];
        current_sum_in_t in;

        for (int32_t n = 0; n < 3; n++) {
            phase[n] = gain[n] * amplitude * cos(TWO_PI * ((0.0125 * k) - (n / 3.0)));
        }
        in.a = (int32_t)lround(phase[0]);
        in.b = (int32_t)lround(phase[1]);
        in.sum = in.a + in.b + (int32_t)lround(phase[2]) + zero;
        id = current_sum_step(&state, &cfg, &in, k == (WINDOW - 1U), &fault);
    }
    return id;
}

static void know_zero(int32_t zero)
{
    for (uint32_t k = 0U; k < 256U; k++) {
        current_sum_zero(&state, zero);
    }
}

TEST(test_sensors_within_their_tolerance_are_no_fault_at_any_current)
{
    const double off[3] = {1.02, 0.98, 1.02};

    know_zero(0);
    for (double amplitude = 0.0; amplitude < 16000.0; amplitude += 500.0) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, window(off, amplitude, 0));
    }
}

/* S = |1 − g|·|i_a|; its mean 2/π of the amplitude. */
TEST(test_each_sensor_at_half_gain_is_found_with_the_mean_of_the_sum)
{
    know_zero(0);
    for (int32_t n = 0; n < 3; n++) {
        double gain[3] = {1.0, 1.0, 1.0};

        gain[n] = 0.5;
        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, window(gain, AMPLITUDE, 0));
        TEST_ASSERT_INT32_WITHIN(2, (int32_t)(0.5 * AMPLITUDE * 4.0 / TWO_PI), fault.value);
        TEST_ASSERT_TRUE(fault.limit > cfg.sum_max);
        TEST_ASSERT_TRUE(fault.limit < fault.value);
    }
}

/*
 * Both sides of the limit: the sum's mean is (g − 1)·2/π of the amplitude, the limit sum_max + 6 %
 * of (2 + g)·2/π of it.
 */
TEST(test_the_limit_is_a_share_of_the_currents_beside_a_constant)
{
    const double mean = AMPLITUDE * 4.0 / TWO_PI;
    const double least = ((cfg.sum_max / mean) + (0.06 * 3.0)) / (1.0 - 0.06);
    double gain[3] = {1.0, 1.0 + (0.97 * least), 1.0};

    know_zero(0);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, window(gain, AMPLITUDE, 0));
    gain[1] = 1.0 + (1.03 * least);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, window(gain, AMPLITUDE, 0));
}

TEST(test_what_the_zeros_of_the_sensors_are_off_is_no_sum)
{
    const double whole[3] = {1.0, 1.0, 1.0};

    know_zero(-1700);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, window(whole, AMPLITUDE, -1700));
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, window(whole, AMPLITUDE, 1700));
}

TEST(test_without_a_zero_nothing_is_judged)
{
    const double half[3] = {0.5, 1.0, 1.0};

    TEST_ASSERT_EQUAL_INT(FAULT_NONE, window(half, AMPLITUDE, 0));
    know_zero(0);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, window(half, AMPLITUDE, 0));
    current_sum_reset(&state);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, window(half, AMPLITUDE, 0));
}

TEST(test_few_samples_are_no_mean_and_many_end_a_window_by_themselves)
{
    const current_sum_in_t wrong = {.a = 4000, .b = 0, .sum = 2000};

    know_zero(0);
    for (uint32_t k = 0U; k < 15U; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, current_sum_step(&state, &cfg, &wrong, true, &fault));
    }
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, current_sum_step(&state, &cfg, &wrong, true, &fault));
    for (uint32_t k = 1U; k < CURRENT_SUM_SAMPLES_MAX; k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, current_sum_step(&state, &cfg, &wrong, false, &fault));
    }
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, current_sum_step(&state, &cfg, &wrong, false, &fault));
}

TEST(test_the_largest_currents_and_zeros_overflow_nothing)
{
    const current_sum_in_t largest = {.a = 16384, .b = 16384, .sum = 131072};

    cfg.sum_share_q15 = 32767;
    for (uint32_t k = 0U; k < (2U * CURRENT_SUM_SAMPLES_MAX); k++) {
        current_sum_zero(&state, -131072);
    }
    TEST_ASSERT_EQUAL_INT32((int32_t)CURRENT_SUM_SAMPLES_MAX, state.zeros);
    for (uint32_t k = 1U; k < CURRENT_SUM_SAMPLES_MAX; k++) {
        (void)current_sum_step(&state, &cfg, &largest, false, &fault);
    }
    TEST_ASSERT_EQUAL_UINT32((CURRENT_SUM_SAMPLES_MAX - 1U) * 262144U, state.sum);
}

/* What a sample adds, and what is forgotten with a window and with the zero. */
static void add(int32_t a, int32_t b, int32_t sum)
{
    const current_sum_in_t in = {.a = a, .b = b, .sum = sum};

    TEST_ASSERT_EQUAL_INT(FAULT_NONE, current_sum_step(&state, &cfg, &in, false, &fault));
}

static void expect_window(uint32_t samples, uint32_t sum, uint32_t flowing)
{
    TEST_ASSERT_EQUAL_UINT32(samples, state.samples);
    TEST_ASSERT_EQUAL_UINT32(sum, state.sum);
    TEST_ASSERT_EQUAL_UINT32(flowing, state.flowing);
}

TEST(test_a_sample_adds_the_size_of_the_sum_and_of_each_current)
{
    current_sum_zero(&state, -150);
    add(100, -300, -200);
    expect_window(1U, 50U, 100U + 300U + 150U);
    add(-100, 30, 0);
    expect_window(2U, 50U + 150U, 550U + 100U + 30U + 220U);
}

TEST(test_without_a_zero_the_third_current_is_that_of_the_other_two)
{
    add(100, -300, 5000);
    expect_window(1U, 0U, 100U + 300U + 200U);
}

TEST(test_a_window_begins_empty_and_a_new_zero_begins_one)
{
    current_sum_zero(&state, 7);
    add(100, -300, 50);
    current_sum_begin(&state);
    expect_window(0U, 0U, 0U);
    TEST_ASSERT_EQUAL_INT32(1, state.zeros);
    add(100, -300, 50);
    current_sum_reset(&state);
    expect_window(0U, 0U, 0U);
    TEST_ASSERT_EQUAL_INT32(0, state.zeros);
    TEST_ASSERT_EQUAL_INT32(0, state.zero_sum);
}

TEST(test_a_mean_at_its_limit_is_no_fault)
{
    cfg.sum_share_q15 = 0;
    know_zero(0);
    for (int32_t beyond = 0; beyond <= 1; beyond++) {
        const current_sum_in_t in = {.a = 0, .b = 0, .sum = cfg.sum_max + beyond};
        fault_id_t id = FAULT_NONE;

        for (uint32_t k = 1U; k <= 16U; k++) {
            id = current_sum_step(&state, &cfg, &in, k == 16U, &fault);
        }
        TEST_ASSERT_EQUAL_INT((beyond == 0) ? FAULT_NONE : FAULT_CURRENT_SUM, id);
    }
    TEST_ASSERT_EQUAL_INT32(cfg.sum_max + 1, fault.value);
    TEST_ASSERT_EQUAL_INT32(cfg.sum_max, fault.limit);
}
