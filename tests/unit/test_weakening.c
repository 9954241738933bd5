/* SPDX-License-Identifier: MIT */
/*
 * Field weakening: the voltage ellipse, the deepest useful i_d, the integral of the voltage, the
 * valleys of the bus.
 */
#include "weakening.h"

#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define CURRENT_END (16384)
#define MOTORS (20000U)
#define GRID (4000)

/*
 * Each voltage is rounded to Q14 of U_b, and a share of the current to 2^-14. Three voltages meet
 * in a difference.
 */
#define VOLT_LSB (1.0 / 16384)
#define VOLT_ROUNDINGS (3.0)
#define SHARE_ROUNDINGS (3.0 / 16384)

/* A point of the ellipse in double precision: voltages of U_b, currents of I. */
typedef struct {
    double emf;
    double flux;
    double along;
    double across;
} ellipse_t;

static weakening_t weakening;
static current_loop_cfg_t model;
static weakening_in_t in;
static int32_t bus; /* radius of the circle */

/* This bus from the start on. Nothing is learned. */
static void see_bus(int32_t radius)
{
    bus = radius;
    weakening_reset(&weakening);
    (void)weakening_follow_bus(&weakening, (dq_t){0, 0}, radius);
}

static void set_motor(int32_t emf, int32_t reactance_d, int32_t reactance_q)
{
    model = (current_loop_cfg_t){
        .emf_q13 = emf, .reactance_d_q13 = reactance_d, .reactance_q_q13 = reactance_q};
}

void setUp(void)
{
    set_motor(8192, 16384, 16384);
    in = (weakening_in_t){.model = &model,
                          .speed_q15 = 16384,
                          .voltage = {0, 12000},
                          .current_max = 10000,
                          .deepest = 10000};
    see_bus(12800);
}

/* The ellipse that the module has: no resistance, and the reserve taken off. */
static ellipse_t ellipse_of_in(void)
{
    const double speed = in.speed_q15 / 32768.0;
    const double most = in.current_max / 32768.0;

    return (ellipse_t){.emf = speed * model.emf_q13 / 8192,
                       .flux = bus * (253.0 / 256) / 32768,
                       .along = speed * model.reactance_d_q13 / 8192 * most,
                       .across = speed * model.reactance_q_q13 / 8192 * most};
}

static weakening_limits_t limits(void)
{
    weakening_limits_t now = weakening_step(&weakening, &in, CURRENT_END);

    weakening.voltage = 0; /* what was learned is not the matter */
    return now;
}

static void assert_limits(int32_t lower, int32_t upper, int32_t reach, weakening_limits_t now)
{
    TEST_ASSERT_EQUAL_INT32_MESSAGE(lower, now.lower, "lower");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(upper, now.upper, "upper");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(reach, now.reach, "reach");
}

/*
 * Largest y = −i_d/I that the circle has on the ellipse, 0: all of it lies within. By bisection:
 * the ellipse is left once.
 */
static double circle_depth(const ellipse_t *e)
{
    double low = 0.0;
    double high = 1.0;

    for (int k = 0; k < 50; k++) {
        const double y = (low + high) / 2.0;
        const double x = e->emf - (e->along * y);
        const double square = (e->across * e->across * (1.0 - (y * y))) + (x * x);

        if (square > (e->flux * e->flux)) {
            low = y;
        } else {
            high = y;
        }
    }
    return low;
}

/* The point of the ellipse with the largest torque within `most`, by a grid. */
static double torque_depth(const ellipse_t *e, double most)
{
    double best = 0.0;
    double found = 0.0;

    for (int k = 0; k <= GRID; k++) {
        const double y = most * k / GRID;
        const double x = e->emf - (e->along * y);
        const double rest = (e->flux * e->flux) - (x * x);
        const double torque =
            (rest > 0.0) ? ((e->emf + ((e->across - e->along) * y)) * sqrt(rest)) : 0.0;

        if (torque > best) {
            best = torque;
            found = y;
        }
    }
    return found;
}

/* ---- the ellipse ---- */

