/* SPDX-License-Identifier: MIT */
/* Neural-network observer: convergence on a simulated motor, its laws, its saturations. */
#include "example_cfg.h"
#include "figure.h"
#include "nn_observer.h"
#include "testing.h"
#include "two_axes.h"

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
 * Ripple of ω̂ beside a motor of constant speed, rad/s electrical. Locked, the mean of ω̂ is the true
 * speed, for the angle is its integral. One LSB of e_q (40 A / 2^15) stands for ω̃ = e/(T·φ/L) =
 * 0.366 rad/s. Noise of e_q in LSB, each rounding spread evenly over its step: measurement 1, î 1,
 * the sine 2 of 2^15 times the flux (27330 LSB) 1.7, b >> 12 (2^12/13665 = 0.3): √(1 + 1 + 2.8 +
 * 0.1)/√12 = 0.64 rms. The training is a low pass of 1/κ = 200 samples: √(κ/2) = 0.05 of it passes,
 * 0.012 rad/s rms; four times that is not exceeded in a run.
 */
#define SPEED_BOUND_RAD_S (0.047)

/*
 * Bias of the current model in LSB of I_b, as an angle error: R + jωL times the bias must be made
 * up by φ·ω·sin θ̃. Sine and cosine 2 of 2^15 of the flux, 1.7·√2 = 2.4; î rounded down 1, and with
 * what its turn by half a step rounds 2.5 in the resistance's drop; the decay as an integer 10^-4
 * of 3277 LSB = 0.4; noise of ω̂ during the 55 samples of τ: 0.047 rad/s·T·27300·55/2 = 3.5.
 */
#define MODEL_BIAS_LSB (9.8)
#define LEAST_SHARE (0.1)

/*
 * One tick of training in a held state, relative: e rounded 0.5/2733, x rounded down 1/13665, b >>
 * 12 rounded down 1/9117, weights as integers 0.25/600 at worst, momentum rounded to 2 steps:
 * 10^-4.
 */
#define TRAINING_TOLERANCE (1.3e-3)
#define TRAINING_ERROR_RAD_S (1000.0) /* ω̃ that gives e_q = 2733 LSB */

static nn_observer_cfg_t cfg;
static nn_observer_t obs;
static angle_t frame; /* θ̂ */

static const dq_t NO_CURRENT = {0, 0};
static const ab_t NO_VOLTAGE = {0, 0};

static void start(step_t speed, dq_t current, angle_t angle)
{
    frame = angle;
    nn_observer_start(&obs, &cfg, speed, current, trig_sincos(frame));
}

/* At rest at angle 0, without current. */
static void begin(void)
{
    start(0, NO_CURRENT, 0U);
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

static step_t step_of(double radians)
{
    return (step_t)lround(radians / TWO_PI * TURN);
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

/* Where a number saturates: at limit, or at −limit − 1. */
static int32_t end_of(int32_t sign, int32_t limit)
{
    return (sign > 0) ? limit : (-limit - 1);
}

static void assert_near(double tolerance, double complex expected, dq_t actual)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, creal(expected), actual.d, "real part");
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, cimag(expected), actual.q, "imaginary part");
}

/* The state in the stationary frame, Q27 of I_x. */
static void assert_state_near(double tolerance, double complex expected)
{
    assert_near(tolerance, expected, (dq_t){obs.alpha_q27, obs.beta_q27});
}

