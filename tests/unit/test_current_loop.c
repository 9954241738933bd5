/* SPDX-License-Identifier: MIT */
/* Current loop: decoupling, the voltage circle, what the integrals do at it, a step on a motor. */
#include "current_loop.h"
#include "exact.h"
#include "example_cfg.h"
#include "figure.h"
#include "seeded.h"
#include "testing.h"
#include "trig.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define ONE (32768.0)

/* Decoupling in LSB: speed × reactance rounded down, times |i| ≤ 20000 / 2^14; then the product, rounded down. */
#define DECOUPLING_LSB (2.23)
#define EMF_LSB (1.0)
#define DROP_LSB (1.0) /* R·i* rounded down */

static current_loop_cfg_t cfg;
static current_loop_t loop;

void setUp(void)
{
    cfg = example_current_loop_cfg();
    current_loop_reset(&loop);
}

/* The model's part for this reference and speed, and one tick. */
static dq_t planned_step(dq_t reference, dq_t measured, int32_t speed_q15, int32_t limit)
{
    current_loop_plan(&loop, &cfg, reference, speed_q15);
    return current_loop_step(&loop, &cfg, reference, measured, limit);
}

static void remove_regulators(void)
{
    cfg.pi_d.kp = 0;
    cfg.pi_d.ki = 0;
    cfg.pi_q = cfg.pi_d;
}

TEST(test_reset_empties_both_integrals)
{
    (void)planned_step((dq_t){5000, 5000}, (dq_t){0, 0}, 9000, 32767);
    TEST_ASSERT_TRUE((loop.reactance_q14.d != 0) && (loop.reactance_q14.q != 0));
    TEST_ASSERT_TRUE((loop.pi_d.integral_q26 != 0) && (loop.pi_q.integral_q26 != 0));
    current_loop_reset(&loop);
    TEST_ASSERT_EQUAL_INT32(0, loop.pi_d.integral_q26);
    TEST_ASSERT_EQUAL_INT32(0, loop.pi_q.integral_q26);
    TEST_ASSERT_EQUAL_INT32(0, loop.reactance_q14.d);
    TEST_ASSERT_EQUAL_INT32(0, loop.reactance_q14.q);
    TEST_ASSERT_EQUAL_INT32(0, loop.constant.d);
    TEST_ASSERT_EQUAL_INT32(0, loop.constant.q);
}

/* The square of 2^16 is 0 in 32 bits. */
TEST(test_a_demand_of_which_the_square_wraps_is_outside_of_the_circle)
{
    static const dq_t demands[] = {{65536, 0}, {-65536, 0}, {0, 65536}, {0, -65536}};

    remove_regulators();
    for (uint32_t i = 0U; i < 4U; i++) {
        dq_t v;

        loop.constant = demands[i];
        v = current_loop_step(&loop, &cfg, (dq_t){0, 0}, (dq_t){0, 0}, 18000);
        TEST_ASSERT_EQUAL_INT32(demands[i].d / 65536 * 18000, v.d);
        TEST_ASSERT_EQUAL_INT32(demands[i].q / 65536 * 18000, v.q);
    }
}

TEST(test_no_error_at_rest_demands_no_voltage)
{
    const dq_t v = planned_step((dq_t){0, 0}, (dq_t){0, 0}, 0, 32767);

    TEST_ASSERT_EQUAL_INT32(0, v.d);
    TEST_ASSERT_EQUAL_INT32(0, v.q);
}

TEST(test_each_axis_answers_its_own_error_only)
{
    dq_t v = planned_step((dq_t){100, 0}, (dq_t){0, 0}, 0, 32767);

    TEST_ASSERT_TRUE(v.d > 0);
    TEST_ASSERT_EQUAL_INT32(0, v.q);
    current_loop_reset(&loop);
    v = planned_step((dq_t){0, 0}, (dq_t){0, 100}, 0, 32767);
    TEST_ASSERT_EQUAL_INT32(0, v.d);
    TEST_ASSERT_TRUE(v.q < 0);
}

