/* SPDX-License-Identifier: MIT */
/* Current loop: decoupling, the voltage circle, what the integrals do at it, a step on a motor. */
#include "current_loop.h"
#include "exact.h"
#include "example_cfg.h"
#include "figure.h"
#include "testing.h"
#include "trig.h"
#include "two_axes.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define ONE (32768.0)
#define INDUCTANCE (0.0116)

/*
 * Decoupling in LSB: speed × reactance rounded down, times |i| ≤ 20000 / 2^14; then the product,
 * rounded down.
 */
#define DECOUPLING_LSB (2.23)
#define EMF_LSB (1.0)
#define DROP_LSB (1.0) /* R·i* rounded down */

static current_loop_cfg_t cfg;
static current_loop_t loop;

void setUp(void)
{
    cfg = example_current_loop_cfg();
    loop = (current_loop_t){.constant = {0, 0}};
}

/* The model's part for this reference and speed, and one tick. */
static dq_t planned_step(dq_t reference, dq_t measured, int32_t speed_q15, int32_t limit)
{
    current_loop_plan(&loop, &cfg, reference, speed_q15);
    return current_loop_step(&loop, &cfg, reference, measured, limit);
}

/* Within a circle of 10000, from these integrals of an empty loop on, without current. */
static dq_t step_from(dq_t integrals, dq_t reference, int32_t speed_q15)
{
    loop = (current_loop_t){.constant = {0, 0}};
    pi_reset(&loop.pi_d, integrals.d);
    pi_reset(&loop.pi_q, integrals.q);
    return planned_step(reference, (dq_t){0, 0}, speed_q15, 10000);
}

static void assert_integrals(int32_t d_q26, int32_t q_q26)
{
    assert_dq(d_q26, q_q26, (dq_t){loop.pi_d.integral_q26, loop.pi_q.integral_q26});
}

static void remove_regulators(void)
{
    cfg.pi_d.kp = 0;
    cfg.pi_d.ki = 0;
    cfg.pi_q = cfg.pi_d;
}

