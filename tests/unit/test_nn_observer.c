/* SPDX-License-Identifier: MIT */
/* Neural-network observer: convergence on a simulated motor, its laws, its saturations. */
#include "example_cfg.h"
#include "figure.h"
#include "nn_observer.h"
#include "seeded.h"
#include "testing.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TWO_PI (6.283185307179586)
#define TURN (4294967296.0)
#define ONE (32768.0)

/* Motor A and the bases of example_cfg.h. */
#define PERIOD_S (1e-4)
#define RESISTANCE (2.125)
#define INDUCTANCE (0.0116)
#define FLUX (0.387)
#define CURRENT_BASE_A (40.0)
#define VOLTAGE_BASE_V (450.0)

/* Saturation to 28, 14, 15 and 30 bits: from −limit − 1 to limit. */
#define STATE_LIMIT (0x7FFFFFF)
#define ERROR_LIMIT (8191)
#define CURRENT_LIMIT (16383)
#define WEIGHT_STEP_LIMIT (0x1FFFFFFF)
#define LARGEST_SPEED_LIMIT (0x20000000)
#define SLOW_TICKS (10)
#define LARGEST_CORNER (0x8000000)
#define LARGEST_GRADIENT (32768) /* (8192·32768 + 8192·32768) >> 12, saturated */

/*
 * Ripple of ω̂ beside a motor of constant speed, rad/s electrical. Locked, the mean of ω̂ is the true speed,
 * for the angle is its integral. One LSB of e_q (40 A / 2^15) stands for ω̃ = e/(T·φ/L) = 0.366 rad/s.
 * Noise of e_q in LSB, each rounding spread evenly over its step: measurement 1, î 1, the sine 2 of 2^15 times the
 * flux (27330 LSB) 1.7, b >> 12 (2^12/13665 = 0.3): √(1 + 1 + 2.8 + 0.1)/√12 = 0.64 rms. The training is a low pass
 * of 1/κ = 200 samples: √(κ/2) = 0.05 of it passes, 0.012 rad/s rms; four times that is not exceeded in a run.
 */
#define SPEED_BOUND_RAD_S (0.047)

/*
 * Bias of the current model in LSB of I_b, as an angle error: R + jωL times the bias must be made up by φ·ω·sin θ̃.
 * Sine and cosine 2 of 2^15 of the flux, 1.7·√2 = 2.4; î rounded down 1, and with what its turn by half a step rounds
 * 2.5 in the resistance's drop; the decay as an integer 10^-4 of 3277 LSB = 0.4; noise of ω̂ during the 55 samples of
 * τ: 0.047 rad/s·T·27300·55/2 = 3.5.
 */
#define MODEL_BIAS_LSB (9.8)
#define LEAST_SHARE (0.1)

/*
 * One tick of training in a held state, relative: e rounded 0.5/2733, x rounded down 1/13665, b >> 12
 * rounded down 1/9117, weights as integers 0.25/600 at worst, momentum rounded to 2 steps: 10^-4.
 */
#define TRAINING_TOLERANCE (1.3e-3)
#define TRAINING_ERROR_RAD_S (1000.0) /* ω̃ that gives e_q = 2733 LSB */

static nn_observer_cfg_t cfg;
static nn_observer_t obs;
static angle_t frame; /* θ̂ */

/* At rest at angle 0, without current. */
static void begin(void)
{
    frame = 0U;
    nn_observer_start(&obs, &cfg, 0, (dq_t){0, 0}, trig_sincos(frame));
}

void setUp(void)
{
    cfg = example_observer_cfg();
    begin();
}

static double speed_rad_s(double step)
{
    return step / TURN * TWO_PI / PERIOD_S;
}

static double complex cartesian(double real, double imaginary)
{
    const union {
        double parts[2];
        double complex number;
    } z = {{real, imaginary}};

    return z.number;
}

static double complex turn_by(double angle)
{
    return cexp(cartesian(0.0, angle));
}

/* A motor of constant speed on the stationary frame, stepped exactly. */
typedef struct {
    double complex current;
    double angle;
    double speed;
} motor_t;

static void motor_step(motor_t *motor, double complex voltage)
{
    const double rate = RESISTANCE / INDUCTANCE;
    const double decay = exp(-rate * PERIOD_S);
    const double complex emf =
        cartesian(0.0, motor->speed * FLUX / INDUCTANCE) * turn_by(motor->angle);
    const double complex emf_response =
        emf * (turn_by(motor->speed * PERIOD_S) - decay) / cartesian(rate, motor->speed);

    motor->current =
        (motor->current * decay) + (voltage / RESISTANCE * (1.0 - decay)) - emf_response;
    motor->angle += motor->speed * PERIOD_S;
}

static dq_t quantised(double complex v, double base)
{
    return (dq_t){(int32_t)lround(creal(v) / base * ONE), (int32_t)lround(cimag(v) / base * ONE)};
}

static ab_t quantised_ab(double complex v, double base)
{
    const dq_t q = quantised(v, base);

    return (ab_t){q.d, q.q};
}

/* (23) and the network's forward pass. */
static void predict(dq_t measured, ab_t voltage)
{
    frame += (angle_t)obs.speed_out;
    nn_observer_predict(&obs, &cfg, measured, voltage, trig_sincos(frame));
}

static void step(dq_t measured, ab_t voltage)
{
    predict(measured, voltage);
    nn_observer_train(&obs, &cfg);
}

/* A step in which the output error is e, whatever the network's own current is. */
static void step_with_error(dq_t e)
{
    nn_observer_t probe = obs;

    nn_observer_predict(&probe, &cfg, (dq_t){0, 0}, (ab_t){0, 0},
                        trig_sincos(frame + (angle_t)obs.speed_out));
    step((dq_t){probe.current.d + e.d, probe.current.q + e.q}, (ab_t){0, 0});
}

/* The state in the rotor frame, Q27 of I_x. */
static double complex state(void)
{
    return cartesian(obs.alpha_q27, obs.beta_q27) * turn_by(-(double)frame / TURN * TWO_PI);
}

/* Put a state into a frame at angle 0. */
static void set_state(int32_t x_q27, int32_t y_q27)
{
    frame = 0U;
    obs.alpha_q27 = x_q27;
    obs.beta_q27 = y_q27;
    obs.state = (dq_t){x_q27 / 4096, y_q27 / 4096};
    obs.speed_out = 0;
}

typedef struct {
    double speed_error;  /* largest |ω̂ − ω| in the second half */
    double angle_error;  /* largest |θ̂ − θ| in the second half, degrees */
    double speed_at_end; /* ω̂ */
} run_t;

/* The observer beside a motor that carries `current_q` at `speed`; it starts at the angle, at rest. */
static run_t run_beside_motor(double speed, double current_q, int32_t ticks)
{
    const double complex voltage_dq =
        cartesian(-speed * INDUCTANCE * current_q, (RESISTANCE * current_q) + (speed * FLUX));
    motor_t motor = {.current = cartesian(0.0, current_q), .angle = 0.0, .speed = speed};
    double complex voltage = 0.0;
    run_t run = {0.0, 0.0, 0.0};

    for (int32_t k = 0; k < ticks; k++) {
        const double angle = (double)(frame + (angle_t)obs.speed_out) / TURN * TWO_PI;
        const double angle_error = remainder(angle - motor.angle, TWO_PI) / TWO_PI * 360.0;

        if (k > (ticks / 2)) {
            run.angle_error = fmax(run.angle_error, fabs(angle_error));
        }
        if ((k % SLOW_TICKS) == 0) {
            nn_observer_refresh(&obs, &cfg, 0);
        }
        step(quantised(motor.current * turn_by(-angle), CURRENT_BASE_A),
             quantised_ab(voltage, VOLTAGE_BASE_V));
        if (k > (ticks / 2)) {
            run.speed_error = fmax(run.speed_error, fabs(speed_rad_s(obs.speed) - speed));
        }
        voltage = voltage_dq * turn_by(motor.angle + (motor.speed * PERIOD_S / 2.0));
        motor_step(&motor, voltage);
    }
    run.speed_at_end = speed_rad_s(obs.speed);
    return run;
}

static double angle_bound_deg(double speed)
{
    const double impedance = RESISTANCE + (fabs(speed) * INDUCTANCE);

    return impedance * (MODEL_BIAS_LSB * CURRENT_BASE_A / ONE) / (fabs(speed) * FLUX) * 360.0 /
           TWO_PI;
}

/* A sine is within 1 LSB of 32767·sin: 2 of 2^15 of the flux, and the roundings of the products. */
#define TURN_TOLERANCE ((2.0 * 55972264.0 / 32768.0) + 4.0)

/* Two products and the flux are rounded down, the saliency's product with the share once more. */
#define GRADIENT_STATE_TOLERANCE (4.0)

