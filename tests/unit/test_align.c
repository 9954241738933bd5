/* SPDX-License-Identifier: MIT */
/* Alignment: its phases, the turning vector, and R and L of a circuit with an offset voltage. */
#include "align.h"
#include "example_cfg.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* Motor A and the bases of example_cfg.h. */
#define PERIOD_S (1e-4)
#define RESISTANCE (2.125)
#define INDUCTANCE (0.0116)
#define CURRENT_LSB_A (40.0 / 32768.0)
#define VOLTAGE_LSB_V (450.0 / 32768.0)
#define RESISTANCE_Q13 (RESISTANCE * 40.0 / 450.0 * 8192.0)

static align_cfg_t cfg;
static align_t align;

void setUp(void)
{
    cfg = example_align_cfg();
    align_reset(&align, false);
}

/* A tick of a rotor that rests: no current across the vector. */
static void step(int32_t current, int32_t voltage)
{
    align_step(&align, &cfg, (dq_t){current, 0}, voltage);
}

/* What follows from the points and responses as they are now. */
static align_found_t found(void)
{
    align_t evaluated = align;

    evaluated.phase = ALIGN_EVALUATE;
    align_step(&evaluated, &cfg, (dq_t){0, 0}, 0);
    TEST_ASSERT_EQUAL_INT(ALIGN_DONE, evaluated.phase);
    return evaluated.found;
}

/* Ticks until the phase has changed, with nothing measured. */
static uint32_t ticks_of(align_phase_t phase)
{
    uint32_t count = 0U;

    TEST_ASSERT_EQUAL_INT(phase, align.phase);
    while (align.phase == phase) {
        step(0, 0);
        count++;
    }
    return count;
}

/* ---- phases ---- */

/* Pulse and step act and are seen later. */
static uint32_t inductance_ticks(void)
{
    return (4U * cfg.inductance.pulse_ticks) + 2U + cfg.inductance.step_ticks + 2U;
}

static void assert_phases(void)
{
    TEST_ASSERT_EQUAL_UINT32(cfg.pull_ticks, ticks_of(ALIGN_PULL));
    TEST_ASSERT_EQUAL_UINT32(1U << cfg.measure_log2, ticks_of(ALIGN_MEASURE_HIGH));
    TEST_ASSERT_EQUAL_UINT32(inductance_ticks(), ticks_of(ALIGN_INDUCTANCE));
    TEST_ASSERT_EQUAL_UINT32(cfg.settle_ticks, ticks_of(ALIGN_SETTLE));
    TEST_ASSERT_EQUAL_UINT32(1U << cfg.measure_log2, ticks_of(ALIGN_MEASURE_LOW));
    TEST_ASSERT_EQUAL_UINT32(1U, ticks_of(ALIGN_EVALUATE));
    for (int32_t k = 0; k < 1000; k++) {
        TEST_ASSERT_EQUAL_INT(ALIGN_DONE, align.phase);
        step(1000, 1000);
    }
}

/* At its shortest too. */
TEST(test_phases_follow_each_other_and_take_their_ticks)
{
    assert_phases();
    setUp();
    cfg.sweep_ticks = 1U;
    cfg.pull_ticks = 1U;
    cfg.settle_ticks = 1U;
    cfg.measure_log2 = 6U;
    cfg.inductance.pulse_ticks = 1U;
    cfg.inductance.step_ticks = 2U;
    assert_phases();
}

TEST(test_current_rises_by_its_slope_to_its_level_and_falls_to_the_lower_one_in_the_step)
{
    for (int32_t expected = cfg.slope; align.phase == ALIGN_PULL; expected += cfg.slope) {
        step(0, 0);
        TEST_ASSERT_EQUAL_INT32((expected < cfg.current_high) ? expected : cfg.current_high,
                                align.current_ref);
    }
    TEST_ASSERT_EQUAL_INT32(cfg.current_high, align.current_ref);
    while (align.phase != ALIGN_DONE) {
        step(0, 0);
        if (!align_holds_voltage(&align, &cfg)) { /* control acts */
            TEST_ASSERT_EQUAL_INT32((align.phase == ALIGN_MEASURE_HIGH) ? cfg.current_high
                                                                        : cfg.current_low,
                                    align.current_ref);
        }
    }
}

