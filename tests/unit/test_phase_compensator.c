/* SPDX-License-Identifier: MIT */
/* Phase compensator: what it accumulates and when, its limits, its sign in both directions. */
#include "phase_compensator.h"
#include "seeded.h"
#include "testing.h"

#include <stdint.h>

#define DEGREE (11930465)     /* 2^32 / 360 */
#define EIGHTH (0x20000000)   /* 45° */
#define QUARTER (0x40000000)  /* 90° */
#define ANGLE_ERROR (1 << 15) /* of trig_atan2: 2^-17 turn */

/* g = 2^-9, so that a shift tells the turn exactly. */
static const phase_compensator_cfg_t CFG = {
    .gain = 16384,
    .gain_shift = 7U,
    .lead_max = 40 * DEGREE,
    .brake_max = 5 * DEGREE,
    .current_min = 1000,
};

static phase_compensator_t comp;

void setUp(void)
{
    phase_compensator_start(&comp, 0U);
}

static int32_t step(dq_t current, bool forwards)
{
    return phase_compensator_step(&comp, &CFG, current, 0U, 0, forwards);
}

/*
 * (41): what is measured now turns θ_s of the next sample but one, which the lead of that one
 * shows.
 */
TEST(test_a_current_turns_the_lead_two_steps_later)
{
    TEST_ASSERT_EQUAL_INT32(0, step((dq_t){3000, 3000}, true));
    TEST_ASSERT_EQUAL_INT32(0, step((dq_t){0, 3000}, true));
    TEST_ASSERT_EQUAL_INT32(EIGHTH >> 9U, step((dq_t){0, 3000}, true));
}

/* Both as 32767, −32768: 45°. */
TEST(test_a_current_beyond_16_bits_keeps_its_sign_and_counts_as_the_largest)
{
    (void)step((dq_t){40000, 1000000}, true);
    TEST_ASSERT_INT32_WITHIN(ANGLE_ERROR, EIGHTH, comp.current_angle);
    (void)step((dq_t){-40000, -1000000}, true);
    TEST_ASSERT_INT32_WITHIN(ANGLE_ERROR, -EIGHTH, comp.current_angle);
}

/* (43) and not (42): each sample adds to what is there, and without i_d the lead stays. */
TEST(test_the_lead_accumulates_and_stays_without_i_d)
{
    for (int32_t k = 0; k < 10; k++) {
        (void)step((dq_t){3000, 3000}, true);
    }
    (void)step((dq_t){0, 3000}, true);
    for (int32_t k = 0; k < 10; k++) {
        TEST_ASSERT_EQUAL_INT32(10 * (EIGHTH >> 9U), step((dq_t){0, 3000}, true));
    }
}

TEST(test_the_firing_angle_goes_on_with_the_rotor)
{
    const step_t speed = 3 * DEGREE;
    angle_t rotor = 0xF0000000U; /* over the end of a turn */

    phase_compensator_start(&comp, rotor + (angle_t)(7 * DEGREE));
    for (int32_t k = 0; k < 200; k++) {
        TEST_ASSERT_EQUAL_INT32(
            7 * DEGREE, phase_compensator_step(&comp, &CFG, (dq_t){0, 3000}, rotor, speed, true));
        rotor += (angle_t)speed;
    }
}

/* A rotor that does not turn as the detector says shows in the lead: K2 = 1 takes it for true. */
TEST(test_a_speed_that_is_off_is_seen_in_the_lead)
{
    (void)phase_compensator_step(&comp, &CFG, (dq_t){0, 3000}, 0U, DEGREE, true);
    TEST_ASSERT_EQUAL_INT32(DEGREE, step((dq_t){0, 3000}, true));
}

TEST(test_braking_turns_the_lead_as_motoring_does)
{
    static const int32_t i_q[] = {3000, -3000};

    for (uint32_t k = 0U; k < 2U; k++) {
        phase_compensator_start(&comp, 0U);
        for (int32_t n = 0; n < 3; n++) {
            (void)step((dq_t){3000, i_q[k]}, true);
        }
        TEST_ASSERT_EQUAL_INT32(2 * (EIGHTH >> 9U), step((dq_t){0, i_q[k]}, true));
    }
}

TEST(test_backwards_is_the_mirror_of_forwards)
{
    seeded_t seeded = {7U};
    phase_compensator_t mirror;

    phase_compensator_start(&mirror, 0U);
    for (int32_t k = 0; k < 20000; k++) {
        const dq_t current = {seeded_in(&seeded, -5000, 9000), seeded_in(&seeded, -9000, 9000)};
        const dq_t opposite = {current.d, -current.q};
        const int32_t lead = step(current, true);
        const int32_t mirrored = phase_compensator_step(&mirror, &CFG, opposite, 0U, 0, false);

        TEST_ASSERT_EQUAL_INT32(lead, -mirrored);
    }
}

