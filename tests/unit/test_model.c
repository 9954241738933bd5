/* SPDX-License-Identifier: MIT */
/* The model in force: what measured ratios reach, their limits, and the flux that is tracked. */
#include "example_cfg.h"
#include "model.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ONE_Q14 (16384.0)
#define ONE_Q30 (1073741824.0)
#define FLUX_CURRENT_LSB (27330.0) /* φ/L = 33.362 A of 40 A in Q15 */
#define FAST (10000000)            /* above flux_speed_min */

/*
 * Ratios are Q14: that of R rounded down from 1547ths, 1 of at least 0.5; 1/L rounded down, 1 of
 * 0.74 and L as an integer ½ of 0.65; that of φ likewise 1 of 0.75. Twice for L². Each product is
 * rounded down: up to 2 of 1/L.
 */
#define RATIO_TOLERANCE ((2.0 + 1.4 + 1.4 + 0.8) / ONE_Q14)
#define ROUNDING (1.0 + 2.0)

static model_cfg_t cfg;
static nn_observer_cfg_t observer;
static current_loop_cfg_t run_loop;
static current_loop_cfg_t hold_loop;
static const model_nominal_t NOMINAL = {&observer, &run_loop, &hold_loop};
static model_t model;

static void lower_gains(pi_cfg_t *pi)
{
    pi->kp /= 3;
    pi->ki /= 3;
}

void setUp(void)
{
    cfg = example_model_cfg_with_corrections();
    observer = example_observer_cfg();
    /* Smaller mantissas, so that they can grow. */
    observer.eta /= 2;
    observer.kappa_p /= 2;
    observer.volt_gain /= 2;
    observer.decay /= 2;
    observer.iq_gain_q14 /= 2;
    run_loop = example_current_loop_cfg();
    lower_gains(&run_loop.pi_d);
    lower_gains(&run_loop.pi_q);
    hold_loop = example_hold_loop_cfg();
    memset(&model, 0x5A, sizeof model);
    model_reset(&model, &NOMINAL);
}

static int32_t resistance_of(double ratio)
{
    return (int32_t)lround(run_loop.resistance_q13 * ratio);
}

static int32_t inductance_of(double ratio)
{
    return (int32_t)lround(ONE_Q14 * ratio);
}

static int32_t saliency_of(double ratio)
{
    return (int32_t)lround(observer.saliency_q13 * ratio);
}

static void set_words(int32_t resistance_q13, int32_t inductance_q14, int32_t saliency_q13)
{
    const model_measured_t measured = {resistance_q13, inductance_q14, saliency_q13};

    model_set(&model, &cfg, &NOMINAL, &measured);
}

static void set_salient(double resistance, double inductance, double saliency)
{
    set_words(resistance_of(resistance), inductance_of(inductance), saliency_of(saliency));
}

static void set(double resistance, double inductance)
{
    set_salient(resistance, inductance, 1.0);
}

/* A nominal value times a ratio. */
static void assert_scaled(const char *what, int32_t nominal, double ratio, int32_t actual)
{
    const double expected = nominal * ratio;

    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(ROUNDING + (fabs(expected) * RATIO_TOLERANCE), expected,
                                      actual, what);
}

static void assert_loop(const current_loop_cfg_t *nominal, const current_loop_cfg_t *actual,
                        double l, double saliency)
{
    assert_scaled("ω·L_d", nominal->reactance_d_q13, l, actual->reactance_d_q13);
    assert_scaled("ω·L_q", nominal->reactance_q_q13, l * saliency, actual->reactance_q_q13);
}