/* φ/L_d + (1 − c·s)·i_d + j·(s − c)·i_q of I_x: from the start on, and not changed by a tick. */
TEST(test_with_a_frame_share_the_gradient_leaves_out_what_the_current_turns)
{
    seeded_t seed = {11U};

    for (uint32_t k = 0U; k < 1000U; k++) {
        const dq_t current = {seeded_in(&seed, -16000, 16000), seeded_in(&seed, -16000, 16000)};
        dq_t state;
        double s;
        double c;

        cfg.saliency_q13 = seeded_in(&seed, 4096, 16384);
        cfg.frame_share_q13 = seeded_in(&seed, 1, 8192);
        s = cfg.saliency_q13 / 8192.0;
        c = cfg.frame_share_q13 / 8192.0;
        nn_observer_start(&obs, &cfg, 0, current, trig_sincos(0U));
        state = obs.state;
        TEST_ASSERT_DOUBLE_WITHIN(GRADIENT_STATE_TOLERANCE,
                                  (cfg.flux_q27 / 4096.0) +
                                      ((1.0 - (c * s)) * current.d / exp2(cfg.current_shift)),
                                  state.d);
        TEST_ASSERT_DOUBLE_WITHIN(GRADIENT_STATE_TOLERANCE,
                                  (s - c) * current.q / exp2(cfg.current_shift), state.q);
        nn_observer_predict(&obs, &cfg, current, (ab_t){0, 0}, trig_sincos(0U));
        TEST_ASSERT_EQUAL_INT32(state.d, obs.state.d);
        TEST_ASSERT_EQUAL_INT32(state.q, obs.state.q);
    }
}

/* Without saliency and with the whole share it is the flux, and a tick's b is e'_q·φ/L_d, whatever the current. */
TEST(test_with_the_whole_share_the_gradient_of_a_round_motor_does_not_follow_the_current)
{
    static const int32_t currents[] = {-12000, 0, 12000};

    cfg.frame_share_q13 = 8192;
    cfg.saliency_q13 = 8192;
    for (uint32_t k = 0U; k < 9U; k++) {
        const dq_t current = {currents[k % 3U], currents[k / 3U]};

        nn_observer_start(&obs, &cfg, 0, current, trig_sincos(0U));
        nn_observer_refresh(&obs, &cfg, 0);
        TEST_ASSERT_EQUAL_INT32(cfg.flux_q27 / 4096, obs.state.d);
        TEST_ASSERT_EQUAL_INT32(0, obs.state.q);
        nn_observer_predict(&obs, &cfg, (dq_t){current.d, current.q + 400}, (ab_t){0, 0},
                            trig_sincos(0U));
        TEST_ASSERT_EQUAL_INT32(
            fx_sat16(fx_asr(obs.rotated_error.q * (cfg.flux_q27 / 4096), cfg.gradient_shift)),
            obs.gradient);
    }
}

TEST(test_the_gradient_state_follows_the_current_of_the_last_refresh)
{
    static const int32_t shares[] = {1, 8192};

    cfg.saliency_q13 = 16384;
    for (uint32_t k = 0U; k < 2U; k++) {
        dq_t after_start;

        cfg.frame_share_q13 = shares[k];
        nn_observer_start(&obs, &cfg, 0, (dq_t){3000, -5000}, trig_sincos(0U));
        after_start = obs.state;
        nn_observer_start(&obs, &cfg, 0, (dq_t){0, 0}, trig_sincos(0U));
        obs.current = (dq_t){3000, -5000};
        nn_observer_refresh(&obs, &cfg, 0);
        TEST_ASSERT_EQUAL_INT32(after_start.d, obs.state.d);
        TEST_ASSERT_EQUAL_INT32(after_start.q, obs.state.q);
    }
    cfg.frame_share_q13 = 0;
    obs.state = (dq_t){1, 2};
    nn_observer_refresh(&obs, &cfg, 0);
    TEST_ASSERT_EQUAL_INT32(1, obs.state.d);
    TEST_ASSERT_EQUAL_INT32(2, obs.state.q);
}

/* L_q/L_d = 4 and currents at full scale: 3·16384 and more. */
TEST(test_the_gradient_state_stays_within_its_format)
{
    cfg.frame_share_q13 = 8192;
    cfg.saliency_q13 = 32767;
    cfg.current_shift = 0U;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        cfg.flux_q27 = (sign > 0) ? 0x7FFFFFF : 1;
        nn_observer_start(&obs, &cfg, 0, (dq_t){-sign * 16383, sign * 16383}, trig_sincos(0U));
        TEST_ASSERT_EQUAL_INT32(sign * 46341, obs.state.d);
        TEST_ASSERT_EQUAL_INT32(sign * 46341, obs.state.q);
    }
}

TEST(test_start_at_rest_has_the_flux_along_the_d_axis_and_no_current)
{
    for (uint32_t k = 0U; k < 32U; k++) {
        const double complex flux = cfg.flux_q27 * turn_by(k * TWO_PI / 32.0);

        memset(&obs, 0x5A, sizeof obs);
        nn_observer_start(&obs, &cfg, 0, (dq_t){0, 0}, trig_sincos(k << 27U));
        TEST_ASSERT_DOUBLE_WITHIN(TURN_TOLERANCE, creal(flux), obs.alpha_q27);
        TEST_ASSERT_DOUBLE_WITHIN(TURN_TOLERANCE, cimag(flux), obs.beta_q27);
        TEST_ASSERT_EQUAL_INT32(cfg.flux_q27 / 4096, obs.state.d);
        TEST_ASSERT_EQUAL_INT32(0, obs.state.q);
        TEST_ASSERT_EQUAL_INT32(0, obs.speed);
        TEST_ASSERT_EQUAL_INT32(0, obs.speed_out);
        TEST_ASSERT_EQUAL_INT32(0, obs.weight_step);
        TEST_ASSERT_EQUAL_INT32(0, obs.current.d);
        TEST_ASSERT_EQUAL_INT32(0, obs.current.q);
        TEST_ASSERT_EQUAL_INT32(0, obs.error.d);
        TEST_ASSERT_EQUAL_INT32(0, obs.error.q);
    }
}

TEST(test_estimates_find_a_motor_already_running_and_follow_it)
{
    static const double speeds[] = {377.0, -377.0, 200.0, -200.0, 60.0, -60.0};
    double worst_speed = 0.0;
    double worst_angle = 0.0;

    for (uint32_t i = 0U; i < (2U * (sizeof speeds / sizeof speeds[0])); i++) {
        const double speed = speeds[i / 2U];
        const double current = ((i % 2U) == 0U) ? 0.0 : 4.0;
        run_t run = {0.0, 0.0, 0.0};

        begin();
        run = run_beside_motor(speed, current, 40000);
        worst_speed = fmax(worst_speed, run.speed_error);
        worst_angle = fmax(worst_angle, run.angle_error / angle_bound_deg(speed));
    }
    figure_check("speed ripple, rad/s", worst_speed, SPEED_BOUND_RAD_S, LEAST_SHARE);
    figure_check("angle error as a share of its bound", worst_angle, 1.0, LEAST_SHARE);
}

TEST(test_published_law_follows_a_motor_with_exact_parameters)
{
    /* κ = 0.03 lets √(0.03/0.005) times the noise through, and its damping is low: as much again. */
    const double bound = 2.0 * 2.45 * SPEED_BOUND_RAD_S;
    run_t run = {0.0, 0.0, 0.0};

    cfg.eta = 28788;
    cfg.eta_shift = 7U;
    cfg.kappa_p = 0;
    begin();
    obs.speed =
        25783200; /* 377.2 rad/s: the law has no damping to start from rest beside this motor */
    obs.speed_out = obs.speed;
    run = run_beside_motor(377.0, 4.0, 40000);
    figure_check("published law, speed ripple, rad/s", run.speed_error, bound, LEAST_SHARE / 2.0);
}

TEST(test_standstill_without_current_stays_exactly_at_rest)
{
    const run_t run = run_beside_motor(0.0, 0.0, 100000);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, run.speed_error);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, run.angle_error);
}

TEST(test_standstill_with_current_keeps_the_speed_within_the_ripple)
{
    const run_t run = run_beside_motor(0.0, 4.0, 40000);

    TEST_ASSERT_TRUE(run.speed_error <= SPEED_BOUND_RAD_S);
}

TEST(test_speed_turns_the_flux_backwards_in_the_frame_that_runs_forwards)
{
    /* ŷ(k) = … + W2·x̂ with W2 = −T·ω̂: −0.02 rad of 13665 in Q15 of I_x, rounded down. */
    obs.speed_out = 13671306; /* 0.02 rad a tick */
    step((dq_t){0, 0}, (ab_t){0, 0});
    TEST_ASSERT_INT32_WITHIN(2, -(int32_t)lround(sin(0.02) * 13665.0), obs.state.q);
    TEST_ASSERT_TRUE(obs.error.q > 0);
}

