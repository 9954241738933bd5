/* SPDX-License-Identifier: MIT */
/*
 * Virtual resistance: the whole voltage for a step, none for a constant current, never more than is
 * stated.
 */
#include "virtual_resistance.h"

#include "seeded.h"
#include "testing.h"

#include <stdlib.h>

#define HALF_BASE (16384)
#define CURRENT_MAX (34400)
#define VOLTAGE_MAX (832045056)
#define MEAN_MAX (536870912)

/* R_v = 0.25 U_b/I_b, a mean over 64 samples. */
static const virtual_resistance_cfg_t CFG = {.resistance_q15 = 8192, .mean_rate_q15 = 512};

static virtual_resistance_t res;

void setUp(void)
{
    virtual_resistance_start(&res, (dq_t){0, 0});
}

static void expect(int32_t d, int32_t q, dq_t actual)
{
    TEST_ASSERT_EQUAL_INT32(d, actual.d);
    TEST_ASSERT_EQUAL_INT32(q, actual.q);
}

TEST(test_the_current_that_it_starts_with_has_no_voltage)
{
    static const int32_t currents[] = {-HALF_BASE, -1, 0, 1, 3000, HALF_BASE - 1};

    for (uint32_t k = 0U; k < (sizeof(currents) / sizeof(currents[0])); k++) {
        const dq_t current = {currents[k], -1 - currents[k]};

        virtual_resistance_start(&res, current);
        expect(current.d, current.q, virtual_resistance_mean(&res));
        for (uint32_t n = 0U; n < 100U; n++) {
            expect(0, 0, virtual_resistance_step(&res, &CFG, current));
        }
        expect(current.d, current.q, virtual_resistance_mean(&res));
    }
}

TEST(test_a_step_has_the_whole_voltage_at_once_in_its_own_axis)
{
    expect(-400 * 8192, 0, virtual_resistance_step(&res, &CFG, (dq_t){400, 0}));
    setUp();
    expect(0, 400 * 8192, virtual_resistance_step(&res, &CFG, (dq_t){0, -400}));
}

/*
 * Of 8000 each sample leaves 63/64. The mean is rounded down, and what it lacks it makes up for:
 * within an LSB of current.
 */
TEST(test_the_voltage_of_a_step_fades_as_the_mean_follows)
{
    double left = 8000.0;

    for (uint32_t k = 0U; k < 400U; k++) {
        const dq_t v = virtual_resistance_step(&res, &CFG, (dq_t){8000, -8000});

        TEST_ASSERT_DOUBLE_WITHIN(8192.0, -8192.0 * left, v.d);
        TEST_ASSERT_DOUBLE_WITHIN(8192.0, 8192.0 * left, v.q);
        left *= 63.0 / 64.0;
    }
}

/* A mean that is kept to the LSB of a current would stop 63 of them short. */
TEST(test_nothing_is_left_of_a_constant_current)
{
    static const int32_t rates[] = {1, 7, 512, HALF_BASE};

    for (uint32_t k = 0U; k < 4U; k++) {
        const virtual_resistance_cfg_t cfg = {HALF_BASE, rates[k]};
        const uint32_t patience = (uint32_t)(20 * (32768 / rates[k]));

        setUp();
        for (uint32_t n = 0U; n < patience; n++) {
            (void)virtual_resistance_step(&res, &cfg, (dq_t){1001, -1001});
        }
        expect(0, 0, virtual_resistance_step(&res, &cfg, (dq_t){1001, -1001}));
        expect(1001, -1001, virtual_resistance_mean(&res));
    }
}

TEST(test_without_resistance_the_mean_follows_all_the_same)
{
    const virtual_resistance_cfg_t cfg = {0, HALF_BASE};

    expect(0, 0, virtual_resistance_step(&res, &cfg, (dq_t){1000, -600}));
    expect(500, -300, virtual_resistance_mean(&res));
}

TEST(test_the_mean_ends_at_half_of_the_base)
{
    const virtual_resistance_cfg_t cfg = {1, HALF_BASE};

    for (uint32_t k = 0U; k < 100U; k++) {
        (void)virtual_resistance_step(&res, &cfg, (dq_t){CURRENT_MAX, -CURRENT_MAX});
    }
    expect(HALF_BASE - 1, -HALF_BASE, virtual_resistance_mean(&res));
}

TEST(test_any_current_and_configuration_stays_within_what_is_stated)
{
    seeded_t seeded = {5U};

    for (uint32_t k = 0U; k < 200000U; k++) {
        const virtual_resistance_cfg_t cfg = {seeded_in(&seeded, 0, HALF_BASE),
                                              seeded_in(&seeded, 1, HALF_BASE)};
        const dq_t current = {(seeded_in(&seeded, 0, 1) != 0) ? CURRENT_MAX : -CURRENT_MAX,
                              seeded_in(&seeded, -CURRENT_MAX, CURRENT_MAX)};
        dq_t v;

        res.mean_q30.d = seeded_in(&seeded, -MEAN_MAX, MEAN_MAX);
        v = virtual_resistance_step(&res, &cfg, current);
        TEST_ASSERT_TRUE((abs(v.d) <= VOLTAGE_MAX) && (abs(v.q) <= VOLTAGE_MAX));
        TEST_ASSERT_TRUE((abs(res.mean_q30.d) <= MEAN_MAX) && (abs(res.mean_q30.q) <= MEAN_MAX));
    }
}