/* Every number that the model corrects, for ratios of R, L_d, L_q/L_d and φ. */
static void assert_salient_model(double r, double l, double saliency, double flux)
{
    const nn_observer_cfg_t *const o = &model.observer;

    assert_scaled("1 - W1", observer.decay, r / l, o->decay);
    assert_scaled("W3", observer.volt_gain, 1.0 / l, o->volt_gain);
    assert_scaled("eta", observer.eta, l * l, o->eta);
    assert_scaled("kappa_p", observer.kappa_p, l * l, o->kappa_p);
    assert_scaled("corner", observer.corner, r / l, o->corner);
    assert_scaled("flux", observer.flux_q27, flux / l, o->flux_q27);
    assert_scaled("R in run", run_loop.resistance_q13, r, model.run_loop.resistance_q13);
    assert_scaled("R in hold", hold_loop.resistance_q13, r, model.hold_loop.resistance_q13);
    assert_scaled("EMF in run", run_loop.emf_q13, flux, model.run_loop.emf_q13);
    assert_scaled("EMF in hold", hold_loop.emf_q13, flux, model.hold_loop.emf_q13);
    assert_scaled("L_q/L_d", observer.saliency_q13, saliency, o->saliency_q13);
    assert_scaled("L_d/L_q", observer.iq_gain_q14, 1.0 / saliency, o->iq_gain_q14);
    assert_loop(&run_loop, &model.run_loop, l, saliency);
    assert_loop(&hold_loop, &model.hold_loop, l, saliency);
    assert_scaled("K_p of d", run_loop.pi_d.kp, l, model.run_loop.pi_d.kp);
    assert_scaled("K_i of d", run_loop.pi_d.ki, l, model.run_loop.pi_d.ki);
    assert_scaled("K_p of q", run_loop.pi_q.kp, l * saliency, model.run_loop.pi_q.kp);
    assert_scaled("K_i of q", run_loop.pi_q.ki, l * saliency, model.run_loop.pi_q.ki);
}

static void assert_model(double r, double l, double flux)
{
    assert_salient_model(r, l, 1.0, flux);
}

static void put_back(current_loop_cfg_t *loop, const current_loop_cfg_t *nominal)
{
    loop->reactance_d_q13 = nominal->reactance_d_q13;
    loop->reactance_q_q13 = nominal->reactance_q_q13;
    loop->resistance_q13 = nominal->resistance_q13;
    loop->emf_q13 = nominal->emf_q13;
}

/* The model with what it corrects put back. */
static void assert_rest_untouched(void)
{
    nn_observer_cfg_t o = model.observer;
    current_loop_cfg_t run = model.run_loop;
    current_loop_cfg_t hold = model.hold_loop;

    o.decay = observer.decay;
    o.volt_gain = observer.volt_gain;
    o.eta = observer.eta;
    o.kappa_p = observer.kappa_p;
    o.feedback_q15 = observer.feedback_q15;
    o.corner = observer.corner;
    o.flux_q27 = observer.flux_q27;
    o.saliency_q13 = observer.saliency_q13;
    o.iq_gain_q14 = observer.iq_gain_q14;
    put_back(&run, &run_loop);
    put_back(&hold, &hold_loop);
    run.pi_d.kp = run_loop.pi_d.kp;
    run.pi_d.ki = run_loop.pi_d.ki;
    run.pi_q.kp = run_loop.pi_q.kp;
    run.pi_q.ki = run_loop.pi_q.ki;
    TEST_ASSERT_EQUAL_MEMORY(&observer, &o, sizeof o);
    TEST_ASSERT_EQUAL_MEMORY(&run_loop, &run, sizeof run);
    TEST_ASSERT_EQUAL_MEMORY(&hold_loop, &hold, sizeof hold);
}

static void assert_ratios(int32_t resistance, int32_t inductance, int32_t saliency, int32_t flux)
{
    TEST_ASSERT_EQUAL_INT32_MESSAGE(resistance, model.resistance_q14, "R");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(inductance, model.inductance_q14, "L_d");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(saliency, model.saliency_q14, "L_q/L_d");
    TEST_ASSERT_EQUAL_INT32_MESSAGE(flux, model.flux_q30, "flux");
}