static void assert_speeds(step_t speed, step_t speed_out)
{
    TEST_ASSERT_EQUAL_INT32_MESSAGE(speed, obs.speed, "speed");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(speed_out, obs.speed_out, "inner speed");
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

/* What holds that current along q over the next period. */
static double complex motor_voltage(const motor_t *motor, double current_q)
{
    return cartesian(-motor->speed * INDUCTANCE * current_q,
                     (RESISTANCE * current_q) + (motor->speed * FLUX)) *
           turn_by(motor->angle + (motor->speed * PERIOD_S / 2.0));
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

static void predict_idle(void)
{
    predict(NO_CURRENT, NO_VOLTAGE);
}

/* A step in which the output error is e, whatever the network's own current is. */
static void step_with_error(dq_t e)
{
    nn_observer_t probe = obs;

    nn_observer_predict(&probe, &cfg, NO_CURRENT, NO_VOLTAGE,
                        trig_sincos(frame + (angle_t)obs.speed_out));
    step((dq_t){probe.current.d + e.d, probe.current.q + e.q}, NO_VOLTAGE);
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
    double speed_error; /* largest |ω̂ − ω| in the second half */
    double angle_error; /* largest |θ̂ − θ| in the second half, degrees */
} run_t;

/* The observer beside a motor that carries `current_q` at `speed`; the motor starts at angle 0. */
static run_t run_beside_motor(double speed, double current_q, int32_t ticks)
{
    motor_t motor = {.current = cartesian(0.0, current_q), .speed = speed};
    double complex voltage = 0.0;
    run_t run = {0.0, 0.0};

    for (int32_t k = 0; k < ticks; k++) {
        const double angle = (double)(frame + (angle_t)obs.speed_out) / TURN * TWO_PI;
        const double angle_error = remainder(angle - motor.angle, TWO_PI) / TWO_PI * 360.0;

        if ((k % SLOW_TICKS) == 0) {
            nn_observer_refresh(&obs, &cfg, 0);
        }
        step(quantised(motor.current * turn_by(-angle), CURRENT_BASE_A),
             quantised_ab(voltage, VOLTAGE_BASE_V));
        if (k > (ticks / 2)) {
            run.angle_error = fmax(run.angle_error, fabs(angle_error));
            run.speed_error = fmax(run.speed_error, fabs(speed_rad_s(obs.speed) - speed));
        }
        voltage = motor_voltage(&motor, current_q);
        motor_step(&motor, voltage);
    }
    return run;
}

static double angle_bound_deg(double speed)
{
    const double impedance = RESISTANCE + (fabs(speed) * INDUCTANCE);

    return impedance * (MODEL_BIAS_LSB * CURRENT_BASE_A / ONE) / (fabs(speed) * FLUX) * 360.0 /
           TWO_PI;
}

/* Two products and the flux are rounded down, the saliency's product with the share once more. */
#define GRADIENT_STATE_TOLERANCE (4.0)

/* φ/L_d + (1 − c·s)·i_d + j·(s − c)·i_q of I_x: from the start on, and not changed by a tick. */
TEST(test_with_a_frame_share_the_gradient_leaves_out_what_the_current_turns)
{
    seeded_t seed = {11U};

    for (uint32_t k = 0U; k < 1000U; k++) {
        const dq_t current = seeded_dq(&seed, 16000);

        cfg.saliency_q13 = seeded_in(&seed, 4096, 16384);
        cfg.frame_share_q13 = seeded_in(&seed, 1, 8192);
        start(0, current, 0U);

        const double s = cfg.saliency_q13 / 8192.0;
        const double c = cfg.frame_share_q13 / 8192.0;
        const double unit = exp2(cfg.current_shift);
        const dq_t state = obs.state;

        assert_near(GRADIENT_STATE_TOLERANCE,
                    cartesian((cfg.flux_q27 / 4096.0) + ((1.0 - (c * s)) * current.d / unit),
                              (s - c) * current.q / unit),
                    state);
        nn_observer_predict(&obs, &cfg, current, NO_VOLTAGE, trig_sincos(0U));
        assert_dq(state.d, state.q, obs.state);
    }
}

/*
 * Without saliency and with the whole share it is the flux, and a tick's b is e'_q·φ/L_d, whatever
 * the current.
 */
TEST(test_with_the_whole_share_the_gradient_of_a_round_motor_does_not_follow_the_current)
{
    static const int32_t currents[] = {-12000, 0, 12000};
    const int32_t flux = cfg.flux_q27 / 4096;

    cfg.frame_share_q13 = 8192;
    cfg.saliency_q13 = 8192;
    for (uint32_t k = 0U; k < 9U; k++) {
        const dq_t current = {currents[k % 3U], currents[k / 3U]};

        start(0, current, 0U);
        nn_observer_refresh(&obs, &cfg, 0);
        assert_dq(flux, 0, obs.state);
        predict((dq_t){current.d, current.q + 400}, NO_VOLTAGE);
        TEST_ASSERT_EQUAL_INT32(fx_sat16(fx_asr(obs.rotated_error.q * flux, cfg.gradient_shift)),
                                obs.gradient);
    }
}

TEST(test_the_gradient_state_follows_the_current_of_the_last_refresh)
{
    dq_t after_start;

    cfg.saliency_q13 = 16384;
    cfg.frame_share_q13 = 1;
    start(0, (dq_t){3000, -5000}, 0U);
    after_start = obs.state;
    begin();
    obs.current = (dq_t){3000, -5000};
    nn_observer_refresh(&obs, &cfg, 0);
    assert_dq(after_start.d, after_start.q, obs.state);
    cfg.frame_share_q13 = 0;
    obs.state = (dq_t){1, 2};
    nn_observer_refresh(&obs, &cfg, 0);
    assert_dq(1, 2, obs.state);
}

/* L_q/L_d = 4 and currents at full scale: 3·16384 and more. */
TEST(test_the_gradient_state_stays_within_its_format)
{
    cfg.frame_share_q13 = 8192;
    cfg.saliency_q13 = 32767;
    cfg.current_shift = 0U;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        cfg.flux_q27 = (sign > 0) ? 0x7FFFFFF : 1;
        start(0, (dq_t){-sign * 16383, sign * 16383}, 0U);
        assert_dq(sign * 46341, sign * 46341, obs.state);
    }
}

TEST(test_estimates_find_a_motor_already_running_and_follow_it)
{
    static const double speeds[] = {377.0, -377.0, 200.0, -200.0, 60.0, -60.0};
    double worst_speed = 0.0;
    double worst_angle = 0.0;

    for (uint32_t i = 0U; i < (2U * (sizeof speeds / sizeof speeds[0])); i++) {
        const double speed = speeds[i / 2U];

        begin();

        const run_t run = run_beside_motor(speed, ((i % 2U) == 0U) ? 0.0 : 4.0, 40000);

        worst_speed = fmax(worst_speed, run.speed_error);
        worst_angle = fmax(worst_angle, run.angle_error / angle_bound_deg(speed));
    }
    figure_check("speed ripple, rad/s", worst_speed, SPEED_BOUND_RAD_S, LEAST_SHARE);
    figure_check("angle error as a share of its bound", worst_angle, 1.0, LEAST_SHARE);
}

TEST(test_published_law_follows_a_motor_with_exact_parameters)
{
    /*
     * κ = 0.03 lets √(0.03/0.005) times the noise through, and its damping is low: as much again.
     */
    const double bound = 2.0 * 2.45 * SPEED_BOUND_RAD_S;

    cfg.eta = 28788;
    cfg.eta_shift = 7U;
    cfg.kappa_p = 0;
    /* 377.2 rad/s: the law has no damping to start from rest beside this motor */
    start(25783200, NO_CURRENT, 0U);
    figure_check("published law, speed ripple, rad/s",
                 run_beside_motor(377.0, 4.0, 40000).speed_error, bound, LEAST_SHARE / 2.0);
}

TEST(test_standstill_without_current_stays_exactly_at_rest)
{
    const run_t run = run_beside_motor(0.0, 0.0, 100000);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, run.speed_error);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, run.angle_error);
}