/* The square of 2^16 is 0 in 32 bits. */
TEST(test_a_demand_of_which_the_square_wraps_is_outside_of_the_circle)
{
    static const dq_t signs[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

    remove_regulators();
    for (uint32_t i = 0U; i < 4U; i++) {
        loop.constant = (dq_t){signs[i].d * 65536, signs[i].q * 65536};
        assert_dq(signs[i].d * 18000, signs[i].q * 18000,
                  current_loop_step(&loop, &cfg, (dq_t){0, 0}, (dq_t){0, 0}, 18000));
    }
}

TEST(test_each_axis_answers_its_own_error_only)
{
    dq_t v = planned_step((dq_t){100, 0}, (dq_t){0, 0}, 0, 32767);

    TEST_ASSERT_TRUE(v.d > 0);
    TEST_ASSERT_EQUAL_INT32(0, v.q);
    loop = (current_loop_t){.constant = {0, 0}};
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
    remove_regulators();
    cfg.resistance_q13 = 4096; /* ½ */
    assert_dq(500, -1000, planned_step((dq_t){1000, -2000}, (dq_t){0, 0}, 0, 32767));
    assert_dq(0, 0, planned_step((dq_t){0, 0}, (dq_t){1000, -2000}, 0, 32767));
}

/*
 * Integrals of 20000 and 7000, turned: sine and cosine are within 1 LSB (trig.h), 27000/2^15 in the
 * sum of both products; their amplitude is 32767, 21190/2^15 of the length; rounding ½.
 */
#define TURNED_LSB (2.0)

TEST(test_turn_of_the_frame_keeps_the_integrals_where_they_are_in_space)
{
    for (int32_t k = 0; k < 360; k++) {
        const double angle = k * 3.141592653589793 / 180.0;
        const double d = (20000.0 * cos(angle)) - (7000.0 * sin(angle));
        const double q = (-20000.0 * sin(angle)) - (7000.0 * cos(angle));

        pi_reset(&loop.pi_d, 20000);
        pi_reset(&loop.pi_q, -7000);
        current_loop_turn(&loop, trig_sincos((angle_t)lround(k / 360.0 * 4294967296.0)));
        TEST_ASSERT_DOUBLE_WITHIN(TURNED_LSB, d, pi_output(&loop.pi_d));
        TEST_ASSERT_DOUBLE_WITHIN(TURNED_LSB, q, pi_output(&loop.pi_q));
    }
}

/* 1 along both axes is √2 along the diagonal: an eighth of a turn away. */
TEST(test_turn_of_integrals_at_their_ends_saturates_at_one)
{
    for (int32_t k = 0; k < 4; k++) {
        const int32_t end = (k < 2) ? 32767 : -32767;
        const bool ahead = (k % 2) == 0;

        pi_reset(&loop.pi_d, end);
        pi_reset(&loop.pi_q, end);
        current_loop_turn(&loop, trig_sincos(ahead ? 0x20000000U : 0xE0000000U));
        TEST_ASSERT_EQUAL_INT32((end > 0) ? 32767 : -32768,
                                pi_output(ahead ? &loop.pi_d : &loop.pi_q));
        TEST_ASSERT_INT32_WITHIN(2, 0, pi_output(ahead ? &loop.pi_q : &loop.pi_d));
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

/*
 * Between two plans the speed and the reference of the model stay: only the measured current is
 * new.
 */
TEST(test_model_keeps_speed_and_reference_of_the_last_plan)
{
    const dq_t current = {300, 400};
    dq_t before;

    current_loop_plan(&loop, &cfg, (dq_t){100, 200}, 9000);
    before = current_loop_model(&loop, current);
    (void)current_loop_step(&loop, &cfg, (dq_t){5000, 5000}, (dq_t){0, 0}, 32767);
    assert_dq(before.d, before.q, current_loop_model(&loop, current));
    loop = (current_loop_t){.constant = {0, 0}};
    assert_dq(0, 0, current_loop_model(&loop, current));
}

TEST(test_voltage_never_leaves_the_circle)
{
    seeded_t seed = {0xC1AC1EU};

    for (int32_t k = 0; k < 200000; k++) {
        const dq_t reference = seeded_dq(&seed, 16384);
        const dq_t measured = seeded_dq(&seed, 46340);
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

/*
 * A torque against the speed: v_q has the whole circle first. ω·φ and ω·L·i are nothing at a speed
 * of 1 LSB.
 */
TEST(test_braking_q_axis_takes_the_whole_circle_first)
{
    cfg.reactance_q_q13 = 32767;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        assert_dq(0, -10000, step_from((dq_t){0, 0}, (dq_t){sign * 16384, -16384}, 1));
        assert_dq(sign * 10000, 0, step_from((dq_t){0, 0}, (dq_t){sign * 16384, 16384}, 1));
    }
}

/* v_q = −6000 of 10000 leaves 8000, exactly; what is cut goes back to the integral. */
TEST(test_braking_d_axis_is_cut_to_what_the_circle_leaves_beside_q)
{
    cfg.reactance_q_q13 = 32767;
    cfg.resistance_q13 = 0;
    cfg.emf_q13 = 0;
    cfg.pi_q.kp = 0;
    cfg.pi_q.ki = 0;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        assert_dq(sign * 8000, -6000, step_from((dq_t){sign * 9000, -6000}, (dq_t){0, -1}, 1));
        TEST_ASSERT_EQUAL_INT32(sign * 8000 * 2048, loop.pi_d.integral_q26);
    }
}

/* The currents of motor A at a constant electrical speed, A and rad/s. */
typedef struct {
    double d;
    double q;
    double speed;
} windings_t;

static dq_t measure(const windings_t *w)
{
    return (dq_t){(int32_t)lround(w->d / 40.0 * ONE), (int32_t)lround(w->q / 40.0 * ONE)};
}

/* One tick, forward Euler with 50 steps. */
static void drive_windings(windings_t *w, dq_t v)
{
    for (int32_t n = 0; n < 50; n++) {
        const double v_d = (v.d * 450.0 / ONE) - (2.125 * w->d) + (w->speed * INDUCTANCE * w->q);
        const double v_q =
            (v.q * 450.0 / ONE) - (2.125 * w->q) - (w->speed * ((INDUCTANCE * w->d) + 0.387));

        w->d += v_d / INDUCTANCE * (1e-4 / 50.0);
        w->q += v_q / INDUCTANCE * (1e-4 / 50.0);
    }
}

/*
 * Motor A turns at a speed whose EMF is 0.8 of the circle and brakes with so much current that
 * ω·L·i is 0.7 of it. The circle does not give both. i_q holds within 5 % of its reference, the
 * ripple that the limit leaves; i_d is free and weakens the field. With v_d first i_q ran away.
 */
TEST(test_braking_at_the_limit_holds_the_torque_current)
{
    const double limit_v = 100.0;
    windings_t windings = {.speed = 0.8 * limit_v / 0.387};
    const double brake_a = -0.7 * limit_v / (windings.speed * INDUCTANCE);
    const int32_t limit = (int32_t)lround(limit_v / 450.0 * ONE);
    const int32_t speed_q15 = (int32_t)lround(windings.speed / 981.75 * ONE);
    const int32_t reference = (int32_t)lround(brake_a / 40.0 * ONE);

    for (int32_t k = 0; k < 2000; k++) {
        const int32_t ramped = (k < 500) ? ((reference * k) / 500) : reference;

        drive_windings(&windings,
                       planned_step((dq_t){0, ramped}, measure(&windings), speed_q15, limit));
    }
    TEST_ASSERT_TRUE(fabs(windings.q - brake_a) < (0.05 * fabs(brake_a)));
    TEST_ASSERT_TRUE(windings.d < 0.0);
}

/* v_d = 6000 of 10000 leaves 8000, exactly; what is cut goes back to the integral. */
TEST(test_q_axis_is_cut_to_what_the_circle_leaves_beside_d)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        assert_dq(sign * 10000, 0, step_from((dq_t){0, 0}, (dq_t){sign * 16384, 16384}, 0));
        assert_dq(6000, sign * 8000, step_from((dq_t){6000, 0}, (dq_t){0, sign * 16384}, 0));
        assert_dq(6000, sign * 8000, step_from((dq_t){6000, sign * 8000}, (dq_t){0, 0}, 0));
        assert_integrals(6000 * 2048, sign * 8000 * 2048);
        assert_dq(6000, sign * 8000, step_from((dq_t){6000, sign * 9000}, (dq_t){0, 0}, 0));
        assert_integrals(6000 * 2048, sign * 8000 * 2048);
    }
}

TEST(test_voltage_leaves_the_circle_as_soon_as_the_error_turns)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const dq_t wanted = {0, sign * 4000};
        dq_t v = step_from((dq_t){6000, 0}, wanted, 0);

        for (int32_t k = 1; k < 10000; k++) {
            v = planned_step(wanted, (dq_t){0, 0}, 0, 10000);
        }
        TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
        v = planned_step((dq_t){0, -sign * 10}, (dq_t){0, 0}, 0, 10000);
        TEST_ASSERT_TRUE((sign * v.q) < 8000);
    }
}