TEST(test_reset_takes_the_configured_values_bit_by_bit)
{
    TEST_ASSERT_EQUAL_MEMORY(&observer, &model.observer, sizeof observer);
    TEST_ASSERT_EQUAL_MEMORY(&run_loop, &model.run_loop, sizeof run_loop);
    TEST_ASSERT_EQUAL_MEMORY(&hold_loop, &model.hold_loop, sizeof hold_loop);
    assert_ratios(16384, 16384, 16384, 1 << 30);
}

/* Each measurement replaces the one before. */
TEST(test_measured_ratios_reach_every_weight_and_both_loops_and_nothing_else)
{
    static const double resistances[] = {0.5, 0.8, 1.0, 1.3, 1.55};
    static const double inductances[] = {0.65, 0.8, 1.0, 1.2, 1.35};

    for (uint32_t i = 0U; i < 25U; i++) {
        const double r = resistances[i % 5U];
        const double l = inductances[i / 5U];

        set(r, l);
        /* R itself is an integer near 1547. */
        assert_model(resistance_of(r) / (double)run_loop.resistance_q13, l, 1.0);
        assert_rest_untouched();
    }
}

TEST(test_a_measured_saliency_reaches_the_network_and_the_q_axis)
{
    static const double nominals[] = {0.8, 1.0, 1.6};
    static const double ratios[] = {0.52, 0.8, 1.0, 1.3, 1.95};

    for (uint32_t i = 0U; i < 15U; i++) {
        observer.saliency_q13 = (int32_t)lround(8192.0 * nominals[i / 5U]);
        observer.iq_gain_q14 = (int32_t)lround(8192.0 / nominals[i / 5U]); /* half, with room */
        model_reset(&model, &NOMINAL);
        set_salient(1.0, 1.2, ratios[i % 5U]);
        assert_salient_model(1.0, 1.2, ratios[i % 5U], 1.0);
        assert_rest_untouched();
    }
}

/* Two current sensors differ by 2 %, and the measurement is not exact. */
TEST(test_a_saliency_within_a_32nd_of_the_configured_one_is_that_one)
{
    static const int32_t nearest[] = {8192 - 256, 8192, 8192 + 256};

    for (uint32_t i = 0U; i < 3U; i++) {
        set_words(resistance_of(1.0), inductance_of(1.2), nearest[i]);
        TEST_ASSERT_EQUAL_INT32(8192, model.observer.saliency_q13);
        TEST_ASSERT_EQUAL_INT32(observer.iq_gain_q14, model.observer.iq_gain_q14);
        assert_model(1.0, 1.2, 1.0);
    }
    set_words(resistance_of(1.0), inductance_of(1.2), nearest[0] - 1);
    TEST_ASSERT_EQUAL_INT32(8192 - 257, model.observer.saliency_q13);
    set_words(resistance_of(1.0), inductance_of(1.2), nearest[2] + 1);
    TEST_ASSERT_EQUAL_INT32(8192 + 257, model.observer.saliency_q13);
}

TEST(test_an_unknown_saliency_leaves_the_configured_one)
{
    set_salient(1.0, 1.2, 1.5);
    set_words(resistance_of(1.0), inductance_of(1.2), -1);
    assert_model(1.0, 1.2, 1.0);
}

/* f of this decay, as whole units of it: what nn_observer_units.cpp writes. */
static void feed_back(int32_t decay, int32_t units)
{
    observer.decay = decay;
    observer.feedback_q15 = (int32_t)lround(fmin(units * 32768.0 / decay, FX_Q15_MAX));
    model_reset(&model, &NOMINAL);
}

TEST(test_what_was_configured_is_measured_as_no_change_with_and_without_feedback)
{
    seeded_t seed = {0xFEEDU};

    for (int32_t k = 0; k < 2000; k++) {
        const int32_t decay = seeded_in(&seed, 2, 32767);
        model_t before;

        observer.corner = seeded_in(&seed, 1, 1 << 27);
        feed_back(decay, (k < 100) ? 0 : seeded_in(&seed, 1, decay - 1));
        before = model;
        set(1.0, 1.0);
        TEST_ASSERT_EQUAL_MEMORY(&before, &model, sizeof model);
    }
}