TEST(test_standstill_with_current_keeps_the_speed_within_the_ripple)
{
    TEST_ASSERT_TRUE(run_beside_motor(0.0, 4.0, 40000).speed_error <= SPEED_BOUND_RAD_S);
}

TEST(test_voltage_drives_its_own_axis_by_the_gain)
{
    const int32_t drive = (int32_t)(((int64_t)cfg.volt_gain * 10000) / 128); /* weight_shift = 7 */
    const int32_t alpha = obs.alpha_q27;

    predict(NO_CURRENT, (ab_t){0, 10000});
    assert_state_near(0.0, cartesian(alpha, drive));
    begin();
    predict(NO_CURRENT, (ab_t){10000, 0});
    assert_state_near(0.0, cartesian(alpha + drive, 0.0));
}

/*
 * At speed the current of the middle is that of the rotor half a step ago: turned back by half a
 * step's angle.
 */
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
        obs.speed = step_of(delta);
        nn_observer_refresh(&obs, &cfg, 0);
        obs.speed_out = obs.speed;
        predict_idle();
        assert_state_near(bound, cfg.flux_q27 - (share * middle));
    }
}

TEST(test_current_output_is_in_the_base_of_the_measurement)
{
    /*
     * 1000 LSB of I_b = 500 of I_x in Q15. L_d/L_q = ½ halves i_q. A cosine of 32767 leaves out
     * 2^-15 of 13165 in Q15 of I_x, 0.8 of I_b; rounded down once in d, twice in q.
     */
    cfg.iq_gain_q14 = 8192;
    set_state(cfg.flux_q27 - (500 * 4096), 500 * 4096);
    predict((dq_t){100, 200}, NO_VOLTAGE);
    assert_near(2.0, cartesian(-1000.0, 500.0), obs.current);
    assert_dq(100 - obs.current.d, 200 - obs.current.q, obs.error);
}

