/* SPDX-License-Identifier: MIT */
/* Modulator: the reciprocal of the bus voltage, the ratio, the three duties. */
#include "example_cfg.h"
#include "figure.h"
#include "modulator.h"
#include "testing.h"
#include "two_axes.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define ONE (32768.0)
#define TWO_PI (6.283185307179586)
#define HALF_SQRT3 (0.8660254037844386)

/*
 * Settled reciprocal, relative to 1/bus: a residue 1 − r·bus below 1/4096 is rounded down to 0, and
 * half an LSB of r ≥ 4096 from rounding the product. Documented is 2^-11 for any bus above 1/8,
 * after 8 ticks.
 */
#define SETTLED (1.5 / 4096.0)
#define SETTLED_DOCUMENTED (2.0 / 4096.0)

/*
 * Left of a bus step by the share x, besides x², relative to 1/bus: the settled error of 1.5/4096
 * carried over by 2x ≤ 0.4, the residue rounded down to 1/4096, the product rounded by ½ LSB.
 */
#define STEP_MARGIN ((0.6 + 1.0 + 0.5) / 4096.0)

/*
 * Phase-to-phase voltage in Q15 of the bus. β·√3/2 rounded down 1, its constant 0.1 (28377.9 as
 * 28378); α/2 rounded down 0.5. b − c holds β·√3/2 twice: 2.2; the others once and α/2 once: 1.6.
 * At the limit radius 1/√3 that may exceed the bus by as much and is cut. Rounding to counts: ½ for
 * each phase.
 */
#define LINE_Q15 (2.2)
#define LINE_COUNTS(timer) ((2.0 * LINE_Q15 * (timer) / ONE) + 1.0)

static modulator_cfg_t cfg;
static modulator_t mod;

void setUp(void)
{
    cfg = example_modulator_cfg();
    modulator_reset(&mod, &cfg);
}

/* Configured, and in force. */
static void set_dead_time(int32_t dead_time_q15)
{
    cfg.dead_time_q15 = dead_time_q15;
    mod.dead_time_q15 = dead_time_q15;
}

static compare_t compare_with(ab_t ratio, ab_t current)
{
    compare_t out;

    modulator_compare_compensated(&mod, &cfg, ratio, current, &out);
    return out;
}

static compare_t compare_without_current(ab_t ratio)
{
    return compare_with(ratio, (ab_t){0, 0});
}

/* Error of the reciprocal relative to 1/bus. */
static double inverse_error(int32_t bus)
{
    return fabs((mod.inverse_bus_q12 * (double)bus / (ONE * 4096.0)) - 1.0);
}

static void track(int32_t bus, int32_t ticks)
{
    for (int32_t k = 0; k < ticks; k++) {
        modulator_track_bus(&mod, bus);
    }
}

/* Eight ticks from the reset on. */
static void settle(int32_t bus)
{
    modulator_reset(&mod, &cfg);
    track(bus, 8);
}

TEST(test_reset_starts_at_the_lower_bound_and_with_the_configured_dead_time)
{
    TEST_ASSERT_EQUAL_INT32(4096, mod.inverse_bus_q12);
    TEST_ASSERT_EQUAL_INT32(cfg.dead_time_q15, mod.dead_time_q15);
}

/* ---- the dead time by a measurement ---- */

static void correct_at(int32_t bus, int32_t lost)
{
    settle(bus);
    (void)modulator_correct(&mod, &cfg, lost);
}

/*
 * The reciprocal is within 2 LSB of 2^-12 of 1, lost and the ratio are rounded down by 1 each, ¾ of
 * it by 1.
 */
#define CORRECTED_TOLERANCE(change) ((abs(change) * 2.0 / 4096.0) + 3.0)

/*
 * A vector along phase a: legs b and c have half of its current, each loses Δt_d/T·u_bus: 4/3 of it
 * together.
 */
TEST(test_dead_time_in_force_grows_by_three_quarters_of_the_lost_share_of_the_bus)
{
    cfg.dead_time_q15 = 600;
    cfg.dead_time_band_q15 = 4096;
    for (int32_t bus = 8000; bus <= 32000; bus += 6000) {
        for (int32_t change = -400; change <= 400; change += 100) {
            const double lost = 4.0 / 3.0 * change / ONE * bus;

            correct_at(bus, (int32_t)lround(lost));
            TEST_ASSERT_DOUBLE_WITHIN(CORRECTED_TOLERANCE(change), 600 + change, mod.dead_time_q15);
        }
    }
}