TEST(test_control_rests_from_the_end_of_the_first_mean_for_the_ticks_of_pulse_and_step)
{
    uint32_t rests = 0U;

    while (align.phase != ALIGN_DONE) {
        step(0, 0);
        if (align_holds_voltage(&align, &cfg)) {
            TEST_ASSERT_EQUAL_INT(ALIGN_INDUCTANCE, align.phase);
            TEST_ASSERT_EQUAL_UINT32(rests, align.tick); /* 0 in the tick that ends the mean */
            rests++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(inductance_ticks() - 1U, rests);
}

/* sweep_speed is rounded: half a step for each tick of the sweep. */
TEST(test_vector_turns_by_half_a_turn_in_the_wanted_direction_and_then_rests)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int64_t half_turn = (int64_t)1 << 31;
        int64_t turned = 0;
        uint32_t tick = 0U;

        align_reset(&align, sign < 0);
        while (align.phase != ALIGN_DONE) {
            step(0, 0);
            turned += align.frame_speed;
            tick++;
            TEST_ASSERT_EQUAL_INT32((tick <= cfg.sweep_ticks) ? (sign * cfg.sweep_speed) : 0,
                                    align.frame_speed);
        }
        TEST_ASSERT_TRUE(llabs((sign * turned) - half_turn) <= (int64_t)(cfg.sweep_ticks / 2U));
    }
}

TEST(test_a_rotor_already_held_is_not_swept_and_rests_for_the_remaining_pull)
{
    static const int32_t held[] = {5000, 6554, 8192}; /* below, at and above current_high */

    for (uint32_t i = 0U; i < 3U; i++) {
        align_reset_held(&align, &cfg, held[i]);
        for (uint32_t k = cfg.sweep_ticks + 1U; k <= cfg.pull_ticks; k++) {
            const int32_t before = align.current_ref;

            TEST_ASSERT_EQUAL_INT(ALIGN_PULL, align.phase);
            step(0, 0);
            TEST_ASSERT_EQUAL_INT32(0, align.frame_speed);
            TEST_ASSERT_TRUE(abs(align.current_ref - before) <= cfg.slope);
            TEST_ASSERT_TRUE(abs(align.current_ref - cfg.current_high) <=
                             abs(before - cfg.current_high));
        }
        TEST_ASSERT_EQUAL_INT(ALIGN_MEASURE_HIGH, align.phase);
        TEST_ASSERT_EQUAL_INT32(cfg.current_high, align.current_ref);
    }
}

/* ---- means ---- */

static void assert_means(align_point_t high, align_point_t low)
{
    TEST_ASSERT_EQUAL_INT32(64 * high.current, align.high.current);
    TEST_ASSERT_EQUAL_INT32(64 * high.voltage, align.high.voltage);
    TEST_ASSERT_EQUAL_INT32(64 * low.current, align.low.current);
    TEST_ASSERT_EQUAL_INT32(64 * low.voltage, align.low.voltage);
}

TEST(test_means_are_64_times_what_was_measured_for_every_length)
{
    static const int32_t values[] = {0, 1, -1, 12345, -12345, 32767, -32767};

    cfg.pull_ticks = 1U;
    cfg.sweep_ticks = 1U;
    cfg.settle_ticks = 1U;
    for (uint32_t log2 = 6U; log2 <= 16U; log2 += 5U) {
        for (uint32_t i = 0U; i < 7U; i++) {
            const align_point_t point = {.current = values[i], .voltage = values[6U - i]};

            cfg.measure_log2 = log2;
            align_reset(&align, false);
            while (align.phase != ALIGN_DONE) {
                step(point.current, point.voltage);
            }
            assert_means(point, point);
        }
    }
}

TEST(test_each_mean_holds_its_own_phase_and_no_other)
{
    static const int32_t of_phase[] = {9999, 300, -7777, 8888, 100, 5555, 4444};

    while (align.phase != ALIGN_DONE) {
        step(of_phase[align.phase], 2 * of_phase[align.phase]);
    }
    assert_means((align_point_t){.current = 300, .voltage = 600},
                 (align_point_t){.current = 100, .voltage = 200});
}

/* ---- R and L of a circuit ---- */

typedef struct {
    double resistance;
    double inductance;
    double offset_v; /* against the current: dead time and drop */
} circuit_t;