TEST(test_current_output_saturates_to_15_bits_on_both_sides)
{
    cfg.current_shift = 3U; /* eight times I_b */
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        set_state(sign * 0x7000000, -sign * 0x7000000);
        predict_idle();
        assert_dq(end_of(sign, CURRENT_LIMIT), end_of(-sign, CURRENT_LIMIT), obs.current);
    }
}

/* One tick of training on a constant error, with the network's state held: flux, at rest. */
static void train_once(int32_t error_q)
{
    set_state(cfg.flux_q27, 0);
    obs.current = NO_CURRENT;
    step((dq_t){0, error_q}, NO_VOLTAGE);
}

/* e_q of a motor that is faster than the network by ω̃, after one sample. */
static int32_t error_of(double speed_error)
{
    return (int32_t)lround(-speed_error * PERIOD_S * FLUX / INDUCTANCE / CURRENT_BASE_A * ONE);
}

/* `gained` is that share of the error's 1000 rad/s. */
static void assert_share_of_error(double share, double gained)
{
    const double expected = share * TRAINING_ERROR_RAD_S;

    TEST_ASSERT_DOUBLE_WITHIN(fabs(expected) * TRAINING_TOLERANCE, expected, speed_rad_s(gained));
}

TEST(test_a_sample_removes_kappa_of_the_error_and_kappa_p_of_it_from_the_inner_speed_only)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        train_once(error_of(sign * TRAINING_ERROR_RAD_S));
        assert_share_of_error(sign * 0.005, obs.speed);
        assert_share_of_error(sign * 0.1, (double)obs.speed_out - obs.speed);
    }
}

/* The weights of the example, each rounded down. */
static void assert_gradient_acts(int32_t gradient)
{
    const step_t speed = -(step_t)lrint(floor(gradient * 19192 / 512.0));

    assert_speeds(speed, speed - (step_t)lrint(floor(gradient * 23990 / 32.0)));
}

/*
 * b = e_q·x̂ − e_d·ŷ with ŷ = x̂/2 held. x̂ = 8192 in Q15 of I_x and b >> 12: 2·e_q − e_d.
 * x̂ = 32 leaves room for 2^8 times as much, b >> 4: the same.
 */
TEST(test_training_goes_down_along_both_errors)
{
    static const dq_t errors[] = {{400, 0},    {0, 400},   {-400, 0},   {0, -400},
                                  {400, -200}, {400, 200}, {-400, -200}};
    static const int32_t gradients[] = {-400, 800, 400, -800, -800, 0, 0};

    for (uint32_t i = 0U; i < (2U * (sizeof errors / sizeof errors[0])); i++) {
        const bool is_small = (i % 2U) != 0U;
        const int32_t x_q27 = (is_small ? 32 : 8192) * 4096;

        cfg.flux_q27 = x_q27;
        cfg.gradient_shift = is_small ? 4U : 12U;
        begin();
        set_state(x_q27, x_q27 / 2);
        step_with_error(errors[i / 2U]);
        TEST_ASSERT_EQUAL_INT32(gradients[i / 2U], obs.gradient);
        assert_gradient_acts(obs.gradient);
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
        assert_share_of_error(0.005, obs.speed);
    }
}

TEST(test_without_the_proportional_path_the_inner_speed_is_the_integral_bit_by_bit)
{
    seeded_t seed = {0x0DDBA11U};

    cfg.kappa_p = 0;
    for (int32_t i = 0; i < 50000; i++) {
        const dq_t measured = seeded_dq(&seed, 9000);

        step(measured, seeded_ab(&seed, 20000));
        TEST_ASSERT_EQUAL_INT32(obs.speed, obs.speed_out);
    }
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
        const step_t limit = sign * cfg.speed_limit;

        begin();
        for (int32_t k = 0; k < 2000; k++) {
            train_once(-sign * 8000);
        }
        assert_speeds(limit, limit - (step_t)lrint(floor(gradient * cfg.kappa_p / 32.0)));
    }
}

/*
 * (22) alone: the largest step, 2^30 less what rounding takes, from one end of the speed to near
 * the other.
 */
TEST(test_without_momentum_the_weight_step_is_not_cut)
{
    cfg.eta = 32767;
    cfg.eta_shift = 0U;
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
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        obs.gradient = end_of(-sign, LARGEST_GRADIENT - 1);
        nn_observer_train(&obs, &cfg);
        assert_speeds(0, end_of(sign, WEIGHT_STEP_LIMIT));
    }
}

