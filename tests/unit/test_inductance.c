/* SPDX-License-Identifier: MIT */
/*
 * L_d and L_q from a pulse and a step of the voltage: salient windings, a loaded rotor, any
 * response.
 */
#include "example_cfg.h"
#include "figure.h"
#include "inductance.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Motor A and the bases of example_cfg.h. */
#define PERIOD_S (1e-4)
#define RESISTANCE (2.125)
#define INDUCTANCE (0.0116)
#define CURRENT_LSB_A (40.0 / 32768.0)
#define VOLTAGE_LSB_V (450.0 / 32768.0)
#define RESISTANCE_Q13 (RESISTANCE * 40.0 / 450.0 * 8192.0)
#define CURRENT_A (8.0)
#define RAD_PER_DEG (3.14159265358979 / 180.0)
#define STEPS (200) /* of Euler's method in a tick */

static inductance_cfg_t cfg;
static inductance_t test;
static int32_t resistance_q13; /* of the words worked out by hand: 1.0 unless a test changes it */
static double worst_d;         /* as shares of their bounds */
static double worst_q;

void setUp(void)
{
    cfg = example_align_cfg().inductance;
    test = (inductance_t){.start_d = 0};
    resistance_q13 = 8192;
    worst_d = 0.0;
    worst_q = 0.0;
}

static uint32_t last_tick(void)
{
    return (4U * cfg.pulse_ticks) + 2U + cfg.step_ticks + 2U;
}

/* ---- the voltages ---- */

TEST(test_voltage_across_goes_one_way_twice_as_long_the_other_and_back_then_that_along_falls)
{
    int32_t across = 0;
    int32_t along = 0;
    int64_t area = 0;

    for (uint32_t tick = 0U; tick <= last_tick(); tick++) {
        const dq_t change = inductance_voltage(&cfg, tick);
        const uint32_t quarter = (tick + cfg.pulse_ticks - 1U) / cfg.pulse_ticks; /* 1…4 */
        const int32_t sign = ((quarter == 2U) || (quarter == 3U)) ? -1 : 1;
        const bool pulses = (quarter >= 1U) && (quarter <= 4U);

        across += change.q;
        along += change.d;
        area += across;
        TEST_ASSERT_EQUAL_INT32(pulses ? (sign * cfg.pulse_voltage) : 0, across);
        TEST_ASSERT_EQUAL_INT32((tick >= ((4U * cfg.pulse_ticks) + 3U)) ? -cfg.step_voltage : 0,
                                along);
    }
    TEST_ASSERT_EQUAL_INT64(0, area);
}

/* The last sample of a response is that two ticks after its voltage. */
TEST(test_control_pauses_until_the_step_has_been_demanded_for_its_ticks)
{
    const uint32_t end = (4U * cfg.pulse_ticks) + 2U + cfg.step_ticks;

    for (uint32_t tick = 0U; tick <= (2U * end); tick++) {
        TEST_ASSERT_EQUAL(tick <= end, inductance_holds_voltage(&cfg, tick));
        TEST_ASSERT_EQUAL(tick >= last_tick(),
                          inductance_step(&test, &cfg, tick, (dq_t){1000, -1000}));
    }
}

/* ---- windings ---- */

typedef struct {
    double resistance; /* as ratios to those of motor A, L_q/L_d as it is */
    double inductance;
    double saliency;
    double angle_deg; /* of the rotor before the vector */
    double lost_v;    /* taken from the voltage by the sign of i_q */
} winding_t;

typedef struct {
    double d;
    double q;
} vector_t;

static vector_t turned(vector_t v, double angle)
{
    return (vector_t){(v.d * cos(angle)) + (v.q * sin(angle)),
                      (v.q * cos(angle)) - (v.d * sin(angle))};
}

/*
 * One period, rotor at rest. L·di/dt = v − R·i in the frame of the rotor; i and v are in that of
 * the vector.
 */