/* u_bus = U_b: the change is ¾ of the voltage, rounded down; 640/64 = 10. */
TEST(test_a_change_of_exactly_one_64th_is_none_and_one_more_is_taken)
{
    cfg.dead_time_q15 = 640;
    cfg.dead_time_band_q15 = 4096;
    modulator_reset(&mod, &cfg);
    mod.inverse_bus_q12 = 4096;
    TEST_ASSERT_EQUAL_INT32(0, modulator_correct(&mod, &cfg, 14));
    TEST_ASSERT_EQUAL_INT32(0, modulator_correct(&mod, &cfg, -13));
    TEST_ASSERT_EQUAL_INT32(640, mod.dead_time_q15);
    TEST_ASSERT_EQUAL_INT32(11, modulator_correct(&mod, &cfg, 15));
    TEST_ASSERT_EQUAL_INT32(11, modulator_correct(&mod, &cfg, 15));
    TEST_ASSERT_EQUAL_INT32(662, mod.dead_time_q15); /* the second corrects what the first left */
    TEST_ASSERT_EQUAL_INT32(-11, modulator_correct(&mod, &cfg, -14));
    TEST_ASSERT_EQUAL_INT32(651, mod.dead_time_q15);
}

TEST(test_correction_of_the_dead_time_stays_within_its_band)
{
    static const struct {
        const char *name;
        int32_t band;
        int32_t bus;
        int32_t lost;
        int32_t in_force;
    } cases[] = {
        {"upper end", 150, 20000, 16384, 750}, {"upper end at a low bus", 150, 4097, 16384, 750},
        {"lower end", 150, 4097, -16384, 450}, {"nothing is below zero", 4096, 4097, -16384, 0},
        {"no band", 0, 20000, 5000, 600},
    };

    cfg.dead_time_q15 = 600;
    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        cfg.dead_time_band_q15 = cases[k].band;
        correct_at(cases[k].bus, cases[k].lost);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(cases[k].in_force, mod.dead_time_q15, cases[k].name);
    }
}

TEST(test_the_dead_time_in_force_is_what_is_compensated)
{
    const ab_t current = {16000, 0};
    int32_t before;

    cfg.dead_time_q15 = 400;
    cfg.dead_time_band_q15 = 400;
    correct_at(32000, 4000); /* in force: 800 */
    before = compare_with((ab_t){0, 0}, current).phase[0];
    cfg.dead_time_q15 = 8192;
    TEST_ASSERT_EQUAL_INT32(before, compare_with((ab_t){0, 0}, current).phase[0]);
    TEST_ASSERT_INT32_WITHIN(1, (800 * cfg.timer_counts) / 32768, before - (cfg.timer_counts / 2));
}

TEST(test_reciprocal_has_settled_after_eight_ticks_for_every_bus_above_an_eighth)
{
    double worst = 0.0;

    for (int32_t bus = 4097; bus <= 32767; bus++) {
        settle(bus);
        worst = fmax(worst, inverse_error(bus));
        for (int32_t k = 0; ((bus % 97) == 0) && (k < 200); k++) { /* and stays so */
            track(bus, 1);
            worst = fmax(worst, inverse_error(bus));
        }
    }
    TEST_ASSERT_TRUE(SETTLED <= SETTLED_DOCUMENTED);
    figure_check("reciprocal after 8 ticks, relative", worst, SETTLED, 0.4);
}

TEST(test_bus_step_leaves_its_square_for_one_tick)
{
    double worst = 0.0;

    for (int32_t percent = -20; percent <= 20; percent++) {
        for (int32_t bus = 8000; bus <= 27000; bus += 500) {
            const double share = (double)percent / 100.0;
            const int32_t after = (int32_t)lround(bus * (1.0 + share));

            settle(bus);
            track(bus, 4);
            track(after, 1);
            worst = fmax(worst, inverse_error(after) - (share * share));
        }
    }
    figure_check("left of a bus step besides its square", worst, STEP_MARGIN, 0.2);
}