TEST(test_the_lead_ends_at_its_limits_and_leaves_them_at_once)
{
    static const int32_t end[] = {40 * DEGREE, -5 * DEGREE};
    static const int32_t i_d[] = {3000, -3000};

    for (uint32_t k = 0U; k < 2U; k++) {
        phase_compensator_start(&comp, 0U);
        for (int32_t n = 0; n < 1000; n++) {
            (void)step((dq_t){i_d[k], 3000}, true);
        }
        TEST_ASSERT_EQUAL_INT32(end[k], step((dq_t){i_d[k], 3000}, true));
        (void)step((dq_t){-i_d[k], 3000}, true);
        (void)step((dq_t){-i_d[k], 3000}, true);
        TEST_ASSERT_INT32_WITHIN(1, end[k] - ((i_d[k] / 3000) * (EIGHTH >> 9U)),
                                 step((dq_t){0, 3000}, true));
    }
}

/* A quarter of current_min in d, nothing in q: atan(1/4) and not 90°. */
TEST(test_a_small_vector_has_no_large_angle)
{
    const int32_t angle = 167458907; /* atan(1/4) = 14.0362° */

    (void)step((dq_t){250, 0}, true);
    TEST_ASSERT_INT32_WITHIN(ANGLE_ERROR, angle, comp.current_angle);
    (void)step((dq_t){250, 999}, true);
    TEST_ASSERT_INT32_WITHIN(ANGLE_ERROR, angle, comp.current_angle);
    (void)step((dq_t){0, 0}, true);
    TEST_ASSERT_EQUAL_INT32(0, comp.current_angle);
}

/*
 * i_d at i_q = 0 and its α_r = atan(i_d/current_min): it fades with the vector, and so does the
 * step of the lead.
 */
TEST(test_the_smaller_the_vector_the_less_the_lead_moves)
{
    static const int32_t i_d[] = {1000, 250, 10, 0};
    static const int32_t angle[] = {EIGHTH, 167458907, 6835425, 0}; /* 45°, 14.04°, 0.573°, 0 */

    for (uint32_t k = 0U; k < 4U; k++) {
        phase_compensator_start(&comp, 0U);
        (void)step((dq_t){i_d[k], 0}, true);
        (void)step((dq_t){0, 0}, true);
        for (int32_t n = 0; n < 3; n++) { /* one step, and then none */
            TEST_ASSERT_INT32_WITHIN((ANGLE_ERROR >> 9U) + 1, angle[k] >> 9U,
                                     step((dq_t){0, 0}, true));
        }
    }
}

TEST(test_without_gain_the_lead_stays_whatever_flows)
{
    phase_compensator_cfg_t cfg = CFG;

    cfg.gain = 0;
    phase_compensator_start(&comp, (angle_t)(9 * DEGREE));
    for (int32_t k = 0; k < 100; k++) {
        TEST_ASSERT_EQUAL_INT32(
            9 * DEGREE, phase_compensator_step(&comp, &cfg, (dq_t){5000, 3000}, 0U, 0, true));
    }
}

TEST(test_a_new_start_forgets_the_current)
{
    (void)step((dq_t){3000, 3000}, true);
    phase_compensator_start(&comp, (angle_t)DEGREE);
    TEST_ASSERT_EQUAL_INT32(0, comp.current_angle);
    (void)step((dq_t){0, 3000}, true);
    TEST_ASSERT_EQUAL_INT32(DEGREE, step((dq_t){0, 3000}, true));
}

TEST(test_any_state_and_input_stays_within_its_limits)
{
    seeded_t seeded = {11U};

    for (int32_t k = 0; k < 200000; k++) {
        const dq_t current = {seeded_i32(&seeded) / 2, seeded_i32(&seeded) / 2};
        const bool forwards = (seeded_u32(&seeded) & 1U) != 0U;
        const int32_t highest = forwards ? CFG.lead_max : CFG.brake_max;
        const int32_t lowest = forwards ? -CFG.brake_max : -CFG.lead_max;
        int32_t lead;

        comp.angle = seeded_u32(&seeded);
        lead = phase_compensator_step(&comp, &CFG, current, seeded_u32(&seeded),
                                      seeded_i32(&seeded), forwards);
        TEST_ASSERT_TRUE((lead >= lowest) && (lead <= highest));
        TEST_ASSERT_TRUE((comp.current_angle >= -QUARTER) && (comp.current_angle <= QUARTER));
    }
}