TEST(test_decoupling_follows_the_motor_equations)
{
    seeded_t seed = {0xDEC0DEU};
    double worst = 0.0;

    remove_regulators();
    cfg.reactance_d_q13 = 4000;
    cfg.reactance_q_q13 = 7000;
    cfg.emf_q13 = 2000;
    cfg.resistance_q13 = 3000;
    for (int32_t k = 0; k < 100000; k++) {
        const dq_t i = {seeded_in(&seed, -20000, 20000), seeded_in(&seed, -20000, 20000)};
        const int32_t speed = seeded_in(&seed, -32767, 32767);
        const dq_t v = planned_step(i, i, speed, 32767);
        const double d = (i.d * (3000.0 / 8192.0)) - (speed * (7000.0 / 8192.0) * i.q / ONE);
        const double q = (i.q * (3000.0 / 8192.0)) + (speed * (4000.0 / 8192.0) * i.d / ONE) +
                         (speed * (2000.0 / 8192.0));

        if (abs(v.d) < 32767) {
            worst = fmax(worst, fabs(v.d - d) - DROP_LSB);
        }
        if ((v.d * v.d) + (v.q * v.q) < (32000 * 32000)) {
            worst = fmax(worst, fabs(v.q - q) - EMF_LSB - DROP_LSB);
        }
    }
    figure_check("decoupling, LSB", worst, DECOUPLING_LSB, 0.4);
}

TEST(test_drop_of_the_resistance_is_that_of_the_reference_and_not_of_the_measured_current)
{
    dq_t v;

    remove_regulators();
    cfg.resistance_q13 = 4096; /* ½ */
    v = planned_step((dq_t){1000, -2000}, (dq_t){0, 0}, 0, 32767);
    TEST_ASSERT_EQUAL_INT32(500, v.d);
    TEST_ASSERT_EQUAL_INT32(-1000, v.q);
    v = planned_step((dq_t){0, 0}, (dq_t){1000, -2000}, 0, 32767);
    TEST_ASSERT_EQUAL_INT32(0, v.d);
    TEST_ASSERT_EQUAL_INT32(0, v.q);
}

/*
 * Integrals of 20000 and 7000, turned: sine and cosine are within 1 LSB (trig.h), 27000/2^15 in the sum of both
 * products; their amplitude is 32767, 21190/2^15 of the length; rounding ½.
 */
#define TURNED_LSB (2.0)

TEST(test_turn_of_the_frame_keeps_the_integrals_where_they_are_in_space)
{
    for (int32_t k = 0; k < 360; k++) {
        const double angle = k * 3.141592653589793 / 180.0;
        const angle_t step = (angle_t)lround(k / 360.0 * 4294967296.0);
        double d = 0.0;
        double q = 0.0;

        pi_reset(&loop.pi_d, 20000);
        pi_reset(&loop.pi_q, -7000);
        current_loop_turn(&loop, trig_sincos(step));
        d = (20000.0 * cos(angle)) - (7000.0 * sin(angle));
        q = (-20000.0 * sin(angle)) - (7000.0 * cos(angle));
        TEST_ASSERT_DOUBLE_WITHIN(TURNED_LSB, d, pi_output(&loop.pi_d));
        TEST_ASSERT_DOUBLE_WITHIN(TURNED_LSB, q, pi_output(&loop.pi_q));
    }
}