/* r·(2 − r·bus): products without a rest, half an LSB, which is rounded up, and the full bus. */
TEST(test_a_newton_step_is_exact_and_rounded_to_nearest)
{
    static const int32_t before[] = {8192, 8192, 6144, 6144, 4096};
    static const int32_t buses[] = {20000, 12768, 20000, 20016, 32767};
    static const double exact[] = {6384.0, 10000.0, 6663.0, 6658.5, 4096.125};

    for (uint32_t i = 0U; i < 5U; i++) {
        const double r = before[i] / 4096.0;

        TEST_ASSERT_EQUAL_DOUBLE(exact[i], 4096.0 * r * (2.0 - (r * buses[i] / ONE)));
        mod.inverse_bus_q12 = before[i];
        modulator_track_bus(&mod, buses[i]);
        TEST_ASSERT_EQUAL_INT32((int32_t)floor(exact[i] + 0.5), mod.inverse_bus_q12);
    }
}

TEST(test_reciprocal_of_a_missing_bus_rests_at_its_upper_bound_and_comes_back)
{
    for (int32_t bus = 0; bus <= 3640; bus += 520) { /* below 1/9 of U_b */
        modulator_reset(&mod, &cfg);
        track(bus, 30);
        TEST_ASSERT_EQUAL_INT32(MODULATOR_INVERSE_MAX_Q12, mod.inverse_bus_q12);
        track(22572, 8);
        TEST_ASSERT_TRUE(inverse_error(22572) <= SETTLED);
    }
}

TEST(test_reciprocal_stays_in_range_for_any_sequence_of_buses)
{
    seeded_t seed = {0xB055U};

    for (int32_t k = 0; k < 200000; k++) {
        const int32_t choice = seeded_in(&seed, 0, 3);
        const int32_t bus = (choice < 2) ? (choice * 32767) : seeded_in(&seed, 0, 32767);

        modulator_track_bus(&mod, bus);
        TEST_ASSERT_TRUE((mod.inverse_bus_q12 >= 4096) &&
                         (mod.inverse_bus_q12 <= MODULATOR_INVERSE_MAX_Q12));
    }
}

TEST(test_limit_is_the_largest_ratio_of_the_bus_rounded_down)
{
    TEST_ASSERT_EQUAL_INT32(0, modulator_limit(&cfg, 0));
    TEST_ASSERT_EQUAL_INT32(17971, modulator_limit(&cfg, 32767));
    TEST_ASSERT_EQUAL_INT32(8986, modulator_limit(&cfg, 16384));
    TEST_ASSERT_EQUAL_INT32(0, modulator_limit(&cfg, 1));
}

TEST(test_ratio_is_the_voltage_over_the_bus_rounded_down_and_saturates_to_16_bits)
{
    static const struct {
        int32_t inverse_q12;
        dq_t voltage;
        dq_t ratio;
    } rows[] = {
        {6144, {10000, -10000}, {15000, -15000}}, /* bus = 2/3 */
        {6144, {1, -1}, {1, -2}},
        /* A bus of ½ doubles: the last voltages inside, the first ones beyond. */
        {8192, {16383, -16383}, {32766, -32766}},
        {8192, {-16383, 16383}, {-32766, 32766}},
        {8192, {16384, -16384}, {32767, -32768}},
        {8192, {-16384, 16384}, {-32768, 32767}},
        {8192, {32767, -16385}, {32767, -32768}},
        {8192, {-32767, 32767}, {-32768, 32767}},
        {32767, {32767, -32767}, {32767, -32768}},
        {4096, {32767, -32767}, {32767, -32767}},
    };

    for (uint32_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        mod.inverse_bus_q12 = rows[i].inverse_q12;
        assert_dq(rows[i].ratio.d, rows[i].ratio.q, modulator_ratio(&mod, rows[i].voltage));
    }
}

/*
 * Along α: a = 0.3, b = c = −0.15; common −(0.3 − 0.15)/2: duties 0.725 and 0.275.
 * Along β: b = −c = 0.2598.
 * Counts are rounded to nearest, ties up. Duty saturates at 32767/32768: up to 16384 counts that is
 * less than half a count below the end.
 */
