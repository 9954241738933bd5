/* SPDX-License-Identifier: MIT */
/* Current reference: the torque of a current and back, the least current, the circle beside i_d*. */
#include "current_reference.h"

#include "seeded.h"
#include "unity.h"

#include <math.h>
#include <stdlib.h>

#define CURRENT_MAX (16384)

static current_reference_cfg_t cfg;
static current_reference_in_t in;

void setUp(void)
{
    cfg = (current_reference_cfg_t){.floor = 4000, .floor_shift = 1U, .slope = 64, .slope_down = 2};
    in = (current_reference_in_t){.speed = 1000000, .voltage_max = 16000, .ticks = 10};
}

void tearDown(void)
{
}

/* ---- torque ---- */

/* ψ = φ + (L_d − L_q)·i_d: the reluctance torque of an i_d < 0 drives a machine with L_q > L_d. */
static void test_the_flux_is_that_of_the_magnet_and_of_the_saliency(void)
{
    current_loop_cfg_t model = {.emf_q13 = 8000, .reactance_d_q13 = 1000, .reactance_q_q13 = 3000};

    TEST_ASSERT_EQUAL_INT32(8000, current_reference_flux(&model, 0));
    TEST_ASSERT_EQUAL_INT32(8000 - 500, current_reference_flux(&model, 8192));
    TEST_ASSERT_EQUAL_INT32(8000 + 500, current_reference_flux(&model, -8192));
    model.reactance_q_q13 = 1000;
    TEST_ASSERT_EQUAL_INT32(8000, current_reference_flux(&model, 16384));
}

/* Rounded down, and within its format whatever the model. */
static void test_the_flux_stays_within_its_format(void)
{
    const current_loop_cfg_t weak = {.emf_q13 = 0, .reactance_d_q13 = 0, .reactance_q_q13 = 32767};
    const current_loop_cfg_t strong = {
        .emf_q13 = 32767, .reactance_d_q13 = 32767, .reactance_q_q13 = 0};

    TEST_ASSERT_EQUAL_INT32(1, current_reference_flux(&weak, 0));
    TEST_ASSERT_EQUAL_INT32(1, current_reference_flux(&weak, 16384));
    TEST_ASSERT_EQUAL_INT32(16383, current_reference_flux(&weak, -16384));
    TEST_ASSERT_EQUAL_INT32(32767, current_reference_flux(&strong, 16384));
    TEST_ASSERT_EQUAL_INT32(32767 - 16384, current_reference_flux(&strong, -16384));
}

/* A torque goes back to the very current that makes it, so what follows a torque does not creep. */
static void test_the_current_of_a_currents_torque_is_that_current(void)
{
    seeded_t seed = {0x70A9U};

    for (uint32_t k = 0U; k < 100000U; k++) {
        const int32_t current = seeded_in(&seed, -CURRENT_MAX, CURRENT_MAX);
        const int32_t flux = seeded_in(&seed, 1, 32767);

        TEST_ASSERT_EQUAL_INT32(current,
                                current_reference_q(current_reference_torque(current, flux), flux));
    }
}

/* Rounded towards zero: what is asked for is never exceeded. */
static void test_the_current_is_the_torque_by_the_flux_and_ends_with_the_currents(void)
{
    TEST_ASSERT_EQUAL_INT32(99, current_reference_q((100 * 7000) - 1, 7000));
    TEST_ASSERT_EQUAL_INT32(-99, current_reference_q((-100 * 7000) + 1, 7000));
    TEST_ASSERT_EQUAL_INT32(CURRENT_MAX, current_reference_q(INT32_MAX, 1));
    TEST_ASSERT_EQUAL_INT32(-CURRENT_MAX, current_reference_q(INT32_MIN, 1));
    TEST_ASSERT_EQUAL_INT32(CURRENT_REFERENCE_TORQUE_MAX,
                            current_reference_torque(CURRENT_MAX, 32767));
}

/* ---- i_d* ---- */

static int32_t next_d(int32_t d, int32_t q)
{
    in.present = (dq_t){d, q};
    return current_reference_d(&cfg, &in);
}