/* Weights off: nothing but the frame moves. */
static void use_rotation_alone(void)
{
    cfg.decay = 0;
    cfg.eta = 0;
    cfg.kappa_p = 0;
}

TEST(test_errors_saturate_to_14_bits_on_both_sides)
{
    static const int32_t currents[] = {8190, 8191, 8192, 65535, -8190, -8191, -8192, -8193, -65535};
    static const int32_t errors[] = {8190, 8191, 8191, 8191, -8190, -8191, -8192, -8192, -8192};

    use_rotation_alone();
    for (uint32_t i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        step_with_error((dq_t){currents[i], 0});
        assert_dq(errors[i], 0, obs.error);
        step_with_error((dq_t){0, currents[i]});
        assert_dq(0, errors[i], obs.error);
    }
}

TEST(test_states_saturate_to_28_bits_on_both_sides)
{
    use_rotation_alone();
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        for (int32_t k = 0; k < 100; k++) {
            step(NO_CURRENT, (ab_t){sign * 32767, -sign * 32767});
        }
        assert_state_near(0.0, cartesian(end_of(sign, STATE_LIMIT), end_of(-sign, STATE_LIMIT)));
    }
}

TEST(test_weight_step_with_momentum_saturates_to_30_bits_on_both_sides)
{
    /* 6829·32767 a tick, of which the momentum keeps nearly all: beyond 2^29 in the third. */
    cfg.eta = 32767;
    cfg.eta_shift = 0U;
    cfg.momentum_q15 = 32767;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t end = end_of(sign, WEIGHT_STEP_LIMIT);

        begin();
        train_once(sign * 2047);
        train_once(sign * 2047);
        TEST_ASSERT_INT32_WITHIN(WEIGHT_STEP_LIMIT / 8, end / 4 * 3, obs.weight_step);
        train_once(sign * 2047);
        TEST_ASSERT_EQUAL_INT32(end, obs.weight_step);
    }
}

/*
 * Twice 13665 in Q15 of I_x, times e_q, >> 12: 4910 give ±32761.6 and 4911 ±32768.3, rounded down.
 */
TEST(test_gradient_saturates_to_16_bits_on_both_sides)
{
    static const int32_t errors[] = {4910, 4911, 8191, -4910, -4911, -8191};
    static const int32_t gradients[] = {32761, 32767, 32767, -32762, -32768, -32768};

    cfg.flux_q27 = 2 * 13665 * 4096;
    cfg.speed_limit = LARGEST_SPEED_LIMIT;
    for (uint32_t i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        begin();
        train_once(errors[i]);
        assert_gradient_acts(gradients[i]);
    }
}

static int32_t either(seeded_t *seed, int32_t largest, int32_t least)
{
    return ((seeded_u32(seed) & 1U) != 0U) ? largest : least;
}

/* The configuration whose products are largest within what config_check accepts. */
static nn_observer_cfg_t largest_cfg(seeded_t *seed)
{
    return (nn_observer_cfg_t){
        .decay = 32767,
        .volt_gain = 32767,
        .weight_shift = (uint32_t)seeded_in(seed, 2, 15),
        .feedback_q15 = either(seed, seeded_in(seed, 0, 32767), 0),
        .flux_q27 = either(seed, STATE_LIMIT, 1),
        .iq_gain_q14 = either(seed, 32767, 1),
        .saliency_q13 = either(seed, 32767, 1),
        .corner = either(seed, LARGEST_CORNER, 0),
        .rho_max_q13 = either(seed, 32767, 0),
        .rho_speed_min = 1,
        .current_shift = (uint32_t)seeded_in(seed, 0, 9),
        .gradient_shift = (uint32_t)seeded_in(seed, 4, 12),
        .eta = 32767,
        .eta_shift = (uint32_t)seeded_in(seed, 0, 30),
        .kappa_p = 32767,
        .kappa_p_shift = (uint32_t)seeded_in(seed, 0, 30),
        .momentum_q15 = either(seed, 32767, 0),
        .speed_limit = either(seed, LARGEST_SPEED_LIMIT, 1),
    };
}