static void random_point(seeded_t *seed)
{
    const int32_t reactance = seeded_in(seed, 200, 20000);

    set_motor(seeded_in(seed, 2000, 20000), reactance,
              (int32_t)(reactance * (1.0 + (seeded_in(seed, 0, 150) / 100.0))));
    in.speed_q15 = seeded_in(seed, 4000, 32767);
    see_bus(seeded_in(seed, 6000, 20000));
    in.current_max = seeded_in(seed, 4000, CURRENT_END);
    in.reference = (dq_t){0, seeded_in(seed, -in.current_max, in.current_max)};
    in.deepest = CURRENT_END;
}

/*
 * Within the module's numbers: neither the EMF nor the voltages of the circle's current saturate.
 */
static bool is_plain(const ellipse_t *e)
{
    return (e->emf < 1.9) && (e->across < 1.9) && (e->along > (20.0 * VOLT_LSB));
}

TEST(test_upper_lies_on_the_ellipse_of_any_motor)
{
    seeded_t seed = {0xE111U};
    uint32_t judged = 0U;

    for (uint32_t k = 0U; k < MOTORS; k++) {
        random_point(&seed);
        const ellipse_t e = ellipse_of_in();
        const double x = e.across * abs(in.reference.q) / in.current_max;
        const double d = (sqrt(fmax((e.flux * e.flux) - (x * x), 0.0)) - e.emf) / e.along;
        const weakening_limits_t now = limits();

        if (is_plain(&e) && (fabs(d) < 1.0) && (x < (0.9 * e.flux)) && (now.upper > now.lower)) {
            /* The root's slope is at most x/√(E² − x²) = 2.1 there. */
            const double tolerance =
                (VOLT_ROUNDINGS * (1.0 + 2.1) * VOLT_LSB / e.along) + SHARE_ROUNDINGS;

            TEST_ASSERT_DOUBLE_WITHIN(tolerance, d, (double)now.upper / in.current_max);
            judged++;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(MOTORS / 20U, judged);
}

/* ---- the deepest useful i_d ---- */

TEST(test_it_ends_where_the_circle_meets_the_ellipse_or_at_the_most_torque_per_volt)
{
    seeded_t seed = {0xC1C1U};
    uint32_t circles = 0U;
    uint32_t torques = 0U;

    for (uint32_t k = 0U; k < (MOTORS / 10U); k++) {
        random_point(&seed);
        const ellipse_t e = ellipse_of_in();
        const double circle = circle_depth(&e);

        if (is_plain(&e) && (circle < 1.0)) {
            const weakening_limits_t now = limits();
            const double depth = -(double)now.lower / in.current_max;
            const double tolerance = (2.0 * VOLT_ROUNDINGS * VOLT_LSB / e.along) + SHARE_ROUNDINGS;

            if (now.reach == CURRENT_END) {
                TEST_ASSERT_DOUBLE_WITHIN(tolerance, circle, depth);
                circles++;
            } else {
                TEST_ASSERT_DOUBLE_WITHIN(tolerance + (1.0 / GRID), torque_depth(&e, 1.0), depth);
                TEST_ASSERT_TRUE(depth <= (circle + tolerance));
                torques++;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(100U, circles);
    TEST_ASSERT_GREATER_THAN_UINT32(20U, torques);
}

TEST(test_a_speed_that_no_current_reaches_leaves_no_torque)
{
    in.speed_q15 = 32767;
    see_bus(6000);
    in.deepest = 8000;
    assert_limits(-8000, -8000, 0, limits());
}

TEST(test_a_speed_within_the_circle_asks_for_nothing)
{
    in.speed_q15 = 8000;
    TEST_ASSERT_EQUAL_INT32(0, limits().lower);
    TEST_ASSERT_EQUAL_INT32(CURRENT_END, limits().reach);
    TEST_ASSERT_GREATER_THAN_INT32(0, limits().upper);
}

TEST(test_without_weakening_i_q_ends_on_the_ellipse)
{
    in.deepest = 0;
    in.speed_q15 = 12000;
    TEST_ASSERT_EQUAL_INT32(0, limits().lower);
    /*
     * √(12650² − 12000²) over X = 0.732; the root of a difference of 5 % has 20 roundings of a
     * voltage
     */
    TEST_ASSERT_INT32_WITHIN(40, 5466, limits().reach);
}

/*
 * R·(i·v)/|v|: what drives takes of the voltage, what brakes gives. i* decides, not what follows it
 * with the current control's lag.
 */
TEST(test_the_resistance_takes_what_it_takes_along_the_voltage)
{
    const int32_t without = limits().upper;

    model.resistance_q13 = 819; /* 0.1 of U_b/I_b */
    in.current = (dq_t){0, 4000};
    TEST_ASSERT_EQUAL_INT32(without, limits().upper);
    in.reference = (dq_t){-4000, 0};
    TEST_ASSERT_EQUAL_INT32(without, limits().upper);
    model.reactance_q_q13 = 0;
    in.reference = (dq_t){0, 4000};
    TEST_ASSERT_INT32_WITHIN(8, without - 400, limits().upper);
    in.reference = (dq_t){0, -4000};
    TEST_ASSERT_INT32_WITHIN(8, without + 400, limits().upper);
}

/*
 * Circle and ellipse meet at (16384² + 10000² − E²) / (2 · 16384), with E = 12650 and 400 less or
 * more.
 */
TEST(test_the_deepest_i_d_takes_the_resistance_of_the_current_that_flows)
{
    model.resistance_q13 = 819;
    TEST_ASSERT_INT32_WITHIN(8, -6360, limits().lower);
    in.current = (dq_t){0, 4000};
    TEST_ASSERT_INT32_WITHIN(8, -6664, limits().lower);
    in.current = (dq_t){0, -4000};
    TEST_ASSERT_INT32_WITHIN(8, -6047, limits().lower);
}

/*
 * √(12650² − (16384 − 5000)²). An i_q* that the voltage does not allow is only asked for: its R·i
 * would leave nothing of the ellipse.
 */
TEST(test_the_magnets_end_it_and_i_q_stays_on_the_ellipse_there)
{
    in.deepest = 5000;
    for (int k = 0; k < 2; k++) {
        TEST_ASSERT_EQUAL_INT32(-5000, limits().lower);
        TEST_ASSERT_INT32_WITHIN(8, 5516, limits().reach);
        model.resistance_q13 = 8191; /* 1 of U_b/I_b: more than E at this i_q* */
        in.reference = (dq_t){0, 13000};
    }
}

/* ---- to the last digit: voltages Q14 of U_b, I = 16384 ---- */

/* E of this size: a bus of 25300 without the reserve, or none, and the rest learned. */
static void set_flux(int32_t flux)
{
    const bool is_small = flux <= 4096;

    see_bus(is_small ? 0 : 25600);
    weakening.voltage = (2 * flux) - (is_small ? 0 : 25300);
}

/* ω·φ, E, X_d·I, X_q·I. ω = 1/2, so X = x_q13 / 2^14 and X·I = x_q13 / 2. */
static void set_volts(int32_t emf, int32_t flux, int32_t along, int32_t across)
{
    set_motor(emf, 2 * along, 2 * across);
    in.speed_q15 = 16384;
    in.current_max = CURRENT_END;
    in.deepest = CURRENT_END;
    set_flux(flux);
}

static void expect_upper(int32_t flux, int32_t upper)
{
    set_flux(flux);
    TEST_ASSERT_EQUAL_INT32(upper, limits().upper);
}

/* ω·φ and X·I are above 32000 of 16384, and count as that. */
static void set_saturated(void)
{
    set_motor(32767, 32767, 32767);
    in.speed_q15 = 32767;
    in.current_max = CURRENT_END;
    in.deepest = 16382;
}

TEST(test_the_emf_saturates_at_32000)
{
    set_saturated();
    expect_upper(16000, -8192); /* (16000 − 32000) / 32000 · 16384 */
    expect_upper(16001, -8191); /* 15999 · 0.512 = 8191.49 */
}

TEST(test_the_voltage_of_a_reactance_saturates_at_32000)
{
    set_saturated();
    /* 32000 − 32000 is left along: 100 and −31900 / 32000 · 16384 are 51.2 and −16332.8 */
    set_flux(100);
    assert_limits(-16382, -16332, 51, limits());
    model.emf_q13 = 0;
    expect_upper(16000, 8192); /* 16000 / 32000 · 16384 */
    expect_upper(15916, 8148); /* 15916 · 0.512 = 8148.99 */
}

TEST(test_a_voltage_that_is_left_over_without_a_reactance_is_all_of_the_current)
{
    set_volts(12650, 12650, 0, 0);
    TEST_ASSERT_EQUAL_INT32(0, weakening_step(&weakening, &in, 1).upper);
    in.current_max = 10000;
    expect_upper(12651, 10000);
    expect_upper(12649, -10000);
    set_volts(0, 16000, 10, 10);
    TEST_ASSERT_EQUAL_INT32(CURRENT_END, limits().upper);
}

/* R = 1. */
TEST(test_the_resistance_takes_along_the_voltage_what_there_is)
{
    static const struct {
        const char *name;
        int32_t emf;
        int32_t flux;
        int32_t across;
        dq_t voltage;
        dq_t current;
        int32_t upper;
    } cases[] = {
        /* (30 + 16)e6 / 1e4 = 4600 of 32768: (10000 − 2300 − 16000) / 16000 · 16384 = −8499.2 */
        {"both axes", 16000, 10000, 0, {-6000, 8000}, {-5000, 2000}, -8499},
        {"no voltage", 16000, 10000, 0, {0, 0}, {0, 4000}, -6143}, /* −6000 / 16000, in 15 bits */
        {"least voltage", 16000, 10000, 0, {0, 1}, {0, 4000}, -8191}, /* −8000 / 16000: 2000 less */
        {"more than there is", 8000, 1000, 16000, {12000, 0}, {4000, 0}, -8192}, /* 2000 of 1000 */
    };

    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        set_volts(cases[k].emf, cases[k].flux, 16000, cases[k].across);
        model.resistance_q13 = 8192;
        in.voltage = cases[k].voltage;
        in.reference = cases[k].current;
        in.current = cases[k].current;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(cases[k].upper, limits().upper, cases[k].name);
    }
}

/* √2 is 1: so i·v/|v| is 32768 here and not more, times R = 1/2. */
TEST(test_the_resistance_takes_at_most_its_voltage_at_a_whole_current)
{
    set_volts(0, 16000, 16384 / 2, 0);
    model.resistance_q13 = 4096;
    in.voltage = (dq_t){1, 1};
    in.reference = (dq_t){16384, 16384};
    weakening.voltage += 1; /* (32001 − 16384) / 2 = 7808 of 8192 */
    TEST_ASSERT_EQUAL_INT32(15616, limits().upper);
    set_volts(0, 0, 16000, 0);
    model.resistance_q13 = 4096;
    in.reference = (dq_t){-16384, -16384}; /* 8192 of 16000: 8388.6 */
    TEST_ASSERT_EQUAL_INT32(8388, limits().upper);
}

/* 8500 − 5000/2 = 6000 along leaves 8000 of 10000, over 16000. */
TEST(test_i_q_at_the_magnets_end_has_the_reactance_of_its_axis)
{
    set_volts(8500, 10000, 8192, 16000);
    in.deepest = 5000;
    TEST_ASSERT_EQUAL_INT32(8192, limits().reach);
}

/* c / (b + √(b² + a·c)) · 16384 in whole numbers. */
TEST(test_the_circle_meets_the_ellipse_or_ends_it_to_the_last_digit)
{
    static const struct {
        const char *name;
        int32_t emf;
        int32_t flux;
        int32_t along;
        int32_t across;
        int32_t lower;
    } cases[] = {
        {"1 / (1 + 1)", 1, 1, 1, 1, -8192},
        {"9 / 30", 5, 5, 3, 3, -4915},
        {"17500 / 80000: 16 bits, of which one goes", 200, 250, 200, 200, -3584},
        {"110000 / 160000: more than 15 bits", 400, 300, 200, 200, -11264},
        {"4e6 / (3e6 + √36e12) = 4 / 9: 7281.8", 2000, 3000, 1500, 3000, -7282},
        {"5.25e6 / (1.5e6 + √18e12): 14978.5", 1500, 1000, 1000, 2000, -14979},
        {"2.25e6 / 3e6", 1500, 1000, 1000, 1000, -12288},
        {"16383.97, of a share rounded to 1", 2500, 5, 2500, 2500, -CURRENT_END},
        {"no root: 1 / (1 + √(1 − 1))", 1, 0, 1, 0, -CURRENT_END},
        {"no root, 9 − 25: −φ / L_d is the deepest of use", 1, 0, 3, 2, -5461},
        {"neither magnets nor saliency", 0, 100, 200, 200, 0},
        {"no saliency: ω·φ / X_d = 5 / 20", 5, 18, 20, 20, -4096},
        {"L_q below L_d: the same", 5, 18, 20, 19, -4096},
        {"a circle that just fits asks for nothing", 0, 4096, 0, 4096, 0},
        {"neither voltage nor reactance: the current ends it", 0, 0, 0, 100, -CURRENT_END},
    };

    in.reference = (dq_t){0, 16384};
    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        set_volts(cases[k].emf, cases[k].flux, cases[k].along, cases[k].across);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(cases[k].lower, limits().lower, cases[k].name);
    }
}

/* ω·φ = 16000, E = 10000, X·I = 16000. */
static weakening_limits_t limits_of(int32_t deepest, int32_t wanted)
{
    set_volts(16000, 10000, 16000, 16000);
    in.deepest = deepest;
    return weakening_step(&weakening, &in, wanted);
}

/* −6000 / 16000 · 16384 */
TEST(test_it_decides_below_what_is_wanted_and_not_at_it)
{
    assert_limits(-CURRENT_END, -6144, CURRENT_END, limits_of(CURRENT_END, -6144));
    in.reference = (dq_t){-6144, 0};
    (void)limits_of(CURRENT_END, -6144);
    TEST_ASSERT_FALSE(weakening.acts);
    (void)limits_of(CURRENT_END, -6143);
    TEST_ASSERT_TRUE(weakening.acts);
}

/* At i_d of −8192 / 16384 the EMF is 8000: √(10000² − 8000²) / 16000 = 6144 / 16384. */
TEST(test_what_is_wanted_deeper_than_weakening_may_ask_for_stays_and_has_its_i_q)
{
    in.reference = (dq_t){-8192, 12000};
    assert_limits(-8192, -8192, 6144, limits_of(1000, -8192));
}

/* ---- near, and the integral ---- */

static bool is_near(int32_t d, int32_t q, int32_t radius)
{
    return weakening_follow_bus(&weakening, (dq_t){d, q}, radius);
}

TEST(test_it_is_near_above_fifteen_sixteenths_of_the_circle)
{
    see_bus(12000);
    TEST_ASSERT_FALSE(is_near(0, 11250, 12000));
    TEST_ASSERT_TRUE(is_near(0, -11251, 12000));
    see_bus(32767);
    TEST_ASSERT_TRUE(is_near(-32768, -32768, 32767));
}

/* Also where the demand falls, until i_d* is back at what all else wants. */
TEST(test_it_is_near_as_long_as_it_acts)
{
    (void)weakening_step(&weakening, &in, 0);
    TEST_ASSERT_TRUE(is_near(0, 0, 12800));
    in.speed_q15 = 8000;
    in.reference = (dq_t){-100, 0};
    (void)weakening_step(&weakening, &in, 0);
    TEST_ASSERT_TRUE(is_near(0, 0, 12800));
    in.reference = (dq_t){0, 0};
    (void)weakening_step(&weakening, &in, 0);
    TEST_ASSERT_FALSE(is_near(0, 0, 12800));
}

static void expect_learned(int32_t voltage_q, int32_t learned)
{
    in.voltage = (dq_t){0, voltage_q};
    (void)weakening_step(&weakening, &in, 0);
    TEST_ASSERT_EQUAL_INT32(learned, weakening.voltage);
}

TEST(test_a_lack_of_voltage_lowers_i_d_and_a_rest_raises_it)
{
    expect_learned(12800, -19); /* 150 above E */
    expect_learned(12600, -19 + 6);
}

/* What a kick of some slow periods winds up is gone in as many. */
TEST(test_the_integral_moves_by_32_a_slow_period_to_a_quarter_of_the_circle_on_both_sides)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        setUp();
        for (int32_t k = 1; k <= 150; k++) {
            in.voltage = (dq_t){0, (sign > 0) ? 1000 : 32000};
            (void)weakening_step(&weakening, &in, CURRENT_END);
            TEST_ASSERT_EQUAL_INT32(sign * fx_min(k * 32, 3200), weakening.voltage);
        }
    }
}

TEST(test_at_the_deepest_i_d_a_rest_alone_is_learned_from_its_first_step_on)
{
    in.deepest = 3000;
    expect_learned(12800, 0);
    expect_learned(12650 - 8, 1);
    expect_learned(12650 - 16, 3);
}

/* i_d* would stay as deep as a voltage asks for that is not there. */
TEST(test_at_the_deepest_i_d_a_lack_takes_back_what_was_added_and_no_more)
{
    in.deepest = 3000;
    expect_learned(12650 - 24, 3);
    for (int32_t left = 2; left >= -1; left--) {
        expect_learned(12650 + 1, fx_max(left, 0)); /* rounded down to a lack of 1 */
    }
}

TEST(test_what_was_learned_is_forgotten_where_the_voltage_does_not_decide)
{
    weakening.voltage = -8192;
    for (int k = 0; k < 102; k++) {
        (void)is_near(0, 0, 12800);
    }
    TEST_ASSERT_EQUAL_INT32(-8192 + (102 * 80), weakening.voltage);
    for (int last = -1; last <= 1; last++) { /* and of what is left the last digit on either side */
        (void)is_near(0, 0, 12800);
        TEST_ASSERT_EQUAL_INT32(0, weakening.voltage);
        weakening.voltage = (last == 0) ? -1 : 1;
    }
    weakening.voltage = 100;
    weakening_step(&weakening, &in, -CURRENT_END);
    TEST_ASSERT_EQUAL_INT32(20, weakening.voltage);
}

/* The valley counts at once, and fades with a sixty-fourth a slow period. */
TEST(test_the_lowest_bus_of_late_counts)
{
    const int32_t before = limits().upper;

    (void)is_near(0, 0, 12000);
    const int32_t valley = limits().upper;

    TEST_ASSERT_INT32_WITHIN(4, before - (800 - 10), valley);
    (void)is_near(0, 0, 12800);
    TEST_ASSERT_EQUAL_INT32(12012, weakening.valley);
    for (int k = 0; k < 500; k++) {
        (void)is_near(0, 0, 12800);
    }
    TEST_ASSERT_INT32_WITHIN(65, before, limits().upper); /* what rounding leaves, 63 of Q15 */
}

TEST(test_the_first_bus_counts_as_it_is)
{
    weakening_reset(&weakening);
    TEST_ASSERT_EQUAL_INT32(32767, weakening.valley);
    (void)is_near(0, 0, 32767);
    TEST_ASSERT_EQUAL_INT32(32767, weakening.valley);
}

static void step_often(void)
{
    for (int32_t k = 0; k < 50; k++) {
        in.voltage.q = 12000 + (50 * k);
        (void)weakening_follow_bus(&weakening, in.voltage, 12800 - (20 * (k % 7)));
        (void)weakening_step(&weakening, &in, (k < 49) ? CURRENT_END : -CURRENT_END);
    }
}

TEST(test_each_flip_of_voltage_and_valley_is_seen_and_stays_seen)
{
    uint8_t *const bytes = (uint8_t *)&weakening;

    step_often();
    TEST_ASSERT_TRUE(weakening.voltage != 0);
    TEST_ASSERT_TRUE(weakening_holds(&weakening));
    for (uint32_t bit = 0U; bit < (8U * offsetof(weakening_t, acts)); bit++) {
        setUp();
        step_often();
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_FALSE(weakening_holds(&weakening));
        if ((bit % 32U) != 31U) { /* else the distance is no word: a core wraps, C leaves it open */
            (void)weakening_follow_bus(&weakening, (dq_t){0, 0}, 12800);
            TEST_ASSERT_FALSE(weakening_holds(&weakening));
        }
    }
    weakening_reset(&weakening);
    TEST_ASSERT_TRUE(weakening_holds(&weakening));
}