static vector_t period(const winding_t *w, vector_t i, vector_t v)
{
    const double angle = w->angle_deg * RAD_PER_DEG;
    const double l_d = w->inductance * INDUCTANCE;
    const double l_q = l_d * w->saliency;
    const double r = w->resistance * RESISTANCE;
    const double h = PERIOD_S / STEPS;

    for (int32_t k = 0; k < STEPS; k++) {
        const double lost = (i.q > 0.0) ? w->lost_v : -w->lost_v;
        const vector_t left = {v.d - (r * i.d), v.q - lost - (r * i.q)};
        const vector_t rotor = turned(left, angle);
        const vector_t change = turned((vector_t){rotor.d / l_d, rotor.q / l_q}, -angle);

        i.d += h * change.d;
        i.q += h * change.q;
    }
    return i;
}

/* The converter has 12 bits, ±20 A: 8 LSB. */
static int32_t converted(double ampere)
{
    return (int32_t)lround(ampere / CURRENT_LSB_A / 8.0) * 8;
}

/* From the rest at CURRENT_A: what is demanded acts in the period after its own. */
static inductance_result_t measure(const winding_t *w)
{
    const double held_v = w->resistance * RESISTANCE * CURRENT_A;
    vector_t current = {CURRENT_A, 0.0};
    vector_t demanded = {held_v, 0.0};
    vector_t acting = demanded;
    bool done = false;

    test = (inductance_t){.start_d = 0};
    for (uint32_t tick = 1U; !done; tick++) {
        const dq_t sample = {converted(current.d), converted(current.q)};
        const dq_t change = inductance_voltage(&cfg, tick);

        done = inductance_step(&test, &cfg, tick, sample);
        demanded.d += change.d * VOLTAGE_LSB_V;
        demanded.q += change.q * VOLTAGE_LSB_V;
        current = period(w, current, acting);
        acting = demanded;
    }
    return inductance_result(&test, &cfg, (int32_t)lround(w->resistance * RESISTANCE_Q13));
}

/*
 * Half a count of the converter, 4 LSB, in each sample: ΔL_d/L_d from two samples of the fall. In
 * the pulse four samples count once, twice, twice and once. Euler's steps, and the trapezoid of
 * R·i: (R·T/L)²/12 of the share of R·i, below 0.1 %. Q14 and Q13 are exact to 0.02 %. An angle
 * mixes both, and the root of the cross response: the errors add.
 */
static void check(const winding_t *w)
{
    const inductance_result_t found = measure(w);
    const double fall = 2627.0 / w->inductance;
    const double swing = 7864.0 / (w->inductance * w->saliency);
    const double bound_d = (8.0 / fall) + 0.0012;
    const double bound_q = (24.0 / swing) + 0.0012;
    const double share = fabs(sin(w->angle_deg * RAD_PER_DEG));
    const double apart = fmax(w->saliency, 1.0 / w->saliency);
    const double mixed = share * apart * (bound_d + bound_q);
    const double d = found.ratio_q14 / 16384.0 / w->inductance;
    const double q = found.saliency_q13 / 8192.0 / w->saliency;

    worst_d = fmax(worst_d, fabs(d - 1.0) / (bound_d + mixed));
    worst_q = fmax(worst_q, fabs(q - 1.0) / (bound_d + bound_q + (2.0 * mixed)));
}

TEST(test_both_inductances_are_measured_whatever_the_resistance_and_the_saliency)
{
    static const double ratios[] = {0.6, 0.8, 1.0, 1.25, 1.4};
    static const double saliencies[] = {0.7, 1.0, 1.3, 2.0, 2.8};

    for (uint32_t k = 0U; k < 125U; k++) {
        const winding_t w = {.resistance = ratios[k % 5U],
                             .inductance = ratios[(k / 5U) % 5U],
                             .saliency = saliencies[k / 25U]};

        check(&w);
    }
    figure_check("L_d, as a share of its bound", worst_d, 1.0, 0.3);
    figure_check("L_q/L_d, as a share of its bound", worst_q, 1.0, 0.3);
}