TEST(test_voltage_drives_its_own_axis_by_the_gain)
{
    const int32_t drive = (int32_t)(((int64_t)cfg.volt_gain * 10000) / 128); /* weight_shift = 7 */
    const int32_t alpha = obs.alpha_q27;

    predict((dq_t){0, 0}, (ab_t){0, 10000});
    TEST_ASSERT_EQUAL_INT32(drive, obs.beta_q27);
    TEST_ASSERT_EQUAL_INT32(alpha, obs.alpha_q27);
    begin();
    predict((dq_t){0, 0}, (ab_t){10000, 0});
    TEST_ASSERT_EQUAL_INT32(alpha + drive, obs.alpha_q27);
    TEST_ASSERT_EQUAL_INT32(0, obs.beta_q27);
}

TEST(test_resistance_takes_from_the_current_of_the_last_instant)
{
    /* decay·1000 / 2^7 at standstill; turned through angle 0 by a cosine of 32767: 0.03 of 1000. */
    const double drop = cfg.decay * 1000.0 / 128.0;

    obs.current = (dq_t){1000, -1000};
    set_state(cfg.flux_q27, 0);
    predict((dq_t){0, 0}, (ab_t){0, 0});
    TEST_ASSERT_DOUBLE_WITHIN((cfg.decay / 128.0) + 1.0, cfg.flux_q27 - drop, obs.alpha_q27);
    TEST_ASSERT_DOUBLE_WITHIN((cfg.decay / 128.0) + 1.0, drop, obs.beta_q27);
}

/* At speed the current of the middle is that of the rotor half a step ago: turned back by half a step's angle. */
TEST(test_resistance_acts_in_the_middle_of_the_turn)
{
    for (int32_t k = -7; k <= 7; k++) {
        const double delta = k / 10.0;
        const double complex middle = cartesian(16000.0, 4000.0) * turn_by(delta / 2.0);
        const double share = cfg.decay / 128.0;
        /* 1 − jh for its exponential: h²/2 long, h³/3 off; h rounded; currents rounded, 2. */
        const double h = fabs(delta) / 2.0;
        const double bound =
            share * ((16500.0 * ((h * h / 2.0) + (h * h * h / 3.0) + 1e-4)) + 2.0) + 1.0;

        begin();
        set_state(cfg.flux_q27, 0);
        obs.current = (dq_t){16000, 4000};
        obs.speed = (step_t)lround(delta / TWO_PI * TURN);
        nn_observer_refresh(&obs, &cfg, 0);
        obs.speed_out = obs.speed;
        predict((dq_t){0, 0}, (ab_t){0, 0});
        TEST_ASSERT_DOUBLE_WITHIN(bound, cfg.flux_q27 - (share * creal(middle)), obs.alpha_q27);
        TEST_ASSERT_DOUBLE_WITHIN(bound, -share * cimag(middle), obs.beta_q27);
    }
}

TEST(test_current_output_is_in_the_base_of_the_measurement)
{
    /*
     * 1000 LSB of I_b = 500 of I_x in Q15. L_d/L_q = ½ halves i_q. A cosine of 32767 leaves out 2^-15 of 13165 in
     * Q15 of I_x, 0.8 of I_b; rounded down once in d, twice in q.
     */
    cfg.iq_gain_q14 = 8192;
    set_state(cfg.flux_q27 - (500 * 4096), 500 * 4096);
    predict((dq_t){100, 200}, (ab_t){0, 0});
    TEST_ASSERT_INT32_WITHIN(2, -1000, obs.current.d);
    TEST_ASSERT_INT32_WITHIN(2, 500, obs.current.q);
    TEST_ASSERT_EQUAL_INT32(100 - obs.current.d, obs.error.d);
    TEST_ASSERT_EQUAL_INT32(200 - obs.current.q, obs.error.q);
}

TEST(test_current_output_saturates_to_15_bits_on_both_sides)
{
    cfg.current_shift = 3U; /* eight times I_b */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        set_state(sign * 0x7000000, -sign * 0x7000000);
        predict((dq_t){0, 0}, (ab_t){0, 0});
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? 16383 : -16384, obs.current.d);
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? -16384 : 16383, obs.current.q);
        begin();
    }
}

/* One tick of training on a constant error, with the network's state held: flux, at rest. */
static void train_once(int32_t error_q)
{
    set_state(cfg.flux_q27, 0);
    obs.current = (dq_t){0, 0};
    step((dq_t){0, error_q}, (ab_t){0, 0});
}

/* e_q of a motor that is faster than the network by ω̃, after one sample. */
static int32_t error_of(double speed_error)
{
    return (int32_t)lround(-speed_error * PERIOD_S * FLUX / INDUCTANCE / CURRENT_BASE_A * ONE);
}

