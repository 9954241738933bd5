/* SPDX-License-Identifier: MIT */
/*
 * Current reference: the torque of a current and back, the least current, MTPA, weakening, the
 * circle beside i_d*.
 */
#include "current_reference.h"

#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>

#define CURRENT_MAX (16384)
#define GRID (2000)
#define ASIN_1 (1.57079632679489662)
/*
 * Beyond c = 131071 i_d is 0: a torque of 1/(1 + (i_q/2c)²/2) of the largest, 0.2 % less. i_d is
 * rounded to 1 of 2000.
 */
#define MTPA_LEAST (0.998)
#define ROUNDED (1e-6) /* the grid does not meet the best angle */

static current_reference_cfg_t cfg;
static current_reference_in_t in;
static current_loop_cfg_t motor;
static weakening_t weakening;

void setUp(void)
{
    cfg = (current_reference_cfg_t){.floor = 4000, .floor_shift = 1U, .slope = 64, .slope_down = 2};
    motor = (current_loop_cfg_t){.emf_q13 = 8192, .reactance_d_q13 = 4096, .reactance_q_q13 = 4096};
    in = (current_reference_in_t){.speed = 1000000, .ticks = 10};
}

/* ---- torque ---- */

static int32_t flux_of(int32_t emf, int32_t reactance_d, int32_t reactance_q, int32_t d)
{
    const current_loop_cfg_t model = {
        .emf_q13 = emf, .reactance_d_q13 = reactance_d, .reactance_q_q13 = reactance_q};

    return current_reference_flux(&model, d);
}

/*
 * ψ = φ + (L_d − L_q)·i_d: the reluctance torque of an i_d < 0 drives a machine with L_q > L_d.
 * Rounded down, and within its format whatever the model.
 */
TEST(test_the_flux_is_that_of_the_magnet_and_of_the_saliency_within_its_format)
{
    TEST_ASSERT_EQUAL_INT32(8000, flux_of(8000, 1000, 3000, 0));
    TEST_ASSERT_EQUAL_INT32(8000 - 500, flux_of(8000, 1000, 3000, 8192));
    TEST_ASSERT_EQUAL_INT32(8000 + 500, flux_of(8000, 1000, 3000, -8192));
    TEST_ASSERT_EQUAL_INT32(8000, flux_of(8000, 1000, 1000, 16384));
    TEST_ASSERT_EQUAL_INT32(1, flux_of(0, 0, 32767, 0));
    TEST_ASSERT_EQUAL_INT32(1, flux_of(0, 0, 32767, 16384));
    TEST_ASSERT_EQUAL_INT32(16383, flux_of(0, 0, 32767, -16384));
    TEST_ASSERT_EQUAL_INT32(32767, flux_of(32767, 32767, 0, 16384));
    TEST_ASSERT_EQUAL_INT32(32767 - 16384, flux_of(32767, 32767, 0, -16384));
}

/* A torque goes back to the very current that makes it, so what follows a torque does not creep. */
TEST(test_the_current_of_a_currents_torque_is_that_current)
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
TEST(test_the_current_is_the_torque_by_the_flux_and_ends_with_the_currents)
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
    return current_reference_d(&cfg, &motor, &in);
}