TEST(test_turn_of_integrals_at_their_ends_saturates_at_one)
{
    /* 1 along both axes is √2 along the diagonal: an eighth of a turn away. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        pi_reset(&loop.pi_d, sign * 32767);
        pi_reset(&loop.pi_q, sign * 32767);
        current_loop_turn(&loop, trig_sincos(0x20000000U));
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? 32767 : -32768, pi_output(&loop.pi_d));
        TEST_ASSERT_INT32_WITHIN(2, 0, pi_output(&loop.pi_q));
        pi_reset(&loop.pi_d, sign * 32767);
        pi_reset(&loop.pi_q, sign * 32767);
        current_loop_turn(&loop, trig_sincos(0xE0000000U));
        TEST_ASSERT_INT32_WITHIN(2, 0, pi_output(&loop.pi_d));
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? 32767 : -32768, pi_output(&loop.pi_q));
    }
}

TEST(test_model_is_the_products_rounded_down_for_any_speed_gain_and_current)
{
    static const int32_t speeds[] = {-32768, -16385, -7, -1, 0, 1, 7, 16385, 32767};
    static const int32_t gains[] = {0, 1, 8191, 8192, 32499, 32500, 32767};
    static const int32_t currents[] = {-32769, -32768, -3, -1, 0, 1, 3, 32767, 32768};

    for (size_t k = 0; k < (9U * 7U * 9U); k++) {
        const int32_t speed = speeds[k % 9U];
        const int32_t gain = gains[(k / 9U) % 7U];
        const int32_t current = currents[k / 63U];
        const int64_t reactance = floor_div_pow2((int64_t)speed * gain, 14U);
        const int64_t within = clamp64(current, -32768, 32767);
        const int64_t emf = floor_div_pow2((int64_t)speed * gain, 13U);
        dq_t model;

        cfg.reactance_d_q13 = gain;
        cfg.reactance_q_q13 = gain;
        cfg.emf_q13 = gain;
        cfg.resistance_q13 = gain;
        current_loop_plan(&loop, &cfg, (dq_t){1000, -1000}, speed);
        model = current_loop_model(&loop, (dq_t){current, current});
        TEST_ASSERT_EQUAL_INT64(floor_div_pow2(1000 * (int64_t)gain, 13U) -
                                    floor_div_pow2(reactance * within, 14U),
                                model.d);
        TEST_ASSERT_EQUAL_INT64(floor_div_pow2(-1000 * (int64_t)gain, 13U) + emf +
                                    floor_div_pow2(reactance * within, 14U),
                                model.q);
    }
}

/* Between two plans the speed and the reference of the model stay: only the measured current is new. */
TEST(test_model_keeps_speed_and_reference_of_the_last_plan)
{
    dq_t before;

    current_loop_plan(&loop, &cfg, (dq_t){100, 200}, 9000);
    before = current_loop_model(&loop, (dq_t){300, 400});
    (void)current_loop_step(&loop, &cfg, (dq_t){5000, 5000}, (dq_t){0, 0}, 32767);
    TEST_ASSERT_EQUAL_INT32(before.d, current_loop_model(&loop, (dq_t){300, 400}).d);
    TEST_ASSERT_EQUAL_INT32(before.q, current_loop_model(&loop, (dq_t){300, 400}).q);
    current_loop_reset(&loop);
    TEST_ASSERT_EQUAL_INT32(0, current_loop_model(&loop, (dq_t){300, 400}).d);
    TEST_ASSERT_EQUAL_INT32(0, current_loop_model(&loop, (dq_t){300, 400}).q);
}

TEST(test_voltage_never_leaves_the_circle)
{
    seeded_t seed = {0xC1AC1EU};

    for (int32_t k = 0; k < 200000; k++) {
        const dq_t reference = {seeded_in(&seed, -16384, 16384), seeded_in(&seed, -16384, 16384)};
        const dq_t measured = {seeded_in(&seed, -46340, 46340), seeded_in(&seed, -46340, 46340)};
        const int32_t speed = seeded_in(&seed, -32767, 32767);
        const int32_t limit = ((k % 16) == 0) ? 0 : seeded_in(&seed, 0, 32767);
        dq_t v;

        cfg.pi_d.kp_shift = (uint32_t)seeded_in(&seed, 1, 16);
        cfg.pi_q.kp_shift = (uint32_t)seeded_in(&seed, 1, 16);
        cfg.pi_d.ki_shift = (uint32_t)seeded_in(&seed, 1, 16);
        cfg.pi_q.ki_shift = (uint32_t)seeded_in(&seed, 1, 16);
        v = planned_step(reference, measured, speed, limit);
        TEST_ASSERT_TRUE(((v.d * v.d) + (v.q * v.q)) <= (limit * limit));
    }
}

TEST(test_extreme_gains_and_inputs_stay_in_the_circle)
{
    static const int32_t ends[] = {-32768, 0, 32768};
    const pi_cfg_t largest = {.kp = 32767, .ki = 32767, .kp_shift = 1U, .ki_shift = 1U};

    cfg = (current_loop_cfg_t){largest, largest, 32767, 32767, 32767, 32767};
    for (int32_t k = 0; k < 81; k++) {
        const dq_t measured = {ends[k % 3], ends[(k / 3) % 3]};
        const dq_t reference = {ends[(k / 9) % 3] / 2, ends[k / 27] / 2};

        for (int32_t sign = -1; sign <= 1; sign += 2) {
            const dq_t v = planned_step(reference, measured, sign * 32767, 32767);

            TEST_ASSERT_TRUE(((v.d * v.d) + (v.q * v.q)) <= (32767 * 32767));
        }
    }
}

TEST(test_d_axis_takes_the_whole_circle_first)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        dq_t v;

        current_loop_reset(&loop);
        v = planned_step((dq_t){sign * 16384, 16384}, (dq_t){0, 0}, 0, 10000);
        TEST_ASSERT_EQUAL_INT32(sign * 10000, v.d);
        TEST_ASSERT_EQUAL_INT32(0, v.q);
    }
}