/* Bandwidth 100 Hz, its integral at R/L of motor A; a demand acts in the period after its own. */
static void measure(const circuit_t *circuit)
{
    const double gain = 6.2832 * 100.0 * INDUCTANCE * CURRENT_LSB_A / VOLTAGE_LSB_V;
    const double decay = exp(-circuit->resistance / circuit->inductance * PERIOD_S);
    double current_a = 0.0;
    double integral = 0.0;
    int32_t asked = 0;

    while (align.phase != ALIGN_DONE) {
        const int32_t measured = (int32_t)lround(current_a / CURRENT_LSB_A);
        const double drop_v = (current_a > 0.0) ? circuit->offset_v : 0.0;
        const double final_a = ((asked * VOLTAGE_LSB_V) - drop_v) / circuit->resistance;

        step(measured, asked);
        if (!align_holds_voltage(&align, &cfg)) {
            const double error = align.current_ref - measured;

            integral += error * gain * RESISTANCE / INDUCTANCE * PERIOD_S;
            asked = (int32_t)lround((error * gain) + integral);
        } else {
            asked += align_voltage(&align, &cfg).d;
        }
        current_a = final_a + ((current_a - final_a) * decay);
    }
}

/*
 * 2622 LSB of current apart. Means of the current are off by up to ½, those of the voltage by ½ of
 * 495 LSB at R: 2·½/2622 + 2·½/495; what the regulator has left of the settling, e^-4; the
 * difference of the currents in 1/10488; the result rounded down.
 */
#define R_TOLERANCE (0.0004 + 0.0021 + 0.0005 + 0.0001 + 0.0007)

/*
 * V0 = v_high − 2.5·(v_high − v_low), R·i apart: the means of the voltage are off by up to ½ LSB
 * each, 0.5 + 2.5·1, and those of the current by ½ at 0.19 LSB of voltage per LSB of current,
 * 0.19·(0.5 + 2.5·1). What the regulator has left of the settling is e^-4 of the step of current,
 * 0.0005 of 495 LSB, 2.5 times. The distance is rounded down by 1/1024 of the change, 495/1024. 1
 * for the result, rounded down.
 */
#define LOST_TOLERANCE (3.0 + (0.19 * 3.0) + (2.5 * 0.0005 * 495.0) + (495.0 / 1024.0) + 1.0)

/*
 * Rounding: two currents ½ each and the ripple of the regulator, 1 of 2582/1.3; step_response ½ of
 * 2582; R as measured, of which R·t/(2·L) = 0.07 at most counts; the trapezoid of R·i (R·T/L)²/12;
 * step_voltage and the results 1/16384 each.
 */
#define L_TOLERANCE \
    ((2.0 / 1986.0) + (0.5 / 2582.0) + (0.07 * R_TOLERANCE * 1.3) + 0.0001 + (4.0 / 16384.0))

/* Dead time and drop take the offset voltage; nothing flows across. */
TEST(test_resistance_inductance_and_lost_voltage_are_measured_whatever_the_others_are)
{
    static const double offsets_v[] = {-8.0, 0.0, 1.0, 6.2, 15.0};
    static const double resistances[] = {0.7, 1.0, 1.3, 1.8};
    static const double inductances[] = {0.7, 0.85, 1.0, 1.15, 1.3};

    for (uint32_t i = 0U; i < 100U; i++) {
        const double r = resistances[i / 25U];
        const double l = inductances[(i / 5U) % 5U];
        const circuit_t circuit = {r * RESISTANCE, l * INDUCTANCE, offsets_v[i % 5U]};
        align_found_t measured;

        align_reset(&align, (i % 2U) != 0U);
        measure(&circuit);
        measured = found();
        TEST_ASSERT_DOUBLE_WITHIN(R_TOLERANCE * RESISTANCE_Q13 * fmax(r, 1.0), r * RESISTANCE_Q13,
                                  measured.resistance_q13);
        TEST_ASSERT_DOUBLE_WITHIN(LOST_TOLERANCE * fmax(r, 1.0), circuit.offset_v / VOLTAGE_LSB_V,
                                  measured.lost_voltage);
        TEST_ASSERT_DOUBLE_WITHIN(L_TOLERANCE * l, l, measured.inductance.ratio_q14 / 16384.0);
        TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, measured.inductance.saliency_q13);
    }
}

static int32_t lost_of(int32_t v_high, int32_t i_high, int32_t v_low, int32_t i_low)
{
    align.high = (align_point_t){.voltage = 64 * v_high, .current = 64 * i_high};
    align.low = (align_point_t){.voltage = 64 * v_low, .current = 64 * i_low};
    return found().lost_voltage;
}