TEST(test_the_least_current_comes_with_its_slope_and_goes_with_its_own_fall)
{
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    TEST_ASSERT_EQUAL_INT32(4000, next_d(3500, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - 20, next_d(4000, 8000));
    TEST_ASSERT_EQUAL_INT32(0, next_d(19, 8000));
    TEST_ASSERT_EQUAL_INT32(3000, next_d(3000, -2000));
    cfg.floor_shift = 0U;
    TEST_ASSERT_EQUAL_INT32(2000, next_d(2000, 2000));
}

/*
 * Of a salient machine: above the least current and below, so that its flux is back before the
 * torque is there.
 */
TEST(test_a_fall_that_is_faster_than_the_rise_is_the_same_on_both_sides_of_the_least_current)
{
    cfg.slope_down = 100;
    TEST_ASSERT_EQUAL_INT32(5000 - 1000, next_d(5000, 8000));
    TEST_ASSERT_EQUAL_INT32(4000 - 1000, next_d(4000, 8000));
    TEST_ASSERT_EQUAL_INT32(0, next_d(1000, 8000));
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
}

TEST(test_the_least_current_waits_for_its_speed)
{
    in.floor_speed = 1000001;
    TEST_ASSERT_EQUAL_INT32(0, next_d(0, 0));
    in.speed = -1000001;
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
}

/*
 * At any speed and voltage: the start-up's own current. Above the least current it goes as it came.
 */
TEST(test_a_current_that_will_be_imposed_comes_before_the_least_one)
{
    in.floor_speed = 2000000;
    in.imposed = 9000;
    TEST_ASSERT_EQUAL_INT32(640, next_d(0, 0));
    TEST_ASSERT_EQUAL_INT32(9000, next_d(8900, 0));
    in.imposed = 0;
    TEST_ASSERT_EQUAL_INT32(9000 - 640, next_d(9000, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - 20, next_d(4100, 0));
}

/* ---- MTPA ---- */

/* i_d and i_q of the largest torque of a current, by a grid. */
static double most_torque(double current, double saliency)
{
    double best = 0.0;

    for (int k = 0; k <= GRID; k++) {
        const double angle = k * (ASIN_1 / GRID);
        const double torque = (1.0 + (saliency * current * sin(angle))) * current * cos(angle);

        best = fmax(best, torque);
    }
    return best;
}

/* The slope is out of the way, and i_q is given: i_d after any number of periods is that of one. */
static int32_t settled_d(int32_t q)
{
    cfg.slope = CURRENT_MAX;
    cfg.slope_down = CURRENT_MAX;
    return next_d(0, q);
}

/* From nearly none to a machine without a magnet: L_q − L_d as a share of φ/I_b. */
TEST(test_the_torque_of_a_current_is_the_largest_there_is)
{
    cfg.most_torque = 1U;
    cfg.floor = 0;
    for (int32_t saliency = 0; saliency <= 28672; saliency += 512) {
        for (int32_t q = 2000; q <= 11000; q += 1000) {
            motor.reactance_q_q13 = motor.reactance_d_q13 + saliency;
            const int32_t d = settled_d(q);
            const double current = hypot(d, q) / 32768;
            const double ratio = (double)saliency / motor.emf_q13;
            const double torque = (1.0 - (ratio * d / 32768)) * q / 32768;

            TEST_ASSERT_TRUE(torque >= (MTPA_LEAST * most_torque(current, ratio)));
        }
    }
}

/* Of a current of this amplitude, rounded down. */
TEST(test_the_largest_torque_is_that_of_the_best_angle)
{
    for (int32_t saliency = 0; saliency <= 28672; saliency += 1024) {
        for (int32_t current = 2000; current <= CURRENT_MAX; current += 2000) {
            motor.reactance_q_q13 = motor.reactance_d_q13 + saliency;
            cfg.most_torque = 1U;
            const double ratio = (double)saliency / motor.emf_q13;
            const double most = most_torque(current / 32768.0, ratio) * motor.emf_q13 * 32768.0;
            const double found = current_reference_torque_max(&cfg, &motor, current);

            TEST_ASSERT_TRUE(found <= most * (1.0 + ROUNDED));
            TEST_ASSERT_TRUE(found >= most * MTPA_LEAST);
            cfg.most_torque = 0U;
            TEST_ASSERT_EQUAL_INT32(current * motor.emf_q13,
                                    current_reference_torque_max(&cfg, &motor, current));
        }
    }
    TEST_ASSERT_EQUAL_INT32(CURRENT_MAX * motor.emf_q13,
                            current_reference_torque_max(&cfg, &motor, CURRENT_MAX));
}

TEST(test_mtpa_is_only_for_what_asks_for_it_and_has_a_larger_l_q)
{
    motor.reactance_q_q13 = 3 * motor.reactance_d_q13;
    TEST_ASSERT_EQUAL_INT32(0, settled_d(10000));
    cfg.most_torque = 1U;
    TEST_ASSERT_LESS_THAN_INT32(-1000, settled_d(10000));
    motor.reactance_q_q13 = motor.reactance_d_q13 / 2;
    TEST_ASSERT_EQUAL_INT32(0, settled_d(10000));
}

/* Below its speed the least current asks for nothing, and MTPA has i_d* to itself. */
TEST(test_the_larger_one_of_least_current_and_mtpa_counts)
{
    cfg.most_torque = 1U;
    motor.reactance_q_q13 = 3 * motor.reactance_d_q13;
    const int32_t alone = settled_d(10000);

    TEST_ASSERT_EQUAL_INT32(4000 - 3000, settled_d(6000));
    in.floor_speed = 2000000;
    TEST_ASSERT_LESS_THAN_INT32(0, settled_d(6000));
    TEST_ASSERT_EQUAL_INT32(alone, settled_d(10000));
}

/* Below the least current's speed, with all of the slope: i_d* is what MTPA asks for. */
static int32_t mtpa_d(int32_t emf_q13, int32_t saliency_q13, int32_t q)
{
    cfg.most_torque = 1U;
    in.floor_speed = 2000000;
    motor = (current_loop_cfg_t){.emf_q13 = emf_q13, .reactance_q_q13 = saliency_q13};
    return settled_d(q);
}

TEST(test_mtpa_is_exact_at_its_ends_and_without_a_magnet)
{
    /* c = 8·16384 = 131072 is the first beyond the end, */
    TEST_ASSERT_EQUAL_INT32(0, mtpa_d(8192, 1024, 16384));
    /* c = ⌊32767·16384/4096⌋ = 131068 the last before it: 2^28 / (4·(32767 + 33022)). */
    TEST_ASSERT_EQUAL_INT32(-1020, mtpa_d(32767, 4096, 16384));
    /* Rounded down in depth: c = 32767 is whole, 2^28 / (32767 + 36634) = 3867.9; */
    TEST_ASSERT_EQUAL_INT32(-3867, mtpa_d(32767, 16384, 16384));
    /* c = 32768 is counted in quarters, 16353² / (4·(8192 + 9155)) = 3853.9. */
    TEST_ASSERT_EQUAL_INT32(-3853, mtpa_d(32766, 16383, 16353));
    /* Without a magnet i_d = −|i_q|, up to the largest current, which no end of i_d* cuts. */
    TEST_ASSERT_EQUAL_INT32(0, mtpa_d(0, 1, 0));
    TEST_ASSERT_EQUAL_INT32(-1, mtpa_d(0, 1, 1));
    TEST_ASSERT_EQUAL_INT32(-5000, mtpa_d(0, 1, 5000));
    TEST_ASSERT_EQUAL_INT32(-5000, mtpa_d(0, 1, -5000));
    TEST_ASSERT_EQUAL_INT32(-16383, mtpa_d(0, 1, 16383));
    TEST_ASSERT_EQUAL_INT32(-16384, mtpa_d(0, 1, 16384));
    TEST_ASSERT_EQUAL_INT32(-16384, mtpa_d(0, 1, -16384));
}

/* 4000 − i_q/2 below 0 counts four times. Without a magnet MTPA is −|i_q|, far below. */
TEST(test_the_least_current_gives_way_fourfold_from_where_the_torque_is_enough)
{
    cfg.most_torque = 1U;
    motor = (current_loop_cfg_t){.reactance_q_q13 = 1};
    TEST_ASSERT_EQUAL_INT32(1, settled_d(7998));
    TEST_ASSERT_EQUAL_INT32(0, settled_d(8000));
    TEST_ASSERT_EQUAL_INT32(-4, settled_d(8002));
    TEST_ASSERT_EQUAL_INT32(-40, settled_d(-8020));
}

/* ---- weakening ---- */

/* E = 253/256 of 12800, ω·φ = 16384, X = 1: an i_d of −3734 at most. */
static current_reference_t weakened(int32_t present, int32_t next, int32_t deepest)
{
    const weakening_in_t point = {.model = &motor,
                                  .speed_q15 = 16384,
                                  .reference = {present, 0},
                                  .voltage = {0, 12600},
                                  .current_max = 12000,
                                  .deepest = deepest};

    motor.reactance_d_q13 = 16384;
    motor.reactance_q_q13 = 16384;
    weakening_reset(&weakening);
    (void)weakening_follow_bus(&weakening, (dq_t){0, 12600}, 12800);
    return current_reference_weakened(&weakening, &point, next);
}

TEST(test_a_weakened_i_d_falls_by_a_quarter_and_rises_by_an_eighth)
{
    TEST_ASSERT_INT32_WITHIN(4, -3734 / 4, weakened(0, 0, 9000).d);
    TEST_ASSERT_INT32_WITHIN(4, -8000 + ((8000 - 3734) / 8), weakened(-8000, 0, 9000).d);
}

/* What all else wants is below it already, and the voltage leaves all of i_q*. */
TEST(test_weakening_raises_nothing_and_takes_nothing_where_it_does_not_decide)
{
    const current_reference_t there = weakened(-5000, -5000, 9000);

    TEST_ASSERT_EQUAL_INT32(-5000, there.d);
    TEST_ASSERT_EQUAL_INT32(CURRENT_REFERENCE_ALL, there.reach);
}

TEST(test_weakening_ends_where_the_magnets_bear_no_more)
{
    const current_reference_t there = weakened(-3000, 0, 3000);

    TEST_ASSERT_EQUAL_INT32(-3000, there.d);
    TEST_ASSERT_LESS_THAN_INT32(CURRENT_MAX, there.reach);
}

/* ---- the range of i_q* ---- */

static torque_range_t range_beside(torque_range_t range, int32_t d, int32_t reach, int32_t most)
{
    const current_reference_t reference = {.d = d, .reach = reach};

    return current_reference_range(&cfg, range, &reference, most);
}

/* A range beside i_d*: what circle and voltage leave of it. */
static void check_range(torque_range_t range, int32_t d, int32_t reach, int32_t most,
                        torque_range_t expected)
{
    const torque_range_t left = range_beside(range, d, reach, most);

    TEST_ASSERT_EQUAL_INT32(expected.lower, left.lower);
    TEST_ASSERT_EQUAL_INT32(expected.upper, left.upper);
}

/* √(10000² − 6000²) = 8000 */
TEST(test_the_least_current_takes_nothing_of_the_range_and_all_else_does)
{
    const torque_range_t whole = {-8000, 9000};

    check_range(whole, 4000, CURRENT_MAX, 10000, whole);
    check_range(whole, 6000, CURRENT_MAX, 10000, (torque_range_t){-8000, 8000});
    check_range(whole, -8000, CURRENT_MAX, 10000, (torque_range_t){-6000, 6000});
    check_range(whole, 10001, CURRENT_MAX, 10000, (torque_range_t){0, 0});
}

TEST(test_i_q_ends_where_the_voltage_does_or_the_circle)
{
    const int32_t all = CURRENT_REFERENCE_ALL;
    const torque_range_t whole = {-9000, 9000};

    check_range((torque_range_t){-8000, 900}, 0, 1000, 10000, (torque_range_t){-1000, 900});
    check_range((torque_range_t){-900, 8000}, 0, 1000, 10000, (torque_range_t){-900, 1000});
    check_range((torque_range_t){-all, all}, 0, all - 1, 10000, (torque_range_t){1 - all, all - 1});
    check_range(whole, -6000, 7999, 10000, (torque_range_t){-7999, 7999});
    check_range(whole, -6000, 8001, 10000, (torque_range_t){-8000, 8000});
}

/*
 * From i_d* = 0 to the least current itself the range is left as it is, also one beyond the circle.
 */
TEST(test_from_zero_to_the_least_current_the_circle_takes_nothing)
{
    const torque_range_t whole = {-10000, 10000};

    check_range(whole, 0, CURRENT_MAX, 9000, whole);
    check_range(whole, 4000, CURRENT_MAX, 9000, whole);
    /* √(9000² − 4001²) = 8061.5, √(9000² − 1) = 8999.9 */
    check_range(whole, 4001, CURRENT_MAX, 9000, (torque_range_t){-8061, 8061});
    check_range(whole, -1, CURRENT_MAX, 9000, (torque_range_t){-8999, 8999});
}

TEST(test_the_vector_never_leaves_its_circle)
{
    seeded_t seed = {0xC1AC1EU};

    for (uint32_t k = 0U; k < 100000U; k++) {
        const int32_t most = seeded_in(&seed, 0, CURRENT_MAX);
        const int32_t above = seeded_in(&seed, cfg.floor + 1, CURRENT_MAX);
        const int32_t d = ((k & 1U) != 0U) ? above : -seeded_in(&seed, 1, CURRENT_MAX);
        const torque_range_t left =
            range_beside((torque_range_t){-CURRENT_MAX, CURRENT_MAX}, d, CURRENT_MAX, most);
        const int32_t room = (most * most) - (d * d);

        TEST_ASSERT_EQUAL_INT32(-left.upper, left.lower);
        TEST_ASSERT_TRUE((left.upper * left.upper) <= ((room > 0) ? room : 0));
    }
}