TEST(test_a_vector_raises_its_phases_against_the_others_up_to_duty_one)
{
    static const struct {
        const char *name;
        int32_t timer;
        ab_t ratio;
        uint16_t counts[3];
        uint16_t tolerance;
    } cases[] = {
        {"null", 8500, {0, 0}, {4250U, 4250U, 4250U}, 0U},
        {"along alpha", 8500, {9830, 0}, {6162U, 2338U, 2338U}, 1U},
        {"along beta", 8500, {0, 9830}, {4250U, 6458U, 2042U}, 1U},
        {"too long along alpha", 8500, {32767, 0}, {8500U, 0U, 0U}, 0U},
        {"too long against alpha", 8500, {-32767, 0}, {0U, 8500U, 8500U}, 0U},
        {"too long along beta", 8500, {0, 32767}, {4250U, 8500U, 0U}, 0U},
        {"too long against beta", 8500, {0, -32767}, {4250U, 0U, 8500U}, 0U},
        {"too long, least timer", 1, {32767, 0}, {1U, 0U, 0U}, 0U},
        {"too long, short timer", 100, {32767, 0}, {100U, 0U, 0U}, 0U},
        {"too long, last full timer", 16384, {32767, 0}, {16384U, 0U, 0U}, 0U},
        {"too long, first timer that is not full", 16385, {32767, 0}, {16384U, 0U, 0U}, 0U},
        {"too long, largest timer", 32767, {32767, 0}, {32766U, 0U, 0U}, 0U},
        {"half a count is rounded up", 1, {0, 0}, {1U, 1U, 1U}, 0U},
        {"less than half a count down", 1, {0, 2}, {1U, 1U, 0U}, 0U},
    };

    for (uint32_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        compare_t c;

        cfg.timer_counts = cases[i].timer;
        c = compare_without_current(cases[i].ratio);
        for (uint32_t p = 0U; p < 3U; p++) {
            TEST_ASSERT_UINT16_WITHIN_MESSAGE(cases[i].tolerance, cases[i].counts[p], c.phase[p],
                                              cases[i].name);
        }
        TEST_ASSERT_TRUE((cases[i].ratio.beta != 0) || (c.phase[1] == c.phase[2]));
    }
}

/* Towards zero: the vector stays within the circle that the limit allows. */
static ab_t on_circle(int32_t radius, double share_of_turn)
{
    const double angle = TWO_PI * share_of_turn;

    return (ab_t){(int32_t)trunc(radius * cos(angle)), (int32_t)trunc(radius * sin(angle))};
}

/* Largest deviation of a phase-to-phase voltage from the demand, in counts. */
static double line_error(ab_t ratio)
{
    const compare_t c = compare_without_current(ratio);
    const double scale = cfg.timer_counts / ONE;
    const double a = ratio.alpha * scale;
    const double b = ((HALF_SQRT3 * ratio.beta) - (0.5 * ratio.alpha)) * scale;
    const double d = ((-HALF_SQRT3 * ratio.beta) - (0.5 * ratio.alpha)) * scale;
    const double ab = fabs((double)c.phase[0] - c.phase[1] - (a - b));
    const double bc = fabs((double)c.phase[1] - c.phase[2] - (b - d));
    const double ca = fabs((double)c.phase[2] - c.phase[0] - (d - a));

    return fmax(ab, fmax(bc, ca));
}

TEST(test_phase_to_phase_voltages_equal_the_demand_in_all_directions)
{
    static const int32_t timers[] = {100, 8500, 32767};
    static const int32_t radii[] = {18918, 17972, 9000, 100};

    for (uint32_t t = 0U; t < 3U; t++) {
        double worst = 0.0;

        cfg.timer_counts = timers[t];
        for (int32_t k = 0; k < 32768; k++) {
            worst = fmax(worst, line_error(on_circle(radii[k % 4], k / 32768.0)));
        }
        figure_check("phase-to-phase error, counts", worst, LINE_COUNTS(timers[t]), 0.4);
    }
}

TEST(test_duties_are_symmetric_about_one_half)
{
    for (int32_t k = 0; k < 4096; k++) {
        const compare_t c = compare_without_current(on_circle(18918, k / 4096.0));
        const int32_t highest = fx_max(fx_max(c.phase[0], c.phase[1]), c.phase[2]);
        const int32_t lowest = fx_min(fx_min(c.phase[0], c.phase[1]), c.phase[2]);

        /* Half the sum rounded down: up to 1 LSB of Q15 = 0.26 counts; two roundings to counts. */
        TEST_ASSERT_INT32_WITHIN(1, cfg.timer_counts, highest + lowest);
    }
}