TEST(test_kappa_is_the_share_of_the_speed_error_removed_in_a_sample)
{
    train_once(error_of(TRAINING_ERROR_RAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.005 * TRAINING_ERROR_RAD_S * TRAINING_TOLERANCE,
                              0.005 * TRAINING_ERROR_RAD_S, speed_rad_s(obs.speed));
    begin();
    train_once(error_of(-TRAINING_ERROR_RAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.005 * TRAINING_ERROR_RAD_S * TRAINING_TOLERANCE,
                              -0.005 * TRAINING_ERROR_RAD_S, speed_rad_s(obs.speed));
}

TEST(test_training_goes_down_along_both_errors)
{
    /* b = e_q·x̂ − e_d·ŷ with x̂ = 8192, ŷ = 4096 in Q15 of I_x, held: b >> 12 = 2·e_q − e_d. */
    static const dq_t errors[] = {{400, 0},  {0, 400},    {-400, 0},
                                  {0, -400}, {400, -200}, {400, 200}};
    static const int32_t gradients[] = {-400, 800, 400, -800, -800, 0};

    cfg.flux_q27 = 8192 * 4096;
    for (uint32_t i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        begin();
        set_state(8192 * 4096, 4096 * 4096);
        step_with_error(errors[i]);
        TEST_ASSERT_EQUAL_INT32(gradients[i], obs.gradient);
        TEST_ASSERT_EQUAL_INT32(-lrint(floor(gradients[i] * 19192 / 512.0)), obs.speed);
        TEST_ASSERT_EQUAL_INT32(-lrint(floor(gradients[i] * 23990 / 32.0)),
                                obs.speed_out - obs.speed);
    }
}

/* As above with b >> 4: 2^8 times as much, where small states leave room. */
TEST(test_the_gradient_keeps_more_bits_where_it_is_told_to)
{
    cfg.flux_q27 = 32 * 4096;
    cfg.gradient_shift = 4U;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        set_state(32 * 4096, 16 * 4096);
        step_with_error((dq_t){sign * 400, sign * 200});
        /* 200·32 − 400·16 = 0; along q alone 400·32/16. */
        TEST_ASSERT_EQUAL_INT32(0, obs.gradient);
        begin();
        set_state(32 * 4096, 16 * 4096);
        step_with_error((dq_t){0, sign * 400});
        TEST_ASSERT_EQUAL_INT32(sign * 800, obs.gradient);
    }
}

TEST(test_kappa_with_momentum_is_reached_once_the_momentum_has_built_up)
{
    static const double alphas[] = {0.5, 0.9, 0.96875};

    for (uint32_t i = 0U; i < 3U; i++) {
        cfg.momentum_q15 = (int32_t)lround(alphas[i] * ONE);
        cfg.eta = (int32_t)lround(19192.0 * (1.0 - alphas[i]));
        begin();
        /* α^n: after 400 ticks 3·10^-6 of the build-up is left at the largest α. */
        for (int32_t k = 0; k < 400; k++) {
            obs.speed = 0;
            train_once(error_of(TRAINING_ERROR_RAD_S));
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.005 * TRAINING_ERROR_RAD_S * TRAINING_TOLERANCE,
                                  0.005 * TRAINING_ERROR_RAD_S, speed_rad_s(obs.speed));
    }
}

TEST(test_momentum_hands_out_one_error_over_many_samples_but_no_more_in_all)
{
    /* Rounded down to even steps each tick: at most 2 a tick, each handed on 1/(1 − α) = 2 times. */
    const int32_t ticks = 40;
    const int32_t tolerance = 2 * 2 * ticks;
    int32_t whole = 0;

    train_once(-2733);
    whole = obs.speed;
    cfg.momentum_q15 = 16384;
    cfg.eta /= 2;
    begin();
    train_once(-2733);
    TEST_ASSERT_INT32_WITHIN(1, whole / 2, obs.speed);
    for (int32_t k = 0; k < ticks; k++) {
        train_once(0);
    }
    TEST_ASSERT_INT32_WITHIN(tolerance, whole, obs.speed);
}

TEST(test_proportional_path_adds_its_share_to_the_inner_speed_only)
{
    train_once(error_of(TRAINING_ERROR_RAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * TRAINING_ERROR_RAD_S * TRAINING_TOLERANCE,
                              0.1 * TRAINING_ERROR_RAD_S,
                              speed_rad_s((double)obs.speed_out - obs.speed));
    TEST_ASSERT_DOUBLE_WITHIN(0.005 * TRAINING_ERROR_RAD_S * TRAINING_TOLERANCE,
                              0.005 * TRAINING_ERROR_RAD_S, speed_rad_s(obs.speed));
}

TEST(test_without_the_proportional_path_the_inner_speed_is_the_integral_bit_by_bit)
{
    seeded_t seed = {0x0DDBA11U};
    nn_observer_t other = obs;
    nn_observer_cfg_t other_cfg;

    cfg.kappa_p = 0;
    other_cfg = cfg;
    other_cfg.kappa_p_shift = 1U;
    for (int32_t i = 0; i < 50000; i++) {
        const dq_t measured = {seeded_in(&seed, -9000, 9000), seeded_in(&seed, -9000, 9000)};
        const ab_t voltage = {seeded_in(&seed, -20000, 20000), seeded_in(&seed, -20000, 20000)};

        step(measured, voltage);
        nn_observer_predict(&other, &other_cfg, measured, voltage, trig_sincos(frame));
        nn_observer_train(&other, &other_cfg);
        TEST_ASSERT_EQUAL_INT32(obs.speed, obs.speed_out);
    }
    TEST_ASSERT_EQUAL_MEMORY(&obs, &other, sizeof obs);
}

static void assert_within(int32_t limit, int32_t value)
{
    TEST_ASSERT_TRUE((value <= limit) && (value >= (-limit - 1)));
}

static void assert_ranges(void)
{
    /* Rounded down, towards −∞: one more on that side. */
    const int64_t share = (((int64_t)LARGEST_GRADIENT * cfg.kappa_p) >> cfg.kappa_p_shift) + 1;

    assert_within(STATE_LIMIT, obs.alpha_q27);
    assert_within(STATE_LIMIT, obs.beta_q27);
    assert_within(CURRENT_LIMIT, obs.current.d);
    assert_within(CURRENT_LIMIT, obs.current.q);
    assert_within(FX_Q15_MAX, obs.gradient);
    assert_within(ERROR_LIMIT, obs.error.d);
    assert_within(ERROR_LIMIT, obs.error.q);
    assert_within(ERROR_LIMIT, obs.rotated_error.d);
    assert_within(ERROR_LIMIT, obs.rotated_error.q);
    TEST_ASSERT_TRUE(abs(obs.rho_q13) <= cfg.rho_max_q13);
    assert_within(WEIGHT_STEP_LIMIT, obs.weight_step);
    TEST_ASSERT_TRUE(abs(obs.speed) <= cfg.speed_limit);
    TEST_ASSERT_TRUE(llabs((int64_t)obs.speed_out - obs.speed) <= share);
}

TEST(test_integral_speed_stops_at_its_limit_and_the_proportional_path_goes_beyond_it)
{
    const int32_t x = cfg.flux_q27 / 4096;

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const double gradient = floor(-sign * 8000.0 * x / 4096.0);

        begin();
        for (int32_t k = 0; k < 2000; k++) {
            train_once(-sign * 8000);
        }
        TEST_ASSERT_EQUAL_INT32(sign * cfg.speed_limit, obs.speed);
        TEST_ASSERT_EQUAL_INT32(-lrint(floor(gradient * cfg.kappa_p / 32.0)),
                                obs.speed_out - obs.speed);
        TEST_ASSERT_TRUE(abs(obs.speed_out) > cfg.speed_limit);
    }
}

/* (22) alone: the largest step, 2^30 less what rounding takes, from one end of the speed to near the other. */
TEST(test_without_momentum_the_weight_step_is_not_cut)
{
    cfg.momentum_q15 = 0;
    cfg.eta = 32767;
    cfg.eta_shift = 0U;
    cfg.kappa_p = 0;
    cfg.speed_limit = LARGEST_SPEED_LIMIT;
    obs.speed = -LARGEST_SPEED_LIMIT;
    obs.gradient = -LARGEST_GRADIENT;
    nn_observer_train(&obs, &cfg);
    TEST_ASSERT_EQUAL_INT32(-LARGEST_SPEED_LIMIT + (LARGEST_GRADIENT * 32767), obs.speed);
}

TEST(test_inner_speed_saturates_to_30_bits_on_both_sides)
{
    cfg.eta = 0;
    cfg.kappa_p = 32767;
    cfg.kappa_p_shift = 0U;
    obs.gradient = -LARGEST_GRADIENT;
    nn_observer_train(&obs, &cfg);
    TEST_ASSERT_EQUAL_INT32(WEIGHT_STEP_LIMIT, obs.speed_out);
    obs.gradient = LARGEST_GRADIENT - 1;
    nn_observer_train(&obs, &cfg);
    TEST_ASSERT_EQUAL_INT32(-WEIGHT_STEP_LIMIT - 1, obs.speed_out);
}

TEST(test_errors_saturate_to_14_bits_on_both_sides)
{
    static const int32_t currents[] = {8190, 8191, 8192, 65535, -8190, -8191, -8192, -8193, -65535};
    static const int32_t errors[] = {8190, 8191, 8191, 8191, -8190, -8191, -8192, -8192, -8192};

    cfg.eta = 0;
    cfg.kappa_p = 0;
    for (uint32_t i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        step_with_error((dq_t){currents[i], 0});
        TEST_ASSERT_EQUAL_INT32(errors[i], obs.error.d);
        TEST_ASSERT_EQUAL_INT32(0, obs.error.q);
        step_with_error((dq_t){0, currents[i]});
        TEST_ASSERT_EQUAL_INT32(0, obs.error.d);
        TEST_ASSERT_EQUAL_INT32(errors[i], obs.error.q);
    }
}

TEST(test_states_saturate_to_28_bits_on_both_sides)
{
    cfg.decay = 0;
    cfg.eta = 0;
    cfg.kappa_p = 0;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t upper = STATE_LIMIT;
        const int32_t lower = -STATE_LIMIT - 1;

        begin();
        for (int32_t k = 0; k < 100; k++) {
            step((dq_t){0, 0}, (ab_t){sign * 32767, -sign * 32767});
        }
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? upper : lower, obs.alpha_q27);
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? lower : upper, obs.beta_q27);
    }
}

TEST(test_weight_step_with_momentum_saturates_to_30_bits_on_both_sides)
{
    /* 6829·32767 a tick, of which the momentum keeps nearly all: beyond 2^29 in the third. */
    cfg.eta = 32767;
    cfg.eta_shift = 0U;
    cfg.momentum_q15 = 32767;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        train_once(sign * 2047);
        train_once(sign * 2047);
        TEST_ASSERT_TRUE(abs(obs.weight_step) < WEIGHT_STEP_LIMIT);
        TEST_ASSERT_TRUE(abs(obs.weight_step) > (WEIGHT_STEP_LIMIT / 2));
        train_once(sign * 2047);
        TEST_ASSERT_EQUAL_INT32((sign > 0) ? WEIGHT_STEP_LIMIT : (-WEIGHT_STEP_LIMIT - 1),
                                obs.weight_step);
    }
}

/* Twice 13665 in Q15 of I_x, times e_q, >> 12: 4910 give ±32761.6 and 4911 ±32768.3, rounded down. */
TEST(test_gradient_saturates_to_16_bits_on_both_sides)
{
    static const int32_t errors[] = {4910, 4911, 8191, -4910, -4911, -8191};
    static const int32_t gradients[] = {32761, 32767, 32767, -32762, -32768, -32768};

    cfg.flux_q27 = 2 * 13665 * 4096;
    cfg.speed_limit = LARGEST_SPEED_LIMIT;
    for (uint32_t i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        begin();
        train_once(errors[i]);
        TEST_ASSERT_EQUAL_INT32(-lrint(floor(gradients[i] * 19192 / 512.0)), obs.speed);
        TEST_ASSERT_EQUAL_INT32(-lrint(floor(gradients[i] * 23990 / 32.0)),
                                obs.speed_out - obs.speed);
    }
}