TEST(test_measured_resistance_and_inductance_scale_the_windings_decay_not_the_feedback)
{
    static const double resistances[] = {0.5, 1.3, 1.55};
    static const double inductances[] = {0.65, 1.0, 1.35};
    const double winding = 2401.0;
    const double feedback = 10706.0;

    feed_back(2401 + 10706, 10706);
    observer.corner = 68000000;
    for (uint32_t i = 0U; i < 9U; i++) {
        const double r = resistance_of(resistances[i % 3U]) / (double)run_loop.resistance_q13;
        const double ratio = r / inductances[i / 3U];
        const double scale = ((winding * ratio) + feedback) / (winding + feedback);
        const double bound = ROUNDING + (winding * ratio * RATIO_TOLERANCE);

        model_reset(&model, &NOMINAL);
        set(resistances[i % 3U], inductances[i / 3U]);
        TEST_ASSERT_DOUBLE_WITHIN(bound, (winding * ratio) + feedback, model.observer.decay);
        /* f of it stays: as a mantissa within the half that its share is rounded to. */
        TEST_ASSERT_DOUBLE_WITHIN(0.5 * model.observer.decay / 32768.0, feedback,
                                  model.observer.decay * model.observer.feedback_q15 / 32768.0);
        TEST_ASSERT_DOUBLE_WITHIN(observer.corner * bound / (winding + feedback),
                                  observer.corner * scale, model.observer.corner);
    }
}

TEST(test_ratios_end_at_their_limits)
{
    /* 9830/2^14 = 0.59998, 6554/2^14 = 0.40002. */
    const double r = 9830.0 / ONE_Q14;
    const double l = 6554.0 / ONE_Q14;

    set_words(32767, 32767, saliency_of(1.0));
    assert_model(1.0 + r, 1.0 + l, 1.0);
    set_words(1, 1, saliency_of(1.0));
    assert_model(1.0 - r, 1.0 - l, 1.0);
    set(1.7, 1.0);
    assert_model(1.0 + r, 1.0, 1.0);
    set(1.0, 0.5);
    assert_model(1.0, 1.0 - l, 1.0);
    cfg.saliency_limit_q14 = 8192;
    set_salient(1.0, 1.0, 1.7);
    assert_salient_model(1.0, 1.0, 1.5, 1.0);
    set_salient(1.0, 1.0, 0.5);
    assert_salient_model(1.0, 1.0, 1.0 / 1.5, 1.0);
}

TEST(test_with_the_corrections_off_and_without_a_full_speed_nothing_changes)
{
    seeded_t seed = {0x0FF0FFU};
    const model_t before = model;

    cfg = example_model_cfg();
    for (int32_t k = 0; k < 1000; k++) {
        set_words(seeded_in(&seed, 1, 32767), seeded_in(&seed, 1, 32767),
                  seeded_in(&seed, 1, 32767));
        model_track_flux(&model, &cfg, &NOMINAL, seeded_in(&seed, -8192, 8191),
                         seeded_in(&seed, -30000000, 30000000));
        model_pace(&model, &cfg, &NOMINAL, seeded_in(&seed, -0x40000000, 0x40000000));
        TEST_ASSERT_EQUAL_MEMORY(&before, &model, sizeof model);
    }
}

TEST(test_each_correction_is_switched_off_alone)
{
    cfg.resistance_limit_q14 = 0;
    set(1.5, 1.2);
    assert_model(1.0, 1.2, 1.0);
    cfg = example_model_cfg_with_corrections();
    cfg.inductance_limit_q14 = 0;
    set_salient(1.5, 1.2, 1.5);
    assert_salient_model(resistance_of(1.5) / (double)run_loop.resistance_q13, 1.0, 1.5, 1.0);
    cfg = example_model_cfg_with_corrections();
    cfg.saliency_limit_q14 = 0;
    set_salient(1.0, 1.2, 1.5);
    assert_model(1.0, 1.2, 1.0);
}