/* ---- dead time and device drop ---- */

#define BUS_310V (22573)

/*
 * What 2 µs and 1.2 V take from a leg at 310 V, in Q15: 655.4 and 126.8 less 0.7 for two roundings
 * down.
 */
#define LOSS_Q15 (781)
/* Of the current, from none to all of it: 32768/512 = 64, and one for the rounding. */
#define EDGE_LSB (65)
/*
 * The share ends at 32767/32768 and the product is rounded down, 1; counts of 1/32767 are rounded,
 * 1.
 */
#define SHARE_LSB (2)

/* Timer of 32767 counts: a count is a LSB of the duty. */
static void use_dead_time(void)
{
    cfg = example_modulator_cfg_with_dead_time();
    cfg.timer_counts = 32767;
    settle(BUS_310V);
}

TEST(test_either_dead_time_or_drop_asks_for_the_current)
{
    for (int32_t i = 0; i < 4; i++) {
        set_dead_time(i % 2);
        cfg.drop_q15 = i / 2;
        TEST_ASSERT_EQUAL(i != 0, modulator_compensates(&cfg));
    }
}

/* By how many counts the current changes the compare value of a phase. */
static int32_t given_back(ab_t ratio, ab_t current, uint32_t phase)
{
    return (int32_t)compare_with(ratio, current).phase[phase] -
           (int32_t)compare_without_current(ratio).phase[phase];
}

/* To leg a, with a current along it. */
static int32_t given_back_to_a(ab_t ratio, int32_t current)
{
    return given_back(ratio, (ab_t){current, 0}, 0U);
}

/* A phase current of the vector, as a real number. */
static double phase_current(ab_t current, uint32_t phase)
{
    static const double beta_part[] = {0.0, HALF_SQRT3, -HALF_SQRT3};

    return ((phase == 0U) ? (double)current.alpha : (-0.5 * current.alpha)) +
           (beta_part[phase] * current.beta);
}

/* A phase current is rounded down by up to 2 LSB: one more below zero. */
TEST(test_full_loss_is_given_back_to_each_leg_in_the_direction_of_its_current)
{
    use_dead_time();
    for (int32_t k = 0; k < 720; k++) {
        const ab_t current = on_circle(3000, k / 720.0);

        for (uint32_t p = 0U; p < 3U; p++) {
            const double i = phase_current(current, p);

            if (fabs(i) > (EDGE_LSB + 2)) {
                TEST_ASSERT_INT32_WITHIN(SHARE_LSB, (i > 0.0) ? LOSS_Q15 : -LOSS_Q15,
                                         given_back((ab_t){0, 0}, current, p));
            }
        }
    }
}

TEST(test_drop_weighs_more_on_a_lower_bus_and_dead_time_does_not)
{
    static const int32_t inverses[] = {4096, 6144, 8192};
    const ab_t null = {0, 0};

    use_dead_time();
    for (uint32_t i = 0U; i < 3U; i++) {
        mod.inverse_bus_q12 = inverses[i];
        set_dead_time(0);
        cfg.drop_q15 = 1000;
        TEST_ASSERT_INT32_WITHIN(SHARE_LSB, 1000 * inverses[i] / 4096, given_back_to_a(null, 3000));
        set_dead_time(1000);
        cfg.drop_q15 = 0;
        TEST_ASSERT_INT32_WITHIN(SHARE_LSB, 1000, given_back_to_a(null, 3000));
    }
}

/*
 * A ratio along β leaves leg a in the middle, at u = 0: the ripple at its edges is ripple·s with
 * s = √3·β = 20784 (less 1 for rounding), 20784·2000/2^15 = 1268.5.
 */
TEST(test_nothing_is_given_back_within_the_ripple_and_everything_a_few_counts_above_it)
{
    const ab_t ratio = {0, 12000};

    use_dead_time();
    cfg.ripple_q15 = 2000;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        for (int32_t i = 0; i <= 1267; i++) {
            TEST_ASSERT_EQUAL_INT32(0, given_back_to_a(ratio, sign * i));
        }
        TEST_ASSERT_INT32_WITHIN(SHARE_LSB, sign * LOSS_Q15,
                                 given_back_to_a(ratio, sign * (1269 + EDGE_LSB)));
    }
    /* The highest and the lowest leg: 9·u² is more than s. */
    TEST_ASSERT_INT32_WITHIN(SHARE_LSB, -LOSS_Q15, given_back(ratio, (ab_t){200, 0}, 1U));
    TEST_ASSERT_INT32_WITHIN(SHARE_LSB, -LOSS_Q15, given_back(ratio, (ab_t){200, 0}, 2U));
}