/*
 * d holds 6000 of 10000; the EMF alone asks for about 27000 of the 8000 left. With the integral's
 * end taken off 16384·30000/2^13 = 60000 it is still beyond the circle.
 */
TEST(test_q_integral_takes_over_what_an_emf_exceeds_the_circle_by_and_saturates_at_one)
{
    for (int32_t k = 0; k < 4; k++) {
        const int32_t sign = (k < 2) ? -1 : 1;
        const bool beyond = (k % 2) != 0;
        const int32_t speed = sign * (beyond ? 16384 : 32000);
        int32_t emf;

        cfg.emf_q13 = beyond ? 30000 : example_current_loop_cfg().emf_q13;
        emf = (int32_t)floor(speed * (cfg.emf_q13 / 8192.0));
        for (int32_t tick = 0; tick < 2000; tick++) {
            const dq_t v = (tick == 0) ? step_from((dq_t){6000, 0}, (dq_t){0, 0}, speed)
                                       : planned_step((dq_t){0, 0}, (dq_t){0, 0}, speed, 10000);

            TEST_ASSERT_EQUAL_INT32(sign * 8000, v.q);
        }
        TEST_ASSERT_EQUAL_INT64(clamp64((((int64_t)sign * 8000) - emf) * 2048, -67108864, 67108863),
                                loop.pi_q.integral_q26);
    }
}

/*
 * Motor A at 200 rad/s. The closed loop has its pole at 500 Hz: a step is complete to e^-5 < 1 %
 * after 5/(2π·500 s) = 16 ticks; the integral's zero at 50 Hz lets it overshoot by less than
 * 50/500 = 10 %, gone (to e^-5) after 5/(2π·50 s) = 160 ticks. Then 1 LSB of the error is left, as
 * the integral moves with more.
 */
TEST(test_current_step_on_a_motor_settles_as_designed_without_moving_the_other_axis)
{
    const int32_t demand = 4096; /* 5 A */
    windings_t windings = {.speed = 200.0};

    for (int32_t k = 0; k < 400; k++) {
        const dq_t measured = measure(&windings);

        drive_windings(&windings, planned_step((dq_t){0, demand}, measured,
                                               (int32_t)lround(200.0 / 981.748 * ONE), 18000));
        if (k > 16) {
            TEST_ASSERT_INT32_WITHIN((k > 200) ? 2 : (demand / 10), demand, measured.q);
            TEST_ASSERT_INT32_WITHIN((k > 200) ? 2 : (demand / 50), 0, measured.d);
        }
    }
}

static void take_over(int32_t before_d, int32_t before_q, dq_t voltage)
{
    loop.pi_d.integral_q26 = before_d;
    loop.pi_q.integral_q26 = before_q;
    current_loop_take_over(&loop, voltage);
}

/* An LSB of the voltage is 2^11 of the integral. */
TEST(test_a_voltage_that_is_taken_over_goes_to_the_integral_of_its_axis)
{
    take_over(5, -7, (dq_t){1000, -300});
    assert_integrals(5 + (1000 * 2048), -7 - (300 * 2048));
}

/* From the lower end, so that the integral's own limit takes nothing off. */
TEST(test_no_more_than_the_largest_voltage_is_taken_over)
{
    const int32_t end = 67108864;
    const int32_t most = 32767 * 2048;

    take_over(-end, -end, (dq_t){60000, 60000});
    assert_integrals(most - end, most - end);
    take_over(end - 1, end - 1, (dq_t){-60000, -60000});
    assert_integrals((end - 1) - most, (end - 1) - most);
}