/* A torque against the speed: v_q has the whole circle first. ω·φ and ω·L·i are nothing at a speed of 1 LSB. */
TEST(test_braking_q_axis_takes_the_whole_circle_first)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        dq_t v;

        cfg.reactance_q_q13 = 32767;
        current_loop_reset(&loop);
        v = planned_step((dq_t){sign * 16384, -16384}, (dq_t){0, 0}, 1, 10000);
        TEST_ASSERT_EQUAL_INT32(0, v.d);
        TEST_ASSERT_EQUAL_INT32(-10000, v.q);
        current_loop_reset(&loop);
        v = planned_step((dq_t){sign * 16384, 16384}, (dq_t){0, 0}, 1, 10000);
        TEST_ASSERT_EQUAL_INT32(sign * 10000, v.d);
        TEST_ASSERT_EQUAL_INT32(0, v.q);
    }
}

TEST(test_braking_d_axis_is_cut_to_what_the_circle_leaves_beside_q)
{
    /* v_q = −6000 of 10000 leaves 8000, exactly; what is cut goes back to the integral. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        dq_t v;

        cfg.reactance_q_q13 = 32767;
        cfg.resistance_q13 = 0;
        cfg.emf_q13 = 0;
        cfg.pi_q.kp = 0;
        cfg.pi_q.ki = 0;
        current_loop_reset(&loop);
        pi_reset(&loop.pi_d, sign * 9000);
        pi_reset(&loop.pi_q, -6000);
        v = planned_step((dq_t){0, -1}, (dq_t){0, 0}, 1, 10000);
        TEST_ASSERT_EQUAL_INT32(sign * 8000, v.d);
        TEST_ASSERT_EQUAL_INT32(-6000, v.q);
        TEST_ASSERT_EQUAL_INT32(sign * 8000 * 2048, loop.pi_d.integral_q26);
    }
}

/*
 * Motor A turns at a speed whose EMF is 0.8 of the circle and brakes with so much current that ω·L·i is 0.7 of it, forward
 * Euler with 50 steps a tick. The circle does not give both. i_q holds within 5 % of its reference, which is the ripple
 * that the limit leaves; i_d, which is free, weakens the field. With v_d first i_q ran away to v/R.
 */
TEST(test_braking_at_the_limit_holds_the_torque_current)
{
    const double inductance = 0.0116;
    const double step_s = 1e-4 / 50.0;
    const double limit_v = 100.0;
    const double speed = 0.8 * limit_v / 0.387;
    const double brake_a = -0.7 * limit_v / (speed * inductance);
    const int32_t limit = (int32_t)lround(limit_v / 450.0 * 32768.0);
    const int32_t speed_q15 = (int32_t)lround(speed / 981.75 * 32768.0);
    const int32_t reference = (int32_t)lround(brake_a / 40.0 * 32768.0);
    double i_d = 0.0;
    double i_q = 0.0;

    for (int32_t k = 0; k < 2000; k++) {
        const dq_t measured = {(int32_t)lround(i_d / 40.0 * 32768.0),
                               (int32_t)lround(i_q / 40.0 * 32768.0)};
        const int32_t ramped = (k < 500) ? ((reference * k) / 500) : reference;
        const dq_t v = planned_step((dq_t){0, ramped}, measured, speed_q15, limit);

        for (int32_t n = 0; n < 50; n++) {
            const double v_d = v.d / 32768.0 * 450.0;
            const double v_q = v.q / 32768.0 * 450.0;
            const double slope_d = (v_d - (2.125 * i_d) + (speed * inductance * i_q)) / inductance;
            const double slope_q =
                (v_q - (2.125 * i_q) - (speed * ((inductance * i_d) + 0.387))) / inductance;

            i_d += slope_d * step_s;
            i_q += slope_q * step_s;
        }
    }
    TEST_ASSERT_TRUE(fabs(i_q - brake_a) < (0.05 * fabs(brake_a)));
    TEST_ASSERT_TRUE(i_d < 0.0);
}

TEST(test_q_axis_is_cut_to_what_the_circle_leaves_beside_d)
{
    /* v_d = 6000 of 10000 leaves 8000, exactly. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        dq_t v;

        current_loop_reset(&loop);
        pi_reset(&loop.pi_d, 6000);
        v = planned_step((dq_t){0, sign * 16384}, (dq_t){0, 0}, 0, 10000);
        TEST_ASSERT_EQUAL_INT32(6000, v.d);
        TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
    }
}

TEST(test_demand_exactly_on_the_circle_is_not_cut)
{
    dq_t v;

    pi_reset(&loop.pi_d, 6000);
    pi_reset(&loop.pi_q, 8000);
    v = planned_step((dq_t){0, 0}, (dq_t){0, 0}, 0, 10000);
    TEST_ASSERT_EQUAL_INT32(6000, v.d);
    TEST_ASSERT_EQUAL_INT32(8000, v.q);
    TEST_ASSERT_EQUAL_INT32(8000 * 2048, loop.pi_q.integral_q26);
}

TEST(test_cut_of_the_circle_goes_back_to_the_q_integral)
{
    pi_reset(&loop.pi_d, 6000);
    pi_reset(&loop.pi_q, 9000);
    (void)planned_step((dq_t){0, 0}, (dq_t){0, 0}, 0, 10000);
    TEST_ASSERT_EQUAL_INT32(8000 * 2048, loop.pi_q.integral_q26);
}

TEST(test_voltage_leaves_the_circle_as_soon_as_the_error_turns)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        dq_t v = {0, 0};

        current_loop_reset(&loop);
        pi_reset(&loop.pi_d, 6000);
        for (int32_t k = 0; k < 10000; k++) {
            v = planned_step((dq_t){0, sign * 4000}, (dq_t){0, 0}, 0, 10000);
        }
        TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
        v = planned_step((dq_t){0, -sign * 10}, (dq_t){0, 0}, 0, 10000);
        TEST_ASSERT_TRUE((sign * v.q) < 8000);
    }
}

TEST(test_q_integral_takes_over_what_an_emf_exceeds_the_circle_by)
{
    /* d holds 6000 of 10000; the EMF alone asks for about 27000 of the 8000 left. */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t emf = (int32_t)floor(sign * 32000.0 * cfg.emf_q13 / 8192.0);

        current_loop_reset(&loop);
        pi_reset(&loop.pi_d, 6000);
        for (int32_t k = 0; k < 2000; k++) {
            const dq_t v = planned_step((dq_t){0, 0}, (dq_t){0, 0}, sign * 32000, 10000);

            TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
        }
        TEST_ASSERT_EQUAL_INT32(((sign * 8000) - emf) * 2048, loop.pi_q.integral_q26);
    }
}