/*
 * r = ripple·(s − 9·u²) of the leg in the middle, found as the current from which on something is
 * compensated. s holds three roundings down and 9·u² nine, 12·16384/2^15 = 6; the first LSB of duty
 * that shows takes 2·2^15/(819·781) < 1 of current more, and r is rounded down.
 */
#define RIPPLE_LSB (8.0)

TEST(test_ripple_follows_the_edges_of_the_leg_in_the_middle)
{
    use_dead_time();
    cfg.ripple_q15 = 16384;
    for (int32_t alpha = -2000; alpha <= 2000; alpha += 100) {
        const ab_t ratio = {alpha, 12000};
        const double u = alpha / ONE;
        const double span = sqrt(3.0) * 12000.0 / ONE;
        const double expected = 16384.0 * (span - (9.0 * u * u));
        int32_t first = 0;

        while ((first < 16384) && (given_back_to_a(ratio, first) == 0)) {
            first++;
        }
        TEST_ASSERT_DOUBLE_WITHIN(RIPPLE_LSB, expected, first);
    }
}

/*
 * A current is rounded down by up to 2 LSB: 2·512·781/2^15 = 24.4 of duty each, where the slope of
 * z·(2 − z) is largest. Two differences of rounded counts: 2. The share is rounded down: 1.
 */
#define SYMMETRY_LSB (52)

/* z·(2 − z) of the loss at z = ¼, ½ and ¾ of the edge of 64 LSB: 7/16, 3/4 and 15/16. */
TEST(test_a_small_current_is_given_back_as_much_as_a_leg_loses_that_commutates_softly)
{
    static const int32_t sixteenths[] = {-15, -12, -7, 0, 7, 12, 15};

    use_dead_time();
    cfg.ripple_q15 = 0;
    for (int32_t k = 0; k < 7; k++) {
        TEST_ASSERT_INT32_WITHIN(SYMMETRY_LSB, LOSS_Q15 * sixteenths[k] / 16,
                                 given_back_to_a((ab_t){0, 0}, 16 * (k - 3)));
    }
}

TEST(test_duty_goes_steadily_through_zero_current_without_a_jump)
{
    static const ab_t ratios[] = {{0, 0}, {0, 12000}, {9000, 0}, {-7000, 5000}};

    use_dead_time();
    for (uint32_t r = 0U; r < 4U; r++) {
        int32_t before = given_back_to_a(ratios[r], -300);

        TEST_ASSERT_INT32_WITHIN(SHARE_LSB, -LOSS_Q15, before);
        TEST_ASSERT_EQUAL_INT32(0, given_back_to_a(ratios[r], 0));
        for (int32_t i = -299; i <= 300; i++) {
            const int32_t now = given_back_to_a(ratios[r], i);

            TEST_ASSERT_TRUE((now >= before) && (now <= (before + 26)));
            before = now;
        }
        TEST_ASSERT_INT32_WITHIN(SHARE_LSB, LOSS_Q15, before);
    }
}

TEST(test_what_is_given_back_cannot_leave_duty_zero_to_one)
{
    static const compare_t ends = {{8500U, 0U, 0U}};
    compare_t c;

    use_dead_time();
    cfg.timer_counts = 8500;
    /* Duties 0.9921 and 0.0079 besides the loss of 0.0238. */
    c = compare_with((ab_t){21500, 0}, (ab_t){3000, 0});
    TEST_ASSERT_EQUAL_UINT16_ARRAY(ends.phase, c.phase, 3U);
}

/*
 * u = √2, beyond the format: a leg that far out has no edges, so no ripple holds back what it is
 * given. Its duty of 1.56 = √2 + ½ − (√2 − √½)/2 less the loss 2^-2 + 2^-4·8 of a current backwards
 * is below 1 again.
 */