/*
 * Two currents so close to each other say nothing about zero: the voltage at four times their
 * distance counts.
 */
TEST(test_lost_voltage_of_two_close_currents_is_not_extrapolated_further_than_four_times)
{
    TEST_ASSERT_INT32_WITHIN(1, 1000 - (4 * 100), lost_of(1000, 1000, 900, 999));
    TEST_ASSERT_EQUAL_INT32(0, lost_of(1000, 500, 1000, 500));
    TEST_ASSERT_EQUAL_INT32(0, lost_of(1000, 500, 1000, 600));
    TEST_ASSERT_EQUAL_INT32(0, lost_of(1000, -1, 1000, -2));
}

/* ---- whether the rotor rests ---- */

/* Whether it rests in both measurements while current_q flows across in `phase` alone. */
static bool rests_with(align_phase_t phase, int32_t current_q)
{
    bool rests = true;

    align_reset(&align, false);
    while (align.phase != ALIGN_DONE) {
        const int32_t q = (align.phase == phase) ? current_q : 0;

        align_step(&align, &cfg, (dq_t){cfg.current_high, q}, 0);
        rests = rests && (!align_has_measured(&align) || align_is_at_rest(&align, &cfg));
    }
    return rests;
}

/*
 * The measurement `phase` of a rotor that swings: of each time that it is repeated the largest
 * current across, below zero in each second one. Returns how often it was measured.
 */
static uint32_t measured_with(align_phase_t phase, const int32_t *swings, uint32_t count)
{
    uint32_t times = 0U;

    align_reset(&align, false);
    while (align.phase < phase) {
        align_step(&align, &cfg, (dq_t){cfg.current_high, 0}, 0);
    }
    while (align.phase == phase) {
        const int32_t swing = swings[(times < count) ? times : (count - 1U)];
        const int32_t q = ((times & 1U) != 0U) ? -swing : swing;
        const bool begins = align.tick == 0U;

        align_step(&align, &cfg, (dq_t){cfg.current_high + (int32_t)times, begins ? q : 0}, 0);
        times += (align.tick == 0U) ? 1U : 0U;
    }
    return times;
}

TEST(test_rotor_rests_while_the_current_across_stays_within_its_limit)
{
    const int32_t most = cfg.swing_max;

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_TRUE(rests_with(ALIGN_MEASURE_HIGH, sign * most));
        TEST_ASSERT_TRUE(rests_with(ALIGN_MEASURE_LOW, sign * most));
        TEST_ASSERT_FALSE(rests_with(ALIGN_MEASURE_HIGH, sign * (most + 1)));
        TEST_ASSERT_FALSE(rests_with(ALIGN_MEASURE_LOW, sign * (most + 1)));
    }
}

/*
 * Each swing is 1/16 smaller than the larger one of the two before, 750 of 800: in one measurement
 * there may be no top. What was measured before the rotor rested does not count.
 */
TEST(test_a_rotor_that_swings_is_measured_once_it_has_calmed_down)
{
    static const int32_t calms[] = {1310, 500, 1228, 800, 1151, 750, 700, 400};

    cfg.swing_max = 400;
    TEST_ASSERT_EQUAL_UINT32(8, measured_with(ALIGN_MEASURE_HIGH, calms, 8U));
    TEST_ASSERT_TRUE(align_is_at_rest(&align, &cfg));
    TEST_ASSERT_EQUAL_INT32(64 * (cfg.current_high + 7), align.high.current);
    TEST_ASSERT_EQUAL_UINT32(8, measured_with(ALIGN_MEASURE_LOW, calms, 8U));
    TEST_ASSERT_TRUE(align_is_at_rest(&align, &cfg));
    TEST_ASSERT_EQUAL_INT32(64 * (cfg.current_high + 7), align.low.current);
}

static void assert_given_up(uint32_t times, align_phase_t phase, const int32_t *swings,
                            uint32_t count)
{
    TEST_ASSERT_EQUAL_UINT32(times, measured_with(phase, swings, count));
    TEST_ASSERT_FALSE(align_is_at_rest(&align, &cfg));
}