TEST(test_q_integral_saturates_at_one_while_an_emf_stays_beyond_the_circle)
{
    /* 16384·30000/2^13 = 60000 less 1 is still beyond the circle. */
    cfg.emf_q13 = 30000;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        current_loop_reset(&loop);
        pi_reset(&loop.pi_d, 6000);
        for (int32_t k = 0; k < 2000; k++) {
            const dq_t v = planned_step((dq_t){0, 0}, (dq_t){0, 0}, sign * 16384, 10000);

            TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
        }
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? (-32768 * 2048) : ((32768 * 2048) - 1),
                                loop.pi_q.integral_q26);
    }
}

/*
 * Motor A at 200 rad/s, forward Euler with 50 steps a tick. The closed loop has its pole at 500 Hz: a step is
 * complete to e^-5 < 1 % after 5/(2π·500 s) = 16 ticks; the integral's zero at 50 Hz lets it overshoot by
 * less than 50/500 = 10 %, gone (to e^-5) after 5/(2π·50 s) = 160 ticks. Left of the error then is
 * 1 LSB, for less than that the integral still moves.
 */
TEST(test_current_step_on_a_motor_settles_as_designed_without_moving_the_other_axis)
{
    const double inductance = 0.0116;
    const double speed = 200.0;
    const double step_s = 1e-4 / 50.0;
    const int32_t demand = 4096; /* 5 A */
    double d = 0.0;
    double q = 0.0;

    pi_reset(&loop.pi_q, 0);
    for (int32_t k = 0; k < 400; k++) {
        const dq_t measured = {(int32_t)lround(d / 40.0 * ONE), (int32_t)lround(q / 40.0 * ONE)};
        const dq_t v = planned_step((dq_t){0, demand}, measured,
                                    (int32_t)lround(speed / 981.748 * ONE), 18000);

        if (k > 16) {
            TEST_ASSERT_INT32_WITHIN(demand / 10, demand, measured.q);
            TEST_ASSERT_INT32_WITHIN(demand / 50, 0, measured.d);
        }
        if (k > 200) {
            TEST_ASSERT_INT32_WITHIN(2, demand, measured.q);
            TEST_ASSERT_INT32_WITHIN(2, 0, measured.d);
        }
        for (int32_t i = 0; i < 50; i++) {
            const double v_d = (v.d * 450.0 / ONE) - (2.125 * d) + (speed * inductance * q);
            const double v_q =
                (v.q * 450.0 / ONE) - (2.125 * q) - (speed * ((inductance * d) + 0.387));

            d += v_d / inductance * step_s;
            q += v_q / inductance * step_s;
        }
    }
}