/* Mostly an end of ±limit. */
static int32_t extreme(seeded_t *seed, int32_t limit)
{
    const int32_t choice = seeded_in(seed, 0, 3);

    if (choice == 0) {
        return -limit;
    }
    return (choice == 1) ? seeded_in(seed, -limit, limit) : limit;
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

/*
 * A state s in the frame beside the exact one, Q15 of I_x: sine and cosine are within 2 of 2^15 of
 * the exact ones, in both products; products and state rounded down, 1.
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

        set_state((int32_t)lround(creal(start)), (int32_t)lround(cimag(start)));
        frame = seeded_u32(&seed);
        obs.speed_out = step_of(seeded_in(&seed, -785, 785) / 1000.0);
        predict_idle();

        const double complex off = (state() / 4096.0) - cartesian(obs.state.d, obs.state.q);

        worst = fmax(worst, fmax(fabs(creal(off)), fabs(cimag(off))) / bound);
    }
    figure_check("state in the frame, as a share of its bound", worst, 1.0, 0.3);
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

/*
 * The network alone at a given turn in a tick, with the motor's EMF and a voltage error: the
 * error's shadow in the state.
 */
static double complex state_after(double turn, double start_d, double complex excess, int32_t ticks)
{
    const double complex voltage = cartesian(0.0, turn / PERIOD_S * FLUX) + excess;

    begin();
    set_state(cfg.flux_q27 + (int32_t)lround(start_d), 0);
    obs.current = (dq_t){(int32_t)lround(start_d / 2048.0), 0};
    obs.error = (dq_t){-obs.current.d, 0};
    nn_observer_follow(&obs, step_of(turn));
    nn_observer_refresh(&obs, &cfg, step_of(turn));
    for (int32_t k = 0; k < ticks; k++) {
        const double middle = ((double)frame / TURN * TWO_PI) + (turn / 2.0);

        predict(NO_CURRENT, quantised_ab(voltage * turn_by(middle), VOLTAGE_BASE_V));
        nn_observer_follow(&obs, step_of(turn));
    }
    return state();
}

/* Two networks beside the same motor, one 5 A off: what is left between them after 20 ticks. */
#define APART_Q27 (8388608.0)
/*
 * Of each tick in each: î rounded, its share of the measured current, its turn and the voltage, 6
 * LSB of 2048 times D; the state and the sine's 2^-15 of what is apart. All decays with D.
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
        const dq_t measured = seeded_dq(&seed, 8000);
        const ab_t voltage = seeded_ab(&seed, 9000);

        obs.error = NO_CURRENT;
        other = obs;
        other.error = (dq_t){seeded_in(&seed, -8192, 8191), seeded_in(&seed, -8192, 8191)};
        predict(measured, voltage);
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
        assert_near(MODEL_BIAS_LSB, e, obs.error);
        assert_near(MODEL_BIAS_LSB * (1.0 + rho), turned, obs.rotated_error);
    }
}

/* ---- a given speed, a start ---- */

TEST(test_a_given_speed_is_taken_over_whole_and_trains_nothing)
{
    cfg.momentum_q15 = 16384;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        train_once(error_of(TRAINING_ERROR_RAD_S));
        TEST_ASSERT_TRUE((obs.weight_step != 0) && (obs.speed != obs.speed_out));
        nn_observer_follow(&obs, sign * cfg.speed_limit);
        assert_speeds(sign * cfg.speed_limit, sign * cfg.speed_limit);
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
        const step_t advance = step_of(speed * PERIOD_S);
        motor_t motor = {.current = cartesian(0.0, 4.0), .speed = speed};
        double complex voltage = 0.0;

        start(advance, (dq_t){0, 3277}, 0U - (angle_t)advance);
        for (int32_t k = 0; k < 5000; k++) {
            predict(quantised(motor.current * turn_by(-motor.angle), CURRENT_BASE_A),
                    quantised_ab(voltage, VOLTAGE_BASE_V));
            nn_observer_follow(&obs, advance);
            if (k > 2000) { /* e^-36 of the start, in which no voltage acted, is left */
                worst = fmax(worst, fmax(abs(obs.error.d), abs(obs.error.q)));
            }
            voltage = motor_voltage(&motor, 4.0);
            motor_step(&motor, voltage);
        }
    }
    figure_check("current error at the given speed, LSB", worst, MODEL_BIAS_LSB, LEAST_SHARE);
}

/*
 * The first 32 starts are at rest, at angles all around. Sine and cosine are within 1 LSB of
 * 32767·sin: 2 of 2^15 of both parts; 4 for the roundings of the products.
 */