TEST(test_a_rotor_that_slips_does_not_calm_down)
{
    static const int32_t slips[] = {800};
    static const int32_t hardly[] = {800, 700, 751};
    static const int32_t grows[] = {800, 700, 750, 704};

    cfg.swing_max = 400;
    assert_given_up(3U, ALIGN_MEASURE_HIGH, slips, 1U);
    assert_given_up(3U, ALIGN_MEASURE_LOW, hardly, 3U);
    assert_given_up(4U, ALIGN_MEASURE_LOW, grows, 4U);
    cfg.swing_max = 1; /* the limit falls for the smallest swings too */
    for (int32_t swing = 2; swing <= 17; swing++) {
        assert_given_up(3U, ALIGN_MEASURE_HIGH, &swing, 1U);
    }
}

/* A load that drives it makes it faster meanwhile. */
TEST(test_with_a_fifth_of_the_current_across_a_rotor_is_not_waited_for)
{
    const int32_t most = cfg.current_high / 5;
    const int32_t calms[] = {most, 0};
    const int32_t slips[] = {most + 1, 0};

    cfg.swing_max = 400;
    TEST_ASSERT_EQUAL_UINT32(2, measured_with(ALIGN_MEASURE_HIGH, calms, 2U));
    assert_given_up(1U, ALIGN_MEASURE_HIGH, slips, 2U);
    assert_given_up(1U, ALIGN_MEASURE_LOW, slips, 2U);
}

TEST(test_swing_while_the_rotor_is_pulled_in_does_not_count)
{
    TEST_ASSERT_TRUE(rests_with(ALIGN_PULL, cfg.current_high));
    TEST_ASSERT_TRUE(rests_with(ALIGN_INDUCTANCE, cfg.current_high));
    TEST_ASSERT_TRUE(rests_with(ALIGN_SETTLE, cfg.current_high));
}

/* ---- what cannot be told ---- */

static int32_t resistance_of(int32_t voltage_change, int32_t current_change)
{
    align.low = (align_point_t){.voltage = -64 * 32767, .current = 67890};
    align.high = (align_point_t){.voltage = align.low.voltage + voltage_change,
                                 .current = align.low.current + current_change};
    return found().resistance_q13;
}

TEST(test_resistance_is_unknown_without_a_difference_in_current_or_voltage)
{
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(1000, 0));
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(0, 1000));
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(0, 0));
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(1000, 15));
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(-1, 10000));
    TEST_ASSERT_EQUAL_INT32(ALIGN_UNKNOWN, resistance_of(1000, -16));
    TEST_ASSERT_EQUAL_INT32(512, resistance_of(1, 16));
}

/* Up to the ends of what a mean can be. */
TEST(test_resistance_saturates_to_15_bits)
{
    TEST_ASSERT_EQUAL_INT32(32256, resistance_of(63, 16));
    TEST_ASSERT_EQUAL_INT32(32767, resistance_of(64, 16));
    TEST_ASSERT_EQUAL_INT32(32767, resistance_of(128 * 32767, 16));
}

/* ---- any measurement ---- */

TEST(test_any_measurement_keeps_the_reference_in_range_and_ends)
{
    seeded_t seed = {0xA11C4U};

    cfg = (align_cfg_t){.current_high = 16384,
                        .current_low = 16383,
                        .slope = 16384,
                        .sweep_speed = 0x20000000,
                        .sweep_ticks = 100U,
                        .pull_ticks = 100U,
                        .settle_ticks = 10U,
                        .measure_log2 = 8U,
                        .inductance = {.pulse_ticks = 16U,
                                       .pulse_voltage = 32767,
                                       .pulse_response = 65535,
                                       .step_ticks = 16U,
                                       .step_voltage = 32767,
                                       .step_response = 16384}};
    for (int32_t run = 0; run < 500; run++) {
        int32_t ticks = 0;

        align_reset(&align, (run % 2) != 0);
        while ((align.phase != ALIGN_DONE) && (ticks < 1000)) {
            const dq_t current = {seeded_in(&seed, -1, 1) * 32767, seeded_in(&seed, -1, 1) * 32767};

            align_step(&align, &cfg, current, seeded_in(&seed, -1, 1) * 32767);
            TEST_ASSERT_TRUE((align.current_ref >= 0) && (align.current_ref <= 16384));
            ticks++;
        }
        TEST_ASSERT_EQUAL_INT(ALIGN_DONE, align.phase);
        TEST_ASSERT_TRUE(found().resistance_q13 >= ALIGN_UNKNOWN);
        TEST_ASSERT_TRUE(found().resistance_q13 <= 32767);
        TEST_ASSERT_TRUE(abs(found().lost_voltage) <= 16384);
    }
}