TEST(test_a_loaded_rotor_off_the_vector_is_measured_in_its_own_axes)
{
    static const double saliencies[] = {0.7, 1.0, 1.3, 2.0};

    for (int32_t k = 0; k < 52; k++) {
        const int32_t step = (k / 4) - 6;
        const winding_t w = {.resistance = 1.3,
                             .inductance = 0.8,
                             .saliency = saliencies[k % 4],
                             .angle_deg = 5.0 * step};

        check(&w);
    }
    figure_check("L_d off the vector, as a share of its bound", worst_d, 1.0, 0.2);
    figure_check("L_q/L_d off the vector, as a share of its bound", worst_q, 1.0, 0.2);
}

/*
 * A gimbal motor's winding: 7 times the resistance, R·T/L = 0.13; the pulse does not reach its
 * height.
 */
TEST(test_a_winding_that_decays_within_the_pulse_is_measured)
{
    for (int32_t k = 0; k < 5; k++) {
        const winding_t w = {.resistance = 7.0, .inductance = 0.8 + (0.1 * k), .saliency = 1.1};

        check(&w);
    }
    figure_check("L_d of a decaying winding, as a share of its bound", worst_d, 1.0, 0.05);
    figure_check("L_q/L_d of a decaying winding, as a share of its bound", worst_q, 1.0, 0.05);
}

/* What goes with the sign of the current across cancels: 6 V of 93 V would be 6 %. */
TEST(test_voltage_lost_by_the_sign_of_the_current_across_costs_next_to_nothing)
{
    const winding_t without = {.resistance = 1.0, .inductance = 1.0, .saliency = 1.3};
    winding_t with = without;
    int32_t before;

    with.lost_v = 6.2;
    before = measure(&without).saliency_q13;
    TEST_ASSERT_INT32_WITHIN(before / 150, before, measure(&with).saliency_q13);
}

TEST(test_rotor_gets_no_momentum_and_the_current_across_comes_back)
{
    const winding_t w = {.resistance = 1.0, .inductance = 1.0, .saliency = 1.0};
    vector_t current = {CURRENT_A, 0.0};
    vector_t demanded = {RESISTANCE * CURRENT_A, 0.0};
    vector_t acting = demanded;
    double momentum = 0.0;
    double highest = 0.0;

    for (uint32_t tick = 1U; tick <= ((4U * cfg.pulse_ticks) + 2U); tick++) {
        const dq_t change = inductance_voltage(&cfg, tick);

        demanded.q += change.q * VOLTAGE_LSB_V;
        current = period(&w, current, acting);
        acting = demanded;
        momentum += current.q;
        highest = fmax(highest, fabs(current.q));
    }
    /* 0.3 of the current, less what R·i takes in three ticks and in six. */
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 2.4, 2.4, highest);
    /*
     * R·t/L of a quarter is 0.055: to first order both vanish, to second 0.055² of the height and
     * of its area are left.
     */
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * 0.055 * 0.055 * 2.4, 0.0, current.q);
    TEST_ASSERT_DOUBLE_WITHIN(0.055 * 2.4 * 6.0, 0.0, momentum);
}

TEST(test_current_along_counts_from_the_sample_where_the_voltage_of_the_step_begins)
{
    for (uint32_t tick = 1U; tick <= last_tick(); tick++) {
        const bool before = tick <= ((4U * cfg.pulse_ticks) + 3U);

        (void)inductance_step(&test, &cfg, tick, (dq_t){before ? 5000 : 1000, 0});
    }
    TEST_ASSERT_EQUAL_INT32(0, test.step.change.d);
    TEST_ASSERT_EQUAL_INT32(0, test.step.carried);
}

/* ---- responses that say nothing ---- */

static void assert_result(int32_t fall, dq_t across, int32_t ratio_q14, int32_t saliency_q13)
{
    inductance_result_t found;

    test.step.change.d = fall;
    test.pulse.change = across;
    found = inductance_result(&test, &cfg, resistance_q13);
    TEST_ASSERT_EQUAL_INT32(ratio_q14, found.ratio_q14);
    TEST_ASSERT_EQUAL_INT32(saliency_q13, found.saliency_q13);
}