TEST(test_start_begins_with_the_given_speed_current_and_angle)
{
    seeded_t seed = {0x57A27U};

    for (uint32_t k = 0U; k < 1032U; k++) {
        const step_t speed = (k < 32U) ? 0 : seeded_in(&seed, -cfg.speed_limit, cfg.speed_limit);
        const dq_t current = seeded_dq(&seed, (k < 32U) ? 0 : 16383);
        const angle_t angle = (k < 32U) ? (k << 27U) : seeded_u32(&seed);
        /* I_x = 2·I_b: 2^11 of Q27 for a LSB. */
        const int32_t x_q27 = (current.d * 2048) + cfg.flux_q27;
        const int32_t y_q27 = current.q * 2048;
        const double bound = (2.0 * ((double)abs(x_q27) + abs(y_q27)) / 32768.0) + 4.0;

        memset(&obs, 0x5A, sizeof obs);
        start(speed, current, angle);
        assert_speeds(speed, speed);
        TEST_ASSERT_EQUAL_INT32(0, obs.weight_step);
        TEST_ASSERT_EQUAL_INT32(0, obs.rho_q13);
        assert_dq(current.d, current.q, obs.current);
        assert_dq(0, 0, obs.error);
        assert_state_near(bound, cartesian(x_q27, y_q27) * turn_by(angle / TURN * TWO_PI));
        assert_dq(fx_asr(x_q27, 12U), fx_asr(y_q27, 12U), obs.state);
    }
}

TEST(test_start_beyond_the_ranges_ends_at_them)
{
    cfg.current_shift = 0U;
    cfg.flux_q27 = STATE_LIMIT;
    start(INT32_MAX, (dq_t){32767, -32767}, 0x20000000U);
    assert_speeds(cfg.speed_limit, cfg.speed_limit);
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.alpha_q27);
    /* x̂ has 28 bits before it is turned: Q15 of I_x. */
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, obs.state.d);
    assert_dq(CURRENT_LIMIT, -CURRENT_LIMIT - 1, obs.current);
    start(-INT32_MAX, (dq_t){-32767, 32767}, 0U);
    assert_speeds(-cfg.speed_limit, -cfg.speed_limit);
    assert_dq(-CURRENT_LIMIT - 1, CURRENT_LIMIT, obs.current);
    start(0, (dq_t){32767, 32767}, 0x20000000U);
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.beta_q27);
    /* Two phases that read full scale are beyond 16 bits together. */
    start(0, (dq_t){-34400, 32768}, 0U);
    TEST_ASSERT_EQUAL_INT32(FX_Q15_MAX, obs.state.q);
    start(0, (dq_t){65535, -65536}, 0U);
    assert_dq(FX_Q15_MAX, FX_Q15_MIN, obs.state);
    assert_dq(CURRENT_LIMIT, -CURRENT_LIMIT - 1, obs.current);
}

/* ---- static part ---- */

static int32_t rho_at(step_t speed)
{
    nn_observer_refresh(&obs, &cfg, speed);
    return obs.rho_q13;
}

/* A speed counts in steps of 2^10, and one below that as 2^10. Backwards ρ has the other sign. */
TEST(test_rho_is_exact_limited_and_zero_below_the_least_speed)
{
    static const struct {
        const char *name;
        step_t least_speed;
        step_t corner;
        int32_t most;
        step_t speed;
        int32_t rho;
    } cases[] = {
        {"three times the speed", 1, 3 << 20U, 32767, 1 << 20U, 3 * 8192},
        {"twice the speed", 1, 1 << 21U, 32767, 1 << 20U, 2 * 8192},
        {"resolution", 1, 1024, 32767, 1024, 8192},
        {"below the resolution", 1, 1024, 32767, 1, 8192},
        {"just too slow", 1288490, 12522209, 16384, 1288489, 0},
        {"at rest", 1288490, 12522209, 16384, 0, 0},
        {"limit at the least speed", 1288490, 12522209, 16384, 1288490, 16384},
        {"off", 1288490, 12522209, 0, 1288490, 0},
        {"largest corner at rest", 1, LARGEST_CORNER, 32767, 0, 0},
        {"largest corner, least speed", 1, LARGEST_CORNER, 32767, 1, 32767},
        {"largest corner, 1023", 1, LARGEST_CORNER, 32767, 1023, 32767},
        {"largest corner, 1025", 1, LARGEST_CORNER, 32767, 1025, 32767},
        {"largest corner and speed", 1, LARGEST_CORNER, 32767, 0x20000000, 2048},
        {"no corner", 1, 0, 32767, 0x20000000, 0},
        {"no corner, below the resolution", 1, 0, 32767, 1, 0},
    };

    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        cfg.rho_speed_min = cases[k].least_speed;
        cfg.corner = cases[k].corner;
        cfg.rho_max_q13 = cases[k].most;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(cases[k].rho, rho_at(cases[k].speed), cases[k].name);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(-cases[k].rho, rho_at(-cases[k].speed), cases[k].name);
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
        const dq_t e = seeded_dq(&seed, 1000);
        const int32_t rho = seeded_in(&seed, -16384, 16384);
        const int32_t saliency = seeded_in(&seed, 4096, 16384);
        const double complex turned =
            cartesian(1.0, -rho / 8192.0) * cartesian(e.d, e.q * (saliency / 8192.0));

        cfg.saliency_q13 = saliency;
        begin();
        obs.rho_q13 = rho;
        obs.rotates = true;
        show_error(e);
        TEST_ASSERT_DOUBLE_WITHIN(3.0, creal(turned), obs.rotated_error.d);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, cimag(turned), obs.rotated_error.q);
    }
}