/* The configuration whose products are largest within what config_check accepts. */
static nn_observer_cfg_t largest_cfg(seeded_t *seed)
{
    return (nn_observer_cfg_t){
        .decay = 32767,
        .volt_gain = 32767,
        .weight_shift = (uint32_t)seeded_in(seed, 2, 15),
        .feedback_q15 = ((seeded_u32(seed) & 1U) != 0U) ? seeded_in(seed, 0, 32767) : 0,
        .flux_q27 = ((seeded_u32(seed) & 1U) != 0U) ? STATE_LIMIT : 1,
        .iq_gain_q14 = ((seeded_u32(seed) & 1U) != 0U) ? 32767 : 1,
        .saliency_q13 = ((seeded_u32(seed) & 1U) != 0U) ? 32767 : 1,
        .corner = ((seeded_u32(seed) & 1U) != 0U) ? LARGEST_CORNER : 0,
        .rho_max_q13 = ((seeded_u32(seed) & 1U) != 0U) ? 32767 : 0,
        .rho_speed_min = 1,
        .current_shift = (uint32_t)seeded_in(seed, 0, 9),
        .gradient_shift = (uint32_t)seeded_in(seed, 4, 12),
        .eta = 32767,
        .eta_shift = (uint32_t)seeded_in(seed, 0, 30),
        .kappa_p = 32767,
        .kappa_p_shift = (uint32_t)seeded_in(seed, 0, 30),
        .momentum_q15 = ((seeded_u32(seed) & 1U) != 0U) ? 32767 : 0,
        .speed_limit = ((seeded_u32(seed) & 1U) != 0U) ? LARGEST_SPEED_LIMIT : 1,
    };
}

/* Mostly an end of ±limit. */
static int32_t extreme(seeded_t *seed, int32_t limit)
{
    const int32_t choice = seeded_in(seed, 0, 3);
    int32_t value = limit;

    if (choice == 0) {
        value = -limit;
    } else if (choice == 1) {
        value = seeded_in(seed, -limit, limit);
    }
    return value;
}

TEST(test_states_speeds_and_errors_stay_in_range_for_extreme_inputs_and_weights)
{
    seeded_t seed = {0xFEEDFACEU};

    for (int32_t run = 0; run < 200; run++) {
        cfg = largest_cfg(&seed);
        begin();
        for (int32_t k = 0; k < 500; k++) {
            const dq_t measured = {extreme(&seed, 65535), extreme(&seed, 65535)};
            const ab_t voltage = {extreme(&seed, 32767), extreme(&seed, 32767)};

            frame += seeded_u32(&seed); /* any angle, also one that no speed explains */
            predict(measured, voltage);
            if (seeded_in(&seed, 0, 7) == 0) {
                nn_observer_follow(&obs, extreme(&seed, cfg.speed_limit));
                TEST_ASSERT_EQUAL_INT32(obs.speed, obs.speed_out);
            } else {
                nn_observer_train(&obs, &cfg);
            }
            nn_observer_refresh(&obs, &cfg, extreme(&seed, 0x40000000));
            assert_ranges();
        }
    }
}

/* ---- rotation ---- */

/* Weights off: nothing but the frame moves. */
static void use_rotation_alone(void)
{
    cfg.decay = 0;
    cfg.eta = 0;
    cfg.kappa_p = 0;
}

static step_t step_of(double radians)
{
    return (step_t)lround(radians / TWO_PI * TURN);
}

/*
 * A state s in the frame beside the exact one, Q15 of I_x: sine and cosine are within 2 of 2^15 of the exact ones, in
 * both products; products and state rounded down, 1.
 */
TEST(test_the_frame_sees_its_state_turned_exactly_at_every_speed)
{
    seeded_t seed = {0x707A7EU};
    double worst = 0.0;

    use_rotation_alone();
    for (int32_t k = 0; k < 50000; k++) {
        const double complex start = (double)seeded_in(&seed, 1000000, STATE_LIMIT - 10000) *
                                     turn_by(seeded_in(&seed, 0, 6283) / 1000.0);
        const double bound = (cabs(start) / 4096.0 * 2.0 * 1.4143 / 32768.0) + 1.1;
        double complex exact = 0.0;

        set_state((int32_t)lround(creal(start)), (int32_t)lround(cimag(start)));
        frame = seeded_u32(&seed);
        obs.speed_out = step_of(seeded_in(&seed, -785, 785) / 1000.0);
        predict((dq_t){0, 0}, (ab_t){0, 0});
        exact = state() / 4096.0;
        worst = fmax(worst, fabs(creal(exact) - obs.state.d) / bound);
        worst = fmax(worst, fabs(cimag(exact) - obs.state.q) / bound);
    }
    figure_check("state in the frame, as a share of its bound", worst, 1.0, 0.3);
}

TEST(test_without_weights_the_state_stays_bit_by_bit_at_any_speed)
{
    use_rotation_alone();
    for (int32_t k = -70; k <= 70; k++) {
        begin();
        set_state(12345678, -87654321);
        obs.speed_out = step_of(k / 100.0);
        obs.speed = obs.speed_out;
        for (int32_t tick = 0; tick < 10000; tick++) {
            step((dq_t){0, 0}, (ab_t){0, 0});
        }
        TEST_ASSERT_EQUAL_INT32(12345678, obs.alpha_q27);
        TEST_ASSERT_EQUAL_INT32(-87654321, obs.beta_q27);
    }
}

/* Forward Euler would have grown by √(1 + Δ²) a tick here; 1/τ of motor A is 0.018 a tick. */
TEST(test_resistance_makes_the_network_forget_at_the_largest_speed)
{
    double complex settled[2] = {0.0, 0.0};

    cfg.eta = 0;
    cfg.kappa_p = 0;
    for (int32_t run = 0; run < 2; run++) {
        begin();
        set_state(cfg.flux_q27, (run == 0) ? 0 : 50000000);
        obs.speed_out = step_of(0.7);
        obs.speed = obs.speed_out;
        for (int32_t k = 0; k < 2000; k++) {
            step((dq_t){0, 0}, (ab_t){0, 0});
        }
        settled[run] = state();
    }
    /* e^-36 is left; a LSB of the current, 2048, rounded in both runs against each other. */
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * 2048.0, 0.0, cabs(settled[1] - settled[0]));
}

/* ---- feedback ---- */

/* T·R/L + f in the weights; returns what the integers stand for. */
static double use_feedback(double feedback)
{
    const double decay = (PERIOD_S * RESISTANCE / INDUCTANCE) + feedback;

    cfg.decay = (int32_t)lround(decay / 2.0 * 524288.0); /* I_b/I_x, 2^19 */
    cfg.feedback_q15 = (int32_t)lround(feedback / decay * ONE);
    cfg.corner = (step_t)lround(decay / TWO_PI * TURN);
    return cfg.decay * 2.0 / 524288.0;
}

/* The network alone at a given turn in a tick, with the motor's EMF and a voltage error: the error's shadow in the state. */
static double complex state_after(double turn, double complex start, double complex excess,
                                  int32_t ticks)
{
    const double complex voltage = cartesian(0.0, turn / PERIOD_S * FLUX) + excess;

    begin();
    set_state(cfg.flux_q27 + (int32_t)lround(creal(start)), (int32_t)lround(cimag(start)));
    obs.current =
        (dq_t){(int32_t)lround(creal(start) / 2048.0), (int32_t)lround(cimag(start) / 2048.0)};
    obs.error = (dq_t){-obs.current.d, -obs.current.q};
    nn_observer_follow(&obs, step_of(turn));
    nn_observer_refresh(&obs, &cfg, step_of(turn));
    for (int32_t k = 0; k < ticks; k++) {
        const double middle = ((double)frame / TURN * TWO_PI) + (turn / 2.0);

        predict((dq_t){0, 0}, quantised_ab(voltage * turn_by(middle), VOLTAGE_BASE_V));
        nn_observer_follow(&obs, step_of(turn));
    }
    return state();
}

/* Two networks beside the same motor, one 5 A off: what is left between them after 20 ticks. */
#define APART_Q27 (8388608.0)
/*
 * Of each tick in each: î rounded, its share of the measured current, its turn and the voltage, 6 LSB of 2048 times D; the
 * state and the sine's 2^-15 of what is apart. All decays with D.
 */
static double apart_bound(double decay)
{
    return 2.0 * ((6.0 * 2048.0) + ((2.0 + (4.0 * APART_Q27 / ONE)) / decay * 0.1));
}

TEST(test_an_error_of_the_network_turns_with_the_speed_and_decays_with_the_feedback)
{
    static const double feedbacks[] = {0.0, 0.03, 0.1 - 0.01832};
    static const double turns[] = {0.0, 0.0377, -0.0377};

    for (uint32_t i = 0U; i < 9U; i++) {
        const double turn = turns[i / 3U];
        const double decay = use_feedback(feedbacks[i % 3U]);
        /* The current of k − 1, turned by half a step as 1 − jh. */
        const double complex kept = turn_by(-turn) - (decay * cartesian(1.0, -turn / 2.0));
        const double complex apart =
            state_after(turn, APART_Q27, 0.0, 20) - state_after(turn, 0.0, 0.0, 20);
        const double complex expected = APART_Q27 * cpow(kept, 20.0);

        TEST_ASSERT_DOUBLE_WITHIN(apart_bound(decay), 0.0, cabs(apart - expected));
        TEST_ASSERT_TRUE(cabs(apart) < (APART_Q27 * pow(1.001 - decay, 20.0)));
    }
}