static void test_the_least_current_comes_with_its_slope_and_goes_with_its_own_fall(void)
{
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    TEST_ASSERT_EQUAL_INT32(4000, next_d(3500, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - 20, next_d(4000, 8000));
    TEST_ASSERT_EQUAL_INT32(0, next_d(19, 8000));
    TEST_ASSERT_EQUAL_INT32(3000, next_d(3000, -2000));
    cfg.floor_shift = 0U;
    TEST_ASSERT_EQUAL_INT32(2000, next_d(2000, 2000));
}

static void test_the_least_current_waits_for_its_speed_and_for_voltage(void)
{
    in.floor_speed = 1000001;
    TEST_ASSERT_EQUAL_INT32(0, next_d(0, 0));
    in.speed = -1000001;
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    in.voltage = (dq_t){0, 15000};
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    in.voltage = (dq_t){0, 15001};
    TEST_ASSERT_EQUAL_INT32(0, next_d(0, 0));
}

/* At any speed and voltage: the start-up's own current. Above the least current it goes as it came. */
static void test_a_current_that_will_be_imposed_comes_before_the_least_one(void)
{
    in.floor_speed = 2000000;
    in.voltage = (dq_t){0, 16000};
    in.imposed = 9000;
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    TEST_ASSERT_EQUAL_INT32(9000, next_d(8900, 0));
    in.imposed = 0;
    TEST_ASSERT_EQUAL_INT32(9000 - 640, next_d(9000, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - 20, next_d(4100, 0));
}

/* ---- the range of i_q* ---- */

static void test_only_what_is_above_the_least_current_takes_of_the_range(void)
{
    const torque_range_t whole = {-8000, 9000};
    torque_range_t left = current_reference_range(&cfg, whole, 4000, 10000);

    TEST_ASSERT_EQUAL_INT32(-8000, left.lower);
    TEST_ASSERT_EQUAL_INT32(9000, left.upper);
    left = current_reference_range(&cfg, whole, 6000, 10000);
    TEST_ASSERT_EQUAL_INT32(-8000, left.lower);
    TEST_ASSERT_EQUAL_INT32(8000, left.upper);
    left = current_reference_range(&cfg, whole, 8000, 10000);
    TEST_ASSERT_EQUAL_INT32(-6000, left.lower);
    TEST_ASSERT_EQUAL_INT32(6000, left.upper);
    left = current_reference_range(&cfg, whole, 10001, 10000);
    TEST_ASSERT_EQUAL_INT32(0, left.lower);
    TEST_ASSERT_EQUAL_INT32(0, left.upper);
}

static void test_the_vector_never_leaves_its_circle(void)
{
    seeded_t seed = {0xC1AC1EU};

    for (uint32_t k = 0U; k < 100000U; k++) {
        const int32_t most = seeded_in(&seed, 1, CURRENT_MAX);
        const int32_t d = seeded_in(&seed, cfg.floor + 1, CURRENT_MAX);
        const torque_range_t left =
            current_reference_range(&cfg, (torque_range_t){-CURRENT_MAX, CURRENT_MAX}, d, most);
        const int32_t room = (most * most) - (d * d);

        TEST_ASSERT_EQUAL_INT32(-left.upper, left.lower);
        TEST_ASSERT_TRUE((left.upper * left.upper) <= ((room > 0) ? room : 0));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_flux_is_that_of_the_magnet_and_of_the_saliency);
    RUN_TEST(test_the_flux_stays_within_its_format);
    RUN_TEST(test_the_current_of_a_currents_torque_is_that_current);
    RUN_TEST(test_the_current_is_the_torque_by_the_flux_and_ends_with_the_currents);
    RUN_TEST(test_the_least_current_comes_with_its_slope_and_goes_with_its_own_fall);
    RUN_TEST(test_the_least_current_waits_for_its_speed_and_for_voltage);
    RUN_TEST(test_a_current_that_will_be_imposed_comes_before_the_least_one);
    RUN_TEST(test_only_what_is_above_the_least_current_takes_of_the_range);
    RUN_TEST(test_the_vector_never_leaves_its_circle);
    return UNITY_END();
}