/* ---- shares of the gains by the speed ---- */

#define PACE_SPEED (2600000)   /* 2^13 < it >> 8 < 2^14 */
#define KAPPA_SPEED (20000000) /* likewise >> 11 */

/*
 * A speed is cut to 2^-13 of full_speed at least, and so is full_speed for the gain, whose rounding
 * is 2^-14. The share and each product with it are rounded down: 2^-14 of the share, 1 of the
 * mantissa. η takes pace twice and κ once: three shares, five products.
 */
#define SHARE_TOLERANCE ((2.0 / 8192.0) + (2.0 / ONE_Q14))
#define SHARES_ROUNDING (5.0)

static gain_share_cfg_t share_of(step_t full_speed, uint32_t shift, double least)
{
    return (gain_share_cfg_t){
        .full_speed = full_speed,
        .shift = shift,
        .gain = (1 << 28) / (full_speed >> shift),
        .least_q14 = (int32_t)lround(ONE_Q14 * least),
    };
}

static void configure_shares(void)
{
    cfg.pace = share_of(PACE_SPEED, 8U, 0.25);
    cfg.kappa = share_of(KAPPA_SPEED, 11U, 0.5);
}

static void assert_shared(const char *what, int32_t nominal, double share, int32_t actual)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SHARES_ROUNDING + (3.0 * nominal * SHARE_TOLERANCE),
                                      nominal * share, actual, what);
}

static void assert_shares(double pace, double kappa, double l)
{
    const nn_observer_cfg_t *const o = &model.observer;

    assert_shared("eta", observer.eta, l * l * pace * pace * kappa, o->eta);
    assert_shared("kappa_p", observer.kappa_p, l * l * pace, o->kappa_p);
    assert_shared("rho", observer.rho_max_q13, pace, o->rho_max_q13);
    assert_shared("K_p of d", run_loop.pi_d.kp, l * pace, model.run_loop.pi_d.kp);
    assert_shared("K_i of d", run_loop.pi_d.ki, l * pace, model.run_loop.pi_d.ki);
    assert_shared("K_p of q", run_loop.pi_q.kp, l * pace, model.run_loop.pi_q.kp);
    assert_shared("K_i of q", run_loop.pi_q.ki, l * pace, model.run_loop.pi_q.ki);
}

static void pace(step_t speed)
{
    model_pace(&model, &cfg, &NOMINAL, speed);
}

TEST(test_gains_are_the_share_of_the_speed_and_not_below_the_least)
{
    static const struct {
        step_t speed;
        double pace;
        double kappa;
    } cases[] = {
        {0, 0.25, 0.5},
        {PACE_SPEED / 5, 0.25, 0.5},
        {PACE_SPEED / 2, 0.5, 0.5},
        {PACE_SPEED * 9 / 10, 0.9, 0.5},
        {PACE_SPEED, 1.0, 0.5},
        {KAPPA_SPEED * 3 / 4, 1.0, 0.75},
        {KAPPA_SPEED, 1.0, 1.0},
        {0x40000000, 1.0, 1.0},
    };

    configure_shares();
    observer.rho_max_q13 = 16384;
    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        pace(cases[k].speed);
        assert_shares(cases[k].pace, cases[k].kappa, 1.0);
        pace(0);
        pace(-cases[k].speed);
        assert_shares(cases[k].pace, cases[k].kappa, 1.0);
    }
}

TEST(test_whole_gains_come_back_bit_for_bit)
{
    const model_t before = model;

    configure_shares();
    pace(0);
    pace(KAPPA_SPEED);
    TEST_ASSERT_EQUAL_MEMORY(&before, &model, sizeof model);
}