TEST(test_without_feedback_no_measured_current_reaches_the_network)
{
    seeded_t seed = {0xF33DU};
    nn_observer_t other;

    for (int32_t k = 0; k < 2000; k++) {
        const dq_t measured = {seeded_in(&seed, -8000, 8000), seeded_in(&seed, -8000, 8000)};
        const ab_t voltage = {seeded_in(&seed, -9000, 9000), seeded_in(&seed, -9000, 9000)};

        obs.error = (dq_t){0, 0};
        other = obs;
        other.error = (dq_t){seeded_in(&seed, -8192, 8191), seeded_in(&seed, -8192, 8191)};
        frame += (angle_t)obs.speed_out;
        nn_observer_predict(&obs, &cfg, measured, voltage, trig_sincos(frame));
        nn_observer_predict(&other, &cfg, measured, voltage, trig_sincos(frame));
        TEST_ASSERT_EQUAL_MEMORY(&obs, &other, sizeof obs);
        nn_observer_follow(&obs, seeded_in(&seed, -20000000, 20000000));
    }
}

/* e = −ε/(R_v + jωL) of 30 V, and e' = −ε/(jωL): ρ turns by the same corner. */
TEST(test_a_voltage_error_stands_over_the_virtual_impedance_and_rho_turns_it_back)
{
    static const double speeds[] = {300.0, -300.0, 377.0, -377.0};
    const double volts_to_lsb = ONE / CURRENT_BASE_A;

    cfg.rho_max_q13 = 32767;
    for (uint32_t i = 0U; i < 8U; i++) {
        const double speed = speeds[i / 2U];
        const double decay = use_feedback(0.1 - 0.01832);
        const double complex error = ((i % 2U) == 0U) ? 30.0 : cartesian(0.0, 30.0);
        const double complex e =
            -error * volts_to_lsb / cartesian(decay * INDUCTANCE / PERIOD_S, speed * INDUCTANCE);
        const double complex turned = -error * volts_to_lsb / cartesian(0.0, speed * INDUCTANCE);
        const double rho = fabs(decay / (speed * PERIOD_S));

        (void)state_after(speed * PERIOD_S, 0.0, error, 400);
        TEST_ASSERT_DOUBLE_WITHIN(MODEL_BIAS_LSB, creal(e), obs.error.d);
        TEST_ASSERT_DOUBLE_WITHIN(MODEL_BIAS_LSB, cimag(e), obs.error.q);
        TEST_ASSERT_DOUBLE_WITHIN(MODEL_BIAS_LSB * (1.0 + rho), creal(turned), obs.rotated_error.d);
        TEST_ASSERT_DOUBLE_WITHIN(MODEL_BIAS_LSB * (1.0 + rho), cimag(turned), obs.rotated_error.q);
    }
}

/* ---- a given speed, a start ---- */

TEST(test_a_given_speed_is_taken_over_whole_and_trains_nothing)
{
    seeded_t seed = {0xF0110U};

    cfg.momentum_q15 = 16384;
    train_once(error_of(TRAINING_ERROR_RAD_S));
    TEST_ASSERT_TRUE((obs.weight_step != 0) && (obs.speed != obs.speed_out));
    for (int32_t k = 0; k < 1000; k++) {
        const step_t speed = seeded_in(&seed, -cfg.speed_limit, cfg.speed_limit);

        nn_observer_follow(&obs, speed);
        TEST_ASSERT_EQUAL_INT32(speed, obs.speed);
        TEST_ASSERT_EQUAL_INT32(speed, obs.speed_out);
        TEST_ASSERT_EQUAL_INT32(0, obs.weight_step);
    }
}

/* Motor of constant speed and known angle: what is left of the errors is the bias of the model. */
TEST(test_with_speed_and_angle_given_the_network_reproduces_the_current)
{
    static const double speeds[] = {377.0, -377.0, 100.0, -10.0, 0.0};
    double worst = 0.0;

    for (uint32_t i = 0U; i < (sizeof speeds / sizeof speeds[0]); i++) {
        const double speed = speeds[i];
        const double complex voltage_dq =
            cartesian(-speed * INDUCTANCE * 4.0, (RESISTANCE * 4.0) + (speed * FLUX));
        const step_t advance = step_of(speed * PERIOD_S);
        motor_t motor = {.current = cartesian(0.0, 4.0), .angle = 0.0, .speed = speed};
        double complex voltage = 0.0;

        frame = 0U - (angle_t)advance;
        nn_observer_start(&obs, &cfg, advance, (dq_t){0, 3277}, trig_sincos(frame));
        for (int32_t k = 0; k < 5000; k++) {
            predict(quantised(motor.current * turn_by(-motor.angle), CURRENT_BASE_A),
                    quantised_ab(voltage, VOLTAGE_BASE_V));
            nn_observer_follow(&obs, advance);
            if (k > 2000) { /* e^-36 of the start, in which no voltage acted, is left */
                worst = fmax(worst, fmax(abs(obs.error.d), abs(obs.error.q)));
            }
            voltage = voltage_dq * turn_by(motor.angle + (speed * PERIOD_S / 2.0));
            motor_step(&motor, voltage);
        }
    }
    figure_check("current error at the given speed, LSB", worst, MODEL_BIAS_LSB, LEAST_SHARE);
}

TEST(test_start_begins_with_the_given_speed_current_and_angle)
{
    seeded_t seed = {0x57A27U};

    for (int32_t k = 0; k < 1000; k++) {
        const dq_t current = {seeded_in(&seed, -16384, 16383), seeded_in(&seed, -16384, 16383)};
        const step_t speed = seeded_in(&seed, -cfg.speed_limit, cfg.speed_limit);
        /* I_x = 2·I_b: 2^11 of Q27 for a LSB. */
        const double complex expected =
            cartesian((current.d * 2048.0) + cfg.flux_q27, current.q * 2048.0);
        const double bound = (2.0 * 1.4143 * cabs(expected) / 32768.0) + 4.0;

        memset(&obs, 0x5A, sizeof obs);
        frame = seeded_u32(&seed);
        nn_observer_start(&obs, &cfg, speed, current, trig_sincos(frame));
        TEST_ASSERT_EQUAL_INT32(speed, obs.speed);
        TEST_ASSERT_EQUAL_INT32(speed, obs.speed_out);
        TEST_ASSERT_EQUAL_INT32(0, obs.weight_step);
        TEST_ASSERT_EQUAL_INT32(0, obs.rho_q13);
        TEST_ASSERT_EQUAL_INT32(current.d, obs.current.d);
        TEST_ASSERT_EQUAL_INT32(current.q, obs.current.q);
        TEST_ASSERT_DOUBLE_WITHIN(bound, creal(expected), creal(state()));
        TEST_ASSERT_DOUBLE_WITHIN(bound, cimag(expected), cimag(state()));
        TEST_ASSERT_INT32_WITHIN(1, (int32_t)lround(creal(expected) / 4096.0), obs.state.d);
        TEST_ASSERT_INT32_WITHIN(1, (int32_t)lround(cimag(expected) / 4096.0), obs.state.q);
    }
}

TEST(test_start_beyond_the_ranges_ends_at_them)
{
    cfg.current_shift = 0U;
    cfg.flux_q27 = STATE_LIMIT;
    nn_observer_start(&obs, &cfg, INT32_MAX, (dq_t){32767, -32767}, trig_sincos(0x20000000U));
    TEST_ASSERT_EQUAL_INT32(cfg.speed_limit, obs.speed);
    TEST_ASSERT_EQUAL_INT32(cfg.speed_limit, obs.speed_out);
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.alpha_q27);
    /* x̂ has 28 bits before it is turned: Q15 of I_x. */
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, obs.state.d);
    TEST_ASSERT_EQUAL_INT32(CURRENT_LIMIT, obs.current.d);
    TEST_ASSERT_EQUAL_INT32(-CURRENT_LIMIT - 1, obs.current.q);
    nn_observer_start(&obs, &cfg, -INT32_MAX, (dq_t){-32767, 32767}, trig_sincos(0U));
    TEST_ASSERT_EQUAL_INT32(-cfg.speed_limit, obs.speed);
    TEST_ASSERT_EQUAL_INT32(-CURRENT_LIMIT - 1, obs.current.d);
    TEST_ASSERT_EQUAL_INT32(CURRENT_LIMIT, obs.current.q);
    nn_observer_start(&obs, &cfg, 0, (dq_t){32767, 32767}, trig_sincos(0x20000000U));
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.beta_q27);
}