TEST(test_a_leg_far_beyond_full_duty_is_given_back_all_within_the_ripple_of_others)
{
    const ab_t ratio = {46341, 0};
    const ab_t current = {-8192, 0};
    const double duty = sqrt(2.0) + 0.5 - ((sqrt(2.0) - sqrt(0.5)) / 2.0) - 0.25 - 0.5;

    cfg.timer_counts = 32767;
    set_dead_time(8192);
    cfg.drop_q15 = 2048;
    cfg.ripple_q15 = 16384;
    cfg.edge_slope = 32767;
    mod.inverse_bus_q12 = 32767;
    TEST_ASSERT_INT32_WITHIN(SHARE_LSB + 1, (int32_t)lround(duty * ONE),
                             compare_with(ratio, current).phase[0]);
}

/*
 * Both saturate in both axes, turned: √2. Half of the runs are at the ends, a quarter has no loss.
 */
TEST(test_duties_stay_between_zero_and_one_for_any_current_and_any_loss)
{
    seeded_t seed = {0xD07E6U};

    for (int32_t k = 0; k < 300000; k++) {
        const ab_t ratio = seeded_ab(&seed, 46341);
        const ab_t current = seeded_ab(&seed, 46341);
        const bool ends = (k % 2) == 0;
        const bool lossless = (k % 4) == 1;
        compare_t c;

        cfg.timer_counts = ends ? 32767 : seeded_in(&seed, 1, 32767);
        set_dead_time(ends ? 8192 : seeded_in(&seed, 0, lossless ? 0 : 8192));
        cfg.drop_q15 = ends ? 2048 : seeded_in(&seed, 0, lossless ? 0 : 2048);
        cfg.ripple_q15 = ends ? 16384 : seeded_in(&seed, 0, 16384);
        cfg.edge_slope = ends ? 32767 : seeded_in(&seed, 1, 32767);
        mod.inverse_bus_q12 = ends ? 32767 : seeded_in(&seed, 1, 32767);
        c = compare_with(ratio, current);
        for (int32_t p = 0; p < 3; p++) {
            TEST_ASSERT_TRUE(c.phase[p] <= cfg.timer_counts);
        }
    }
}

TEST(test_without_anything_to_give_back_both_ways_write_the_same_counts)
{
    seeded_t seed = {0xC0DEU};

    TEST_ASSERT_FALSE(modulator_compensates(&cfg));
    for (int32_t k = 0; k < 10000; k++) {
        const ab_t ratio = seeded_ab(&seed, 20000);
        const compare_t compensated = compare_with(ratio, seeded_ab(&seed, 46341));
        compare_t out;

        modulator_compare(&cfg, ratio, &out);
        TEST_ASSERT_EQUAL_UINT16_ARRAY(compensated.phase, out.phase, 3U);
    }
}

TEST(test_the_bus_goes_on_as_it_last_changed_rounded_down_to_zero_and_full_scale)
{
    static const int32_t before[] = {19900, 20100, 19999, 20001, 20000, 0, 32767};
    static const int32_t buses[] = {20000, 20000, 20000, 20000, 20000, 32767, 0};
    static const int32_t ahead[] = {20150, 19850, 20001, 19998, 20000, 32767, 0};

    for (uint32_t k = 0U; k < 7U; k++) {
        TEST_ASSERT_EQUAL_INT32(ahead[k], modulator_bus_ahead(before[k], buses[k]));
    }
}

/* By how much a measurement has corrected the dead time is kept, as far as the new band goes. */
TEST(test_the_correction_of_the_dead_time_stays_with_another_configuration)
{
    modulator_cfg_t other;

    set_dead_time(650);
    cfg.dead_time_band_q15 = 200;
    mod.dead_time_q15 = 500;
    other = cfg;
    other.dead_time_q15 = 690;
    modulator_change(&mod, &cfg, &other);
    TEST_ASSERT_EQUAL_INT32(540, mod.dead_time_q15);
    cfg = other;
    cfg.dead_time_band_q15 = 50;
    modulator_change(&mod, &other, &cfg);
    TEST_ASSERT_EQUAL_INT32(640, mod.dead_time_q15);
    other = cfg;
    other.dead_time_q15 = 20; /* less than nothing is compensated nowhere */
    modulator_change(&mod, &cfg, &other);
    TEST_ASSERT_EQUAL_INT32(0, mod.dead_time_q15);
}