TEST(test_a_measured_inductance_and_the_shares_act_together_in_either_order)
{
    configure_shares();
    pace(PACE_SPEED / 2);
    set(1.0, 1.25);
    assert_shares(0.5, 0.5, 1.25);
    pace(KAPPA_SPEED);
    assert_shares(1.0, 1.0, 1.25);
}

TEST(test_any_share_cfg_in_range_keeps_the_gains_in_range)
{
    seeded_t seed = {0x5EEDU};

    for (int32_t k = 0; k < 10000; k++) {
        cfg.pace =
            (gain_share_cfg_t){seeded_in(&seed, 0, 0x10000000), (uint32_t)seeded_in(&seed, 0, 15),
                               seeded_in(&seed, 0, 32767), seeded_in(&seed, 0, 16384)};
        cfg.kappa = cfg.pace;
        pace(seeded_in(&seed, -0x40000000, 0x40000000));
        TEST_ASSERT_TRUE((model.pace_q14 >= cfg.pace.least_q14) && (model.pace_q14 <= 16384));
        TEST_ASSERT_TRUE((model.observer.eta >= 0) && (model.observer.eta <= observer.eta));
        TEST_ASSERT_TRUE(model.observer.kappa_p <= observer.kappa_p);
    }
}

/* ---- flux ---- */

/*
 * Slow periods beside a motor whose flux is `ratio` times the nominal; e'_d as an ideal observer
 * shows it.
 */
static void track(double ratio, int32_t periods, step_t speed)
{
    for (int32_t k = 0; k < periods; k++) {
        const double wrong = (model.flux_q30 / ONE_Q30) - ratio;

        model_track_flux(&model, &cfg, &NOMINAL, (int32_t)lround(wrong * FLUX_CURRENT_LSB), speed);
    }
}

/* Below half a LSB of e'_d nothing moves; the sum is rounded by the rate of 786 in 2^30. */
#define FLUX_TOLERANCE ((0.5 / FLUX_CURRENT_LSB) + (786.0 / ONE_Q30))

TEST(test_flux_converges_to_that_of_the_motor_in_both_directions_of_rotation)
{
    static const double ratios[] = {0.76, 0.9, 0.95, 1.0, 1.1, 1.24};

    for (uint32_t i = 0U; i < 12U; i++) {
        model_reset(&model, &NOMINAL);
        track(ratios[i / 2U], 800, ((i % 2U) == 0U) ? FAST : -FAST); /* e^-16 of 0.24 is left */
        TEST_ASSERT_DOUBLE_WITHIN(FLUX_TOLERANCE, ratios[i / 2U], model.flux_q30 / ONE_Q30);
        assert_model(1.0, 1.0, ratios[i / 2U]);
        assert_rest_untouched();
    }
}

/*
 * flux_rate is 1 ms/50 ms; (1 − 0.02)^50 = 0.364 of the first error is left, e'_d rounded to LSB: ½
 * of 2733.
 */
TEST(test_flux_converges_with_its_time_constant)
{
    track(0.9, 50, FAST);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * ((786.0 / 785.8) - 1.0 + (0.5 / 2733.0) + 0.0005),
                              0.9 + (0.1 * pow(1.0 - (786.0 * FLUX_CURRENT_LSB / ONE_Q30), 50.0)),
                              model.flux_q30 / ONE_Q30);
}

TEST(test_flux_ends_at_its_limits)
{
    track(1.5, 2000, FAST);
    assert_model(1.0, 1.0, 1.25);
    TEST_ASSERT_EQUAL_INT32((1 << 30) + (4096 << 16), model.flux_q30);
    track(0.5, 2000, FAST);
    assert_model(1.0, 1.0, 0.75);
    TEST_ASSERT_EQUAL_INT32((1 << 30) - (4096 << 16), model.flux_q30);
}