/* 34400 is what a drive's currents reach, as two phases that read full scale are beyond 16 bits together. */
TEST(test_start_with_a_current_beyond_16_bits_ends_at_28_bits_of_the_state)
{
    static const int32_t beyond[] = {32768, 34400, 65535};

    cfg.current_shift = 0U;
    for (uint32_t k = 0U; k < 3U; k++) {
        nn_observer_start(&obs, &cfg, 0, (dq_t){-beyond[k], beyond[k]}, trig_sincos(0U));
        TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, obs.state.q);
        TEST_ASSERT_EQUAL_INT32(CURRENT_LIMIT, obs.current.q);
        nn_observer_start(&obs, &cfg, 0, (dq_t){beyond[k], -beyond[k] - 1}, trig_sincos(0U));
        TEST_ASSERT_EQUAL_INT32(FX_Q15_MIN, obs.state.q);
        TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, obs.state.d);
    }
}

/* ---- static part ---- */

static int32_t rho_at(step_t speed)
{
    nn_observer_refresh(&obs, &cfg, speed);
    return obs.rho_q13;
}

/* Speed and corner in 2^10 steps: 1024/speed and 1024/corner, relative; the quotient is cut to an integer. */
TEST(test_rho_is_the_corner_over_the_speed_with_its_sign)
{
    cfg.rho_max_q13 = 32767;
    for (step_t speed = cfg.rho_speed_min; speed < 40000000; speed += 123457) {
        const double exact = 8192.0 * cfg.corner / speed;
        const double tolerance = 1.0 + (exact * 1024.0 * ((1.0 / speed) + (1.0 / cfg.corner)));

        if (exact < 32700.0) {
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, exact, rho_at(speed));
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, -exact, rho_at(-speed));
        }
    }
}

/* 3 and −2: nothing is rounded. */
TEST(test_rho_of_multiples_of_the_speed_is_exact)
{
    cfg.rho_max_q13 = 32767;
    cfg.rho_speed_min = 1;
    cfg.corner = 3 << 20U;
    TEST_ASSERT_EQUAL_INT32(3 * 8192, rho_at(1 << 20U));
    cfg.corner = 1 << 21U;
    TEST_ASSERT_EQUAL_INT32(-2 * 8192, rho_at(-(1 << 20U)));
}

/* Speeds have a resolution of 2^10 in it, below which they count as that: (2^10/2^10) = 1. */
TEST(test_rho_below_the_resolution_of_the_speed_is_that_of_the_least_one)
{
    cfg.rho_max_q13 = 32767;
    cfg.rho_speed_min = 1;
    cfg.corner = 1024;
    TEST_ASSERT_EQUAL_INT32(8192, rho_at(1024));
    TEST_ASSERT_EQUAL_INT32(8192, rho_at(1));
    TEST_ASSERT_EQUAL_INT32(-8192, rho_at(-1));
}

TEST(test_rho_is_limited_and_zero_below_the_least_speed)
{
    cfg.rho_max_q13 = 16384;
    TEST_ASSERT_EQUAL_INT32(0, rho_at(cfg.rho_speed_min - 1));
    TEST_ASSERT_EQUAL_INT32(0, rho_at(1 - cfg.rho_speed_min));
    TEST_ASSERT_EQUAL_INT32(0, rho_at(0));
    TEST_ASSERT_EQUAL_INT32(16384, rho_at(cfg.rho_speed_min));
    TEST_ASSERT_EQUAL_INT32(-16384, rho_at(-cfg.rho_speed_min));
    cfg.rho_max_q13 = 0;
    TEST_ASSERT_EQUAL_INT32(0, rho_at(cfg.rho_speed_min));
}

TEST(test_rho_exists_at_every_speed_that_the_configuration_allows)
{
    static const step_t speeds[] = {0,     1,     -1,    1023,       1024,
                                    -1023, -1024, -1025, 0x20000000, -0x20000000};

    cfg.rho_speed_min = 1;
    cfg.rho_max_q13 = 32767;
    for (uint32_t i = 0U; i < (sizeof speeds / sizeof speeds[0]); i++) {
        const int32_t sign = (speeds[i] > 0) - (speeds[i] < 0);

        cfg.corner = LARGEST_CORNER;
        /* 2^27/2^29 at the end, more than its format below. */
        TEST_ASSERT_EQUAL_INT32(sign * ((abs(speeds[i]) > 2000) ? 2048 : 32767), rho_at(speeds[i]));
        cfg.corner = 0;
        TEST_ASSERT_EQUAL_INT32(0, rho_at(speeds[i]));
    }
}

static void show_error(dq_t error)
{
    use_rotation_alone();
    step_with_error(error);
}

/* e' = (1 − jρ)·(e_d + j·σ·e_q): σ·e_q rounded down, 1 and ρ times it; the products with ρ, 1. */
TEST(test_error_is_turned_by_rho_and_stretched_by_the_saliency)
{
    seeded_t seed = {0x7024EDU};

    for (int32_t k = 0; k < 20000; k++) {
        const dq_t e = {seeded_in(&seed, -1000, 1000), seeded_in(&seed, -1000, 1000)};
        const int32_t rho = seeded_in(&seed, -16384, 16384);
        double complex turned = 0.0;

        cfg.saliency_q13 = seeded_in(&seed, 4096, 16384);
        turned = cartesian(1.0, -rho / 8192.0) * cartesian(e.d, e.q * (cfg.saliency_q13 / 8192.0));
        begin();
        obs.rho_q13 = rho;
        obs.rotates = true;
        show_error(e);
        TEST_ASSERT_DOUBLE_WITHIN(3.0, creal(turned), obs.rotated_error.d);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, cimag(turned), obs.rotated_error.q);
    }
}

TEST(test_an_error_that_nothing_rotates_is_taken_as_it_is)
{
    seeded_t seed = {0x7024EEU};

    for (int32_t k = 0; k < 2000; k++) {
        const dq_t e = {seeded_in(&seed, -1000, 1000), seeded_in(&seed, -1000, 1000)};

        cfg.saliency_q13 = 8192;
        cfg.corner = 0;
        begin();
        TEST_ASSERT_FALSE(obs.rotates);
        nn_observer_refresh(&obs, &cfg, 1000000);
        TEST_ASSERT_FALSE(obs.rotates);
        show_error(e);
        TEST_ASSERT_EQUAL_INT32(obs.error.d, obs.rotated_error.d);
        TEST_ASSERT_EQUAL_INT32(obs.error.q, obs.rotated_error.q);
    }
}

TEST(test_rho_or_saliency_alone_rotate_the_error)
{
    cfg.saliency_q13 = 8193;
    cfg.corner = 0;
    begin();
    TEST_ASSERT_TRUE(obs.rotates);
    nn_observer_refresh(&obs, &cfg, 1000000);
    TEST_ASSERT_TRUE(obs.rotates);
    cfg.saliency_q13 = 8192;
    cfg.corner = LARGEST_CORNER;
    cfg.rho_max_q13 = 32767;
    cfg.rho_speed_min = 1;
    nn_observer_refresh(&obs, &cfg, 1000000);
    TEST_ASSERT_TRUE(obs.rotates);
}

TEST(test_without_rho_and_saliency_the_turned_error_is_the_error_itself)
{
    seeded_t seed = {0x7024EEU};

    for (int32_t k = 0; k < 1000; k++) {
        begin();
        show_error((dq_t){seeded_in(&seed, -9000, 9000), seeded_in(&seed, -9000, 9000)});
        TEST_ASSERT_EQUAL_INT32(obs.error.d, obs.rotated_error.d);
        TEST_ASSERT_EQUAL_INT32(obs.error.q, obs.rotated_error.q);
    }
}

/*
 * A constant voltage error ε stands in the current as ε/(R + jωL). Turned by ρ = R/(ωL) what lies along q, as that
 * of a wrong R with i_q, is gone from e'_q, and what lies along d, as that of a wrong angle, from e'_d.
 * Rounding: e ½ in each axis, with ρ ≤ 1.83 together (1 + ρ)/2; the products 2; ρ itself 2·10^-4 of 2000.
 */
#define STATIC_LSB (1.5 + 2.0 + 0.4)

TEST(test_errors_of_the_resistance_and_of_the_angle_are_told_apart_at_any_speed)
{
    for (int32_t k = 4; k <= 20; k++) {
        const double speed = 25.0 * k;
        const double complex impedance = cartesian(RESISTANCE, speed * INDUCTANCE);
        const double complex along_q = cartesian(0.0, 1500.0 * cabs(impedance)) / impedance;
        const double complex along_d = 1500.0 * cabs(impedance) / impedance;

        cfg.rho_max_q13 = 32767;
        begin();
        (void)rho_at(step_of(speed * PERIOD_S));
        show_error((dq_t){(int32_t)lround(creal(along_q)), (int32_t)lround(cimag(along_q))});
        TEST_ASSERT_DOUBLE_WITHIN(STATIC_LSB, 0.0, obs.rotated_error.q);
        TEST_ASSERT_TRUE(obs.rotated_error.d > 1000);
        begin();
        (void)rho_at(step_of(speed * PERIOD_S));
        show_error((dq_t){(int32_t)lround(creal(along_d)), (int32_t)lround(cimag(along_d))});
        TEST_ASSERT_DOUBLE_WITHIN(STATIC_LSB, 0.0, obs.rotated_error.d);
        TEST_ASSERT_TRUE(obs.rotated_error.q < -1000);
    }
}