TEST(test_without_a_fall_along_the_current_nothing_is_known)
{
    for (int32_t fall = -100000; fall <= 0; fall += 50000) {
        assert_result(fall, (dq_t){0, cfg.pulse_response}, INDUCTANCE_UNKNOWN, INDUCTANCE_UNKNOWN);
    }
}

TEST(test_without_a_response_across_the_inductance_along_the_current_is_known)
{
    for (int32_t change = -100000; change <= 0; change += 50000) {
        assert_result(cfg.step_response, (dq_t){0, change}, 16384, INDUCTANCE_UNKNOWN);
    }
}

/* The root is longer than the sum: one of the inductances would be negative. */
TEST(test_a_cross_response_that_no_winding_has_leaves_the_saliency_unknown)
{
    test.step.change.d = cfg.step_response;
    test.pulse.change = (dq_t){cfg.pulse_response + 100, cfg.pulse_response};
    TEST_ASSERT_TRUE(inductance_result(&test, &cfg, 0).ratio_q14 > 0);
    TEST_ASSERT_EQUAL_INT32(INDUCTANCE_UNKNOWN, inductance_result(&test, &cfg, 0).saliency_q13);
}

/*
 * Twice the mean of 4 ticks, 8·5000: with R = 10904 it takes 5000·10904/8192 = 6655, the whole
 * step.
 */
TEST(test_when_the_resistance_takes_the_whole_voltage_nothing_is_known)
{
    test.step.change.d = cfg.step_response;
    test.step.carried = 8 * 5000;
    TEST_ASSERT_TRUE(inductance_result(&test, &cfg, 10800).ratio_q14 > 0);
    TEST_ASSERT_EQUAL_INT32(INDUCTANCE_UNKNOWN, inductance_result(&test, &cfg, 11000).ratio_q14);
}

TEST(test_results_end_at_15_bits)
{
    resistance_q13 = 0;
    assert_result(1, (dq_t){0, cfg.pulse_response}, 32767, 8192 / cfg.step_response);
    assert_result(cfg.step_response, (dq_t){0, 1}, 16384, 32767);
}

/* ---- words, worked out by hand ---- */

/*
 * A response with the voltage and the mean current of its ticks, Q15. What is expected is
 * response·(voltage − R·mean)/voltage.
 */
typedef struct {
    int32_t response;
    int32_t voltage;
    int32_t mean;
    dq_t change;
} response_t;

/* Expected 8192: a change is its element of B, Q13. */
static const response_t unit = {.response = 8192, .voltage = 1, .mean = 0};

static void check_words(response_t step, response_t pulse, int32_t ratio_q14, int32_t saliency_q13)
{
    const int32_t pulse_ticks = 4 * (int32_t)cfg.pulse_ticks;

    cfg.step_response = step.response;
    cfg.step_voltage = step.voltage;
    test.step.carried = 2 * (int32_t)cfg.step_ticks * step.mean;
    cfg.pulse_response = pulse.response;
    cfg.pulse_voltage = pulse.voltage;
    test.pulse.carried = 2 * pulse_ticks * pulse.mean;
    assert_result(step.change.d, pulse.change, ratio_q14, saliency_q13);
}

static void check_elements(int32_t dd, int32_t cross, int32_t qq, int32_t ratio_q14,
                           int32_t saliency_q13)
{
    response_t step = unit;
    response_t pulse = unit;

    step.change.d = dd;
    pulse.change = (dq_t){cross, qq};
    check_words(step, pulse, ratio_q14, saliency_q13);
}

TEST(test_axes_are_those_of_the_elements_to_the_last_word)
{
    check_elements(8192, 0, 8192, 16384, 8192);
    check_elements(8192, 0, 4096, 16384, 16384);
    check_elements(4096, 0, 8192, 32767, 4096);
    check_elements(8192, 2000, 8192, 13168, 13483);
    /* Sum 3, root √5: 2; the longer axis is the d axis only where d is not the smaller element. */
    check_elements(1, 1, 2, 32767, 1638);
    check_elements(2, 1, 1, 32767, 32767);
    /* Sum 4, root √20: 4; one of the two is left without a word. */
    check_elements(1, 2, 3, INDUCTANCE_UNKNOWN, INDUCTANCE_UNKNOWN);
    check_elements(3, 2, 1, 32767, INDUCTANCE_UNKNOWN);
    check_elements(8192, 8192, 0, 16384, INDUCTANCE_UNKNOWN);
    /* Below one step of its word. */
    check_elements(1, 71, 10000, 32767, 1);
}