TEST(test_flux_is_tracked_from_the_least_speed_on_only)
{
    const model_t before = model;
    const step_t least = cfg.flux_speed_min;

    track(0.9, 100, least - 1);
    track(0.9, 100, 1 - least);
    track(0.9, 100, 0);
    TEST_ASSERT_EQUAL_MEMORY(&before, &model, sizeof model);
    track(0.9, 1, least);
    TEST_ASSERT_TRUE(model.flux_q30 < before.flux_q30);
    model = before;
    track(0.9, 1, -least);
    TEST_ASSERT_TRUE(model.flux_q30 < before.flux_q30);
}

TEST(test_flux_and_inductance_both_reach_the_shift_of_the_state)
{
    track(0.9, 800, FAST);
    set(1.0, 1.2);
    assert_model(1.0, 1.2, 0.9);
    track(1.1, 800, FAST);
    assert_model(1.0, 1.2, 1.1);
}

/* ---- ends of the formats ---- */

TEST(test_numbers_without_room_to_grow_end_at_15_bits_and_the_flux_at_27)
{
    observer.decay = 32767;
    observer.volt_gain = 32767;
    observer.eta = 32767;
    observer.kappa_p = 32767;
    observer.flux_q27 = 0x7FFFFFF;
    run_loop.emf_q13 = 32767;
    run_loop.resistance_q13 = 20000;
    cfg = (model_cfg_t){.resistance_limit_q14 = 15000,
                        .inductance_limit_q14 = 8192,
                        .flux_limit_q14 = 8192,
                        .flux_rate = 32767};
    model_reset(&model, &NOMINAL);
    for (int32_t k = 0; k < 100; k++) {
        model_track_flux(&model, &cfg, &NOMINAL, -8192, 0x20000000);
    }
    set_words(32767, 1, saliency_of(1.0));
    TEST_ASSERT_EQUAL_INT32(32767, model.observer.decay);
    TEST_ASSERT_EQUAL_INT32(32767, model.observer.volt_gain);
    TEST_ASSERT_EQUAL_INT32(0x7FFFFFF, model.observer.flux_q27);
    TEST_ASSERT_EQUAL_INT32(32767, model.run_loop.emf_q13);
    TEST_ASSERT_EQUAL_INT32(32767, model.hold_loop.emf_q13);
    set_words(32767, 32767, saliency_of(1.0));
    TEST_ASSERT_EQUAL_INT32(32767, model.observer.eta);
    TEST_ASSERT_EQUAL_INT32(32767, model.observer.kappa_p);
    /* 16384 units of it are fed back, and stay: 16384.5/2^15 of 32767, rounded up. */
    observer.feedback_q15 = 16384;
    model_reset(&model, &NOMINAL);
    set_words(32767, 1, saliency_of(1.0));
    TEST_ASSERT_EQUAL_INT32(32767, model.observer.decay);
    TEST_ASSERT_EQUAL_INT32(16385, model.observer.feedback_q15);
}

TEST(test_a_nominal_resistance_of_zero_is_no_division_by_zero)
{
    run_loop.resistance_q13 = 0;
    model_reset(&model, &NOMINAL);
    set_words(32767, 16384, saliency_of(1.0));
    TEST_ASSERT_EQUAL_INT32(16384 + 9830, model.resistance_q14);
    TEST_ASSERT_EQUAL_INT32(0, model.run_loop.resistance_q13);
}