/* The second thousand with a corner, but no share of it. */
TEST(test_without_rho_and_saliency_the_turned_error_is_the_error_itself)
{
    seeded_t seed = {0x7024EEU};

    for (int32_t k = 0; k < 2000; k++) {
        cfg.corner = (k < 1000) ? 0 : example_observer_cfg().corner;
        begin();
        TEST_ASSERT_FALSE(obs.rotates);
        nn_observer_refresh(&obs, &cfg, 10000000);
        TEST_ASSERT_FALSE(obs.rotates);
        show_error(seeded_dq(&seed, 9000));
        assert_dq(obs.error.d, obs.error.q, obs.rotated_error);
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
        assert_speeds(cases[k].expected, 77);
    }
}

static void change(const nn_observer_cfg_t *now, angle_t angle)
{
    nn_observer_change(&obs, now, cfg.flux_q27, cfg.saliency_q13, trig_sincos(angle));
}

/*
 * The network's current is (x̂ − φ/L_d) + j·ŷ/(L_q/L_d) in its own frame: what these two change by
 * is what the states do, in the stationary frame. A product is rounded down to one in 2^13, which
 * is `unit` of the state; sine and cosine to 2 of 2^15 of both parts; and two roundings down of
 * one, doubled.
 */
TEST(test_other_weights_change_the_states_by_what_their_flux_and_saliency_do)
{
    seeded_t seed = {11U};

    for (uint32_t k = 0U; k < 2000U; k++) {
        const angle_t at = seeded_u32(&seed);
        const int32_t flux = seeded_in(&seed, -9000000, 9000000);
        const int32_t saliency = seeded_in(&seed, -3000, 3000);
        const ab_t before = seeded_ab(&seed, 1000000);
        nn_observer_cfg_t now = cfg;

        now.current_shift = (uint32_t)seeded_in(&seed, 0, 9);
        now.flux_q27 += flux;
        now.saliency_q13 += saliency;
        obs.alpha_q27 = before.alpha;
        obs.beta_q27 = before.beta;
        obs.current.q = seeded_in(&seed, -16384, 16383);

        const double unit = ldexp(1.0, 12 - (int)now.current_shift);
        const double complex shift = cartesian(flux, unit * obs.current.q * saliency / 8192.0);
        const double tolerance = unit + (4.0 * cabs(shift) / ONE) + 4.0;

        change(&now, at);
        assert_state_near(tolerance, cartesian(before.alpha, before.beta) +
                                         (shift * turn_by(TWO_PI * at / TURN)));
    }
}

/*
 * At 0 and 90 degrees the parts are the states'. Cosine and sine are 32767: 2^-15 of the part less.
 */
TEST(test_a_change_of_weights_saturates_each_state_and_the_part_of_the_saliency)
{
    const int32_t nearly = STATE_LIMIT / 32768;
    nn_observer_cfg_t now = cfg;

    now.current_shift = 0U;
    obs.alpha_q27 = STATE_LIMIT;
    obs.beta_q27 = STATE_LIMIT;
    obs.current.q = 0;
    now.flux_q27 = cfg.flux_q27 + 50000000;
    change(&now, 0U);
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.alpha_q27);
    change(&now, 0x40000000U);
    TEST_ASSERT_EQUAL_INT32(STATE_LIMIT, obs.beta_q27);
    now.flux_q27 = cfg.flux_q27;
    now.saliency_q13 = cfg.saliency_q13 + 20000;
    obs.current.q = 16383;
    obs.beta_q27 = -STATE_LIMIT;
    change(&now, 0U);
    TEST_ASSERT_INT32_WITHIN(2 * nearly, 0, obs.beta_q27);
}