/* ---- the acceleration of the reference ---- */

TEST(test_a_change_of_the_reference_moves_the_integral_and_no_more_than_to_its_limit)
{
    const step_t limit = cfg.speed_limit;
    const struct {
        step_t speed;
        step_t change;
        step_t expected;
    } cases[] = {{0, 0, 0},
                 {1000000, 300, 1000300},
                 {-1000000, 1000300, 300},
                 {limit - 5, 6, limit},
                 {5 - limit, -6, -limit},
                 {limit, -0x40000000, fx_max(limit - 0x40000000, -limit)}};

    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        obs.speed = cases[k].speed;
        obs.speed_out = 77;
        nn_observer_accelerate(&obs, &cfg, cases[k].change);
        TEST_ASSERT_EQUAL_INT32(cases[k].expected, obs.speed);
        TEST_ASSERT_EQUAL_INT32(77, obs.speed_out);
    }
}

/* ---- the index of the speed in (23) ---- */

/*
 * The error of ω̂ swings with √κ/T, 250 Hz at κ = 0.025, so a window of 20 ms has a peak every 2 ms. A peak may lie so
 * far from a window's edge: growths of 30 and 90/s are seen to within 30·2/20 = 3 and 90·2/20 = 9/s. As much again for
 * the ripple, a hundredth of the error in the last window.
 */
#define WINDOW_TICKS (200)
#define WINDOWS (3)
#define PAPER_KAPPA (0.025)
#define PRINTED_GROWTH (30.0)
#define PRINTED_TOLERANCE (6.0)
#define NEWER_GROWTH (-90.0)
#define NEWER_TOLERANCE (18.0)
#define PERIOD_SHARE \
    (PERIOD_S * RESISTANCE / INDUCTANCE) /* T/τ: the printed index is stable below such a κ */

/* ω̂ starts off by so much, rad/s: far above the ripple at its smallest, and small at its largest. */
#define GROWS_FROM (1.0)
#define DECAYS_FROM (30.0)

/*
 * How fast the error of ω̂ grows, 1/s, at 1800 rpm without current, when θ̂ advances with ω̂(k), as (23) is printed, or
 * with ω̂(k + 1): the largest error of the last window over that of the one before. The start lies in the first.
 */
static double growth_of_speed_error(bool printed, double kappa, double off)
{
    const double speed = 1800.0 / 60.0 * TWO_PI * 2.0;
    motor_t motor = {.current = 0.0, .angle = 0.0, .speed = speed};
    double complex voltage = 0.0;
    double largest[WINDOWS] = {0.0};
    step_t advance = 0;

    cfg.eta = (int32_t)lround(19192.0 / 8.0 * kappa / 0.005); /* the example's κ is 0.005 */
    cfg.eta_shift = example_observer_cfg().eta_shift - 3U;
    cfg.kappa_p = 0;
    frame = 0U;
    nn_observer_start(&obs, &cfg, (step_t)lround((speed + off) * PERIOD_S / TWO_PI * TURN),
                      (dq_t){0, 0}, trig_sincos(frame));
    for (int32_t k = 0; k < (WINDOW_TICKS * WINDOWS); k++) {
        const step_t before = obs.speed_out;
        double *const window = &largest[k / WINDOW_TICKS];
        double angle;

        frame += (angle_t)advance;
        angle = (double)frame / TURN * TWO_PI;
        nn_observer_predict(&obs, &cfg, quantised(motor.current * turn_by(-angle), CURRENT_BASE_A),
                            quantised_ab(voltage, VOLTAGE_BASE_V), trig_sincos(frame));
        nn_observer_train(&obs, &cfg);
        advance = printed ? before : obs.speed_out;
        *window = fmax(*window, fabs(speed_rad_s(obs.speed) - speed));
        voltage = cartesian(0.0, speed * FLUX) * turn_by(motor.angle + (speed * PERIOD_S / 2.0));
        motor_step(&motor, voltage);
    }
    return log(largest[WINDOWS - 1] / largest[WINDOWS - 2]) / (WINDOW_TICKS * PERIOD_S);
}

TEST(test_angle_advanced_with_the_newer_speed_is_stable_where_the_printed_index_is_not)
{
    TEST_ASSERT_DOUBLE_WITHIN(PRINTED_TOLERANCE, PRINTED_GROWTH,
                              growth_of_speed_error(true, PAPER_KAPPA, GROWS_FROM));
    TEST_ASSERT_DOUBLE_WITHIN(NEWER_TOLERANCE, NEWER_GROWTH,
                              growth_of_speed_error(false, PAPER_KAPPA, DECAYS_FROM));
}

TEST(test_printed_index_is_stable_below_a_kappa_of_t_over_tau_and_not_above)
{
    const double below = growth_of_speed_error(true, 0.8 * PERIOD_SHARE, DECAYS_FROM);
    const double above = growth_of_speed_error(true, 1.2 * PERIOD_SHARE, GROWS_FROM);

    TEST_ASSERT_TRUE(below < -PRINTED_TOLERANCE);
    TEST_ASSERT_TRUE(above > PRINTED_TOLERANCE);
}

/*
 * The network's current is (x̂ − φ/L_d) + j·ŷ/(L_q/L_d) in its own frame: what these two change by is what the states do, in
 * the stationary frame. A product is rounded down to one in 2^13, which is `unit` of the state; sine and cosine to 2 of 2^15 of
 * both parts; and two roundings down of one, doubled.
 */
TEST(test_other_weights_change_the_states_by_what_their_flux_and_saliency_do)
{
    seeded_t chance = {11U};

    for (uint32_t k = 0U; k < 2000U; k++) {
        const nn_observer_cfg_t before = cfg;
        nn_observer_cfg_t now = cfg;
        const angle_t at = seeded_u32(&chance);
        const double turn = TWO_PI * at / TURN;
        double unit;
        double complex shift;
        double tolerance;

        now.current_shift = (uint32_t)seeded_in(&chance, 0, 9);
        now.flux_q27 = before.flux_q27 + seeded_in(&chance, -9000000, 9000000);
        now.saliency_q13 = before.saliency_q13 + seeded_in(&chance, -3000, 3000);
        obs.alpha_q27 = seeded_in(&chance, -1000000, 1000000);
        obs.beta_q27 = seeded_in(&chance, -1000000, 1000000);
        obs.current.q = seeded_in(&chance, -16384, 16383);
        unit = ldexp(1.0, 12 - (int)now.current_shift);
        shift = cartesian(now.flux_q27 - before.flux_q27,
                          unit * obs.current.q * (now.saliency_q13 - before.saliency_q13) / 8192.0);
        tolerance = unit + (4.0 * cabs(shift) / ONE) + 4.0;
        shift = cartesian(obs.alpha_q27, obs.beta_q27) + (shift * cartesian(cos(turn), sin(turn)));
        nn_observer_change(&obs, &now, before.flux_q27, before.saliency_q13, trig_sincos(at));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, creal(shift), obs.alpha_q27);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, cimag(shift), obs.beta_q27);
    }
}

/* At 0 and 90 degrees the parts are the states'. Cosine and sine are 32767: 2^-15 of the part less. */
TEST(test_a_change_of_weights_saturates_each_state_and_the_part_of_the_saliency)
{
    const int32_t nearly = STATE_LIMIT / 32768;
    nn_observer_cfg_t now = cfg;

    now.current_shift = 0U;
    obs.alpha_q27 = STATE_LIMIT;
    obs.beta_q27 = STATE_LIMIT;
    obs.current.q = 0;
    now.flux_q27 = cfg.flux_q27 + 50000000;
    nn_observer_change(&obs, &now, cfg.flux_q27, cfg.saliency_q13, trig_sincos(0U));
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.alpha_q27);
    nn_observer_change(&obs, &now, cfg.flux_q27, cfg.saliency_q13, trig_sincos(0x40000000U));
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.beta_q27);
    now = cfg;
    now.current_shift = 0U;
    now.saliency_q13 = cfg.saliency_q13 + 20000;
    obs.current.q = 16383;
    obs.beta_q27 = -STATE_LIMIT;
    nn_observer_change(&obs, &now, cfg.flux_q27, cfg.saliency_q13, trig_sincos(0U));
    TEST_ASSERT_INT32_WITHIN(2 * nearly, 0, obs.beta_q27);
}