TEST(test_gains_are_whole_with_both_shares_at_a_speed_that_has_them)
{
    const model_cfg_t shares = {.pace = {.full_speed = 1000}, .kappa = {.full_speed = 2000}};
    const model_cfg_t other = {.pace = {.full_speed = 2000}, .kappa = {.full_speed = 1000}};
    model_t of_speed = {.pace_q14 = MODEL_RATIO_ONE, .kappa_q14 = MODEL_RATIO_ONE};

    TEST_ASSERT_TRUE(model_is_whole(&of_speed, &shares, 2000));
    TEST_ASSERT_FALSE(model_is_whole(&of_speed, &shares, 1999));
    TEST_ASSERT_TRUE(model_is_whole(&of_speed, &other, 2000));
    TEST_ASSERT_FALSE(model_is_whole(&of_speed, &other, 1999));
    of_speed.pace_q14--;
    TEST_ASSERT_FALSE(model_is_whole(&of_speed, &shares, 2000));
    of_speed.pace_q14++;
    of_speed.kappa_q14--;
    TEST_ASSERT_FALSE(model_is_whole(&of_speed, &shares, 2000));
}

TEST(test_the_ratio_of_l_q_is_that_of_l_d_times_that_of_the_saliency_rounded_down)
{
    const model_t half = {.inductance_q14 = 8192, .saliency_q14 = 24577};
    const model_t more = {.inductance_q14 = 24576, .saliency_q14 = 32767};

    TEST_ASSERT_EQUAL_INT32(12288, model_ratio_q_q14(&half));
    TEST_ASSERT_EQUAL_INT32(49150, model_ratio_q_q14(&more));
}

/* ---- another configuration ---- */

static const model_measured_t MEASURED = {
    .resistance_q13 = 2200, .inductance_q14 = 18000, .saliency_q13 = 9500};

static void configure_another(void)
{
    observer.eta /= 2;
    observer.gradient_shift--;
    observer.momentum_q15 = 1000;
    observer.flux_q27 += observer.flux_q27 / 16;
    run_loop.resistance_q13 += 40;
    run_loop.pi_q.ki /= 2;
    run_loop.pi_q.kp_shift++;
    hold_loop.pi_d.kp++;
}

/*
 * The same ratios on the new values, as if they had been measured then: no number is of the
 * configuration before.
 */
TEST(test_a_change_is_what_the_same_ratios_make_of_the_new_values)
{
    model_t fresh;

    model_set(&model, &cfg, &NOMINAL, &MEASURED);
    model.flux_q30 = (int32_t)(0.9375 * ONE_Q30);
    model.pace_q14 = 8192;
    model.kappa_q14 = 12288;
    fresh = model;
    configure_another();
    model_change(&model, &cfg, &NOMINAL);
    assert_ratios(fresh.resistance_q14, fresh.inductance_q14, fresh.saliency_q14, fresh.flux_q30);
    model_reset(&fresh, &NOMINAL);
    fresh.resistance_q14 = model.resistance_q14;
    fresh.flux_q30 = model.flux_q30;
    fresh.pace_q14 = model.pace_q14;
    fresh.kappa_q14 = model.kappa_q14;
    model_set(&fresh, &cfg, &NOMINAL,
              &(model_measured_t){MODEL_UNKNOWN, MEASURED.inductance_q14, MEASURED.saliency_q13});
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &model, sizeof fresh);
}

TEST(test_a_change_to_the_same_values_changes_no_bit)
{
    model_t before;

    model_set(&model, &cfg, &NOMINAL, &MEASURED);
    before = model;
    model_change(&model, &cfg, &NOMINAL);
    TEST_ASSERT_EQUAL_MEMORY(&before, &model, sizeof before);
}

TEST(test_narrower_limits_hold_for_what_was_measured_before)
{
    model_set(&model, &cfg, &NOMINAL, &MEASURED);
    model.flux_q30 = (int32_t)(0.9375 * ONE_Q30);
    TEST_ASSERT_TRUE(model.resistance_q14 > (16384 + 100));
    cfg = (model_cfg_t){.resistance_limit_q14 = 100};
    model_change(&model, &cfg, &NOMINAL);
    assert_ratios(16384 + 100, 16384, 16384, 0x40000000);
    TEST_ASSERT_EQUAL_INT32(16384, model.inductance_inverse_q14);
    TEST_ASSERT_EQUAL_INT32(run_loop.emf_q13, model.run_loop.emf_q13);
}