TEST(test_elements_end_at_16_bits)
{
    check_elements(40000, 0, 32767, 4096, 8192);
    check_elements(8192, 20000, 8192, 5461, INDUCTANCE_UNKNOWN);
}

/* The same step, expected and found, with the ratio that it gives. */
static void check_step(response_t step, int32_t ratio_q14)
{
    check_words(step, unit, ratio_q14, INDUCTANCE_UNKNOWN);
}

TEST(test_what_is_expected_follows_the_voltage_that_the_resistance_leaves)
{
    check_step((response_t){1000, 1000, 500, {250, 0}}, 32767);
    check_step((response_t){1000, 1000, 500, {500, 0}}, 16384);
    check_step((response_t){1, 1, 0, {1, 0}}, 16384);
    /* The voltage that is left is 0 to 1.0, the mean ±1.0. */
    check_step((response_t){100, 10, 100, {100, 0}}, INDUCTANCE_UNKNOWN);
    check_step((response_t){1000, 1000, -32767, {32767, 0}}, 16384);
    check_step((response_t){1000, 1000, -32767, {32766, 0}}, 16386);
    resistance_q13 = 2048; /* 16384·(20000 − 8191)/20000 */
    check_step((response_t){16384, 20000, 34000, {9673, 0}}, 16384);
    resistance_q13 = 32767; /* leaves −131054 */
    check_words((response_t){8192, 1, 0, {8192, 0}}, (response_t){65535, 10, 32767, {0, 8192}},
                16384, INDUCTANCE_UNKNOWN);
}

/*
 * Bound 262143; expected 513·511 = 262143 and 16384·16 = 262144: a change of one more or less is
 * seen.
 */
TEST(test_changes_end_at_18_bits)
{
    response_t step = unit;
    response_t pulse = {.response = 16384, .voltage = 1, .mean = -15};

    check_step((response_t){513, 1, -510, {300000, 0}}, 16384);
    step.change.d = 8191;
    pulse.change = (dq_t){-300000, 262144};
    check_words(step, pulse, 8193, INDUCTANCE_UNKNOWN);
    pulse = (response_t){513, 1, -510, {-300000, 262144}};
    check_words(step, pulse, INDUCTANCE_UNKNOWN, INDUCTANCE_UNKNOWN);
}

static bool is_in_range(int32_t word)
{
    return (word == INDUCTANCE_UNKNOWN) || ((word >= 1) && (word <= 32767));
}

TEST(test_any_response_gives_a_result_within_its_range)
{
    seeded_t seed = {0x1D1CU};

    for (int32_t run = 0; run < 20000; run++) {
        inductance_result_t found;

        cfg = (inductance_cfg_t){.pulse_ticks = (uint32_t)seeded_in(&seed, 1, 16),
                                 .pulse_voltage = seeded_in(&seed, 1, 32767),
                                 .pulse_response = seeded_in(&seed, 1, 65535),
                                 .step_ticks = (uint32_t)seeded_in(&seed, 2, 16),
                                 .step_voltage = seeded_in(&seed, 1, 32767),
                                 .step_response = seeded_in(&seed, 1, 16384)};
        test = (inductance_t){.start_d = 0};
        for (uint32_t tick = 1U; tick <= last_tick(); tick++) {
            const dq_t current = {seeded_in(&seed, -1, 1) * 34400, seeded_in(&seed, -1, 1) * 34400};

            TEST_ASSERT_EQUAL(tick == last_tick(), inductance_step(&test, &cfg, tick, current));
        }
        found = inductance_result(&test, &cfg, seeded_in(&seed, 0, 32767));
        TEST_ASSERT_TRUE(is_in_range(found.ratio_q14) && is_in_range(found.saliency_q13));
    }
}