/* An LSB of the voltage is 2^11 of the integral. */
TEST(test_a_voltage_that_is_taken_over_goes_to_the_integral_of_its_axis)
{
    loop.pi_d.integral_q26 = 5;
    loop.pi_q.integral_q26 = -7;
    current_loop_take_over(&loop, (dq_t){1000, -300});
    TEST_ASSERT_EQUAL_INT32(5 + (1000 * 2048), loop.pi_d.integral_q26);
    TEST_ASSERT_EQUAL_INT32(-7 - (300 * 2048), loop.pi_q.integral_q26);
}

/* From the lower end, so that the integral's own limit takes nothing off. */
TEST(test_no_more_than_the_largest_voltage_is_taken_over)
{
    const int32_t end = 67108864;
    const int32_t most = 32767 * 2048;

    loop.pi_d.integral_q26 = -end;
    loop.pi_q.integral_q26 = -end;
    current_loop_take_over(&loop, (dq_t){60000, 60000});
    TEST_ASSERT_EQUAL_INT32(most - end, loop.pi_d.integral_q26);
    TEST_ASSERT_EQUAL_INT32(most - end, loop.pi_q.integral_q26);
    loop.pi_d.integral_q26 = end - 1;
    loop.pi_q.integral_q26 = end - 1;
    current_loop_take_over(&loop, (dq_t){-60000, -60000});
    TEST_ASSERT_EQUAL_INT32((end - 1) - most, loop.pi_d.integral_q26);
    TEST_ASSERT_EQUAL_INT32((end - 1) - most, loop.pi_q.integral_q26);
}
