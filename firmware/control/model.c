/* SPDX-License-Identifier: MIT */
#include "model.h"

#include "fx.h"
#include "inlining.h"

#define ONE_Q30 (0x40000000)
#define Q14_TO_Q30 (16U)
#define FLUX_MAX_Q27 (0x7FFFFFF)
#define CORNER_MAX (0x8000000)
#define HALF_Q15 (0x4000)
#define SALIENCY_CERTAIN (512) /* 1/32 in Q14: a smaller deviation of the saliency is ignored */

static int32_t limited(int32_t ratio_q14, int32_t limit_q14)
{
    return fx_clamp(ratio_q14, MODEL_RATIO_ONE - limit_q14, MODEL_RATIO_ONE + limit_q14);
}

/*
 * Returns mantissa · ratio, at most 32767. The mantissa has at most 15 bits, the ratio is below 4.
 */
static int32_t times(int32_t mantissa, int32_t ratio_q14)
{
    return fx_min(fx_asr(mantissa * ratio_q14, 14U), FX_Q15_MAX);
}

/* Returns word · ratio. The word is at most 2^28, the ratio is below 2. */
static int32_t times_wide(int32_t word, int32_t ratio_q14)
{
    return fx_mul_32x16(word * 4, ratio_q14);
}

static int32_t inverse_q14(int32_t ratio_q14)
{
    return fx_min((MODEL_RATIO_ONE * MODEL_RATIO_ONE) / ratio_q14, FX_Q15_MAX);
}

/* Returns part / whole rounded to nearest, Q15. 0 ≤ part ≤ whole ≤ 32767, whole > 0. */
static int32_t share_q15(int32_t part, int32_t whole)
{
    return fx_min(((part * 32768) + (whole / 2)) / fx_max(whole, 1), FX_Q15_MAX);
}

/*
 * Returns the XOR of the words that only model_reset(), model_set() and model_change() write. A bit
 * that flips in one of them flips in the result.
 */
static uint32_t observer_word(const model_t *model)
{
    const nn_observer_cfg_t *const o = &model->observer;
    const uint32_t shifts =
        o->weight_shift ^ o->current_shift ^ o->gradient_shift ^ o->eta_shift ^ o->kappa_p_shift;
    const int32_t weights = o->decay ^ o->volt_gain ^ o->feedback_q15 ^ o->iq_gain_q14 ^
                            o->saliency_q13 ^ o->momentum_q15 ^ o->frame_share_q13;
    const int32_t speeds = o->speed_limit ^ o->corner ^ o->rho_speed_min;
    const int32_t ratios = model->resistance_q14 ^ model->inductance_q14 ^
                           model->inductance_inverse_q14 ^ model->saliency_q14;

    return shifts ^ fx_unsigned(weights ^ speeds ^ ratios);
}

static uint32_t shifts_word(const current_loop_cfg_t *loop)
{
    return loop->pi_d.kp_shift ^ loop->pi_d.ki_shift ^ loop->pi_q.kp_shift ^ loop->pi_q.ki_shift;
}

static int32_t proportions_word(const current_loop_cfg_t *loop)
{
    return loop->pi_d.kp ^ loop->pi_d.ki ^ loop->pi_q.kp ^ loop->pi_q.ki;
}

static int32_t winding_word(const current_loop_cfg_t *loop)
{
    return loop->reactance_d_q13 ^ loop->reactance_q_q13 ^ loop->resistance_q13;
}

static uint32_t loops_word(const model_t *model)
{
    const current_loop_cfg_t *const run = &model->run_loop;
    const current_loop_cfg_t *const hold = &model->hold_loop;

    return shifts_word(run) ^ shifts_word(hold) ^
           fx_unsigned(winding_word(run) ^ winding_word(hold) ^ proportions_word(hold));
}

/* Returns the XOR of the words that model_pace() writes too. */
static uint32_t gains_word(const model_t *model)
{
    const nn_observer_cfg_t *const o = &model->observer;

    return fx_unsigned(o->eta ^ o->kappa_p ^ o->rho_max_q13 ^ proportions_word(&model->run_loop) ^
                       model->pace_q14 ^ model->kappa_q14);
}

static int32_t flux_word(const model_t *model)
{
    return model->observer.flux_q27 ^ model->run_loop.emf_q13 ^ model->hold_loop.emf_q13;
}

static void seal(model_t *model)
{
    model->check_observer = observer_word(model);
    model->check_loops = loops_word(model);
    model->check_gains = gains_word(model);
}

static void apply_flux(model_t *model, const model_nominal_t *nominal)
{
    const int32_t flux_q14 = fx_asr(model->flux_q30, Q14_TO_Q30);
    const int32_t flux_q27 = times_wide(nominal->observer->flux_q27, flux_q14);

    model->observer.flux_q27 =
        fx_min(times_wide(flux_q27, model->inductance_inverse_q14), FLUX_MAX_Q27);
    model->run_loop.emf_q13 = times(nominal->run_loop->emf_q13, flux_q14);
    model->hold_loop.emf_q13 = model->run_loop.emf_q13;
}

/*
 * Corrects D = T·R/L + f and its corner D/T. The ratios of R and L scale T·R/L, the part of the
 * winding; f, the part of the feedback, stays. The mantissa of the feedback is rounded to nearest,
 * and so is its share of the new D, so that ratios of 1 change no bit. fx_max tells the proof that
 * a part is not more than the whole.
 */
static void apply_decay(model_t *model, const nn_observer_cfg_t *from)
{
    nn_observer_cfg_t *const to = &model->observer;
    const int32_t r = model->resistance_q14;
    const int32_t inverse = model->inductance_inverse_q14;
    const int32_t feedback = fx_asr((from->decay * from->feedback_q15) + HALF_Q15, 15U);
    const int32_t winding = times(times(fx_max(from->decay - feedback, 0), r), inverse);
    const int32_t corner = fx_mul_32x16(from->corner, from->feedback_q15) * 2;
    const int32_t winding_corner =
        times_wide(times_wide(fx_max(from->corner - corner, 0), r), inverse);

    to->decay = fx_min(winding + feedback, FX_Q15_MAX);
    if (feedback != 0) {
        to->feedback_q15 = share_q15(feedback, to->decay);
    }
    to->corner = fx_min(winding_corner + corner, CORNER_MAX);
}

/*
 * Sets W1 and W3 of paper A for the corrected R and L: T·R/L, T/L. The ratios are applied one after
 * the other, because their product may be above 2.
 */
static void apply_weights(model_t *model, const model_nominal_t *nominal)
{
    const nn_observer_cfg_t *const from = nominal->observer;
    nn_observer_cfg_t *const to = &model->observer;

    apply_decay(model, from);
    to->volt_gain = times(from->volt_gain, model->inductance_inverse_q14);
    to->saliency_q13 = fx_max(times(from->saliency_q13, model->saliency_q14), 1);
    to->iq_gain_q14 = fx_max(times(from->iq_gain_q14, inverse_q14(model->saliency_q14)), 1);
    model->run_loop.resistance_q13 =
        times(nominal->run_loop->resistance_q13, model->resistance_q14);
    model->hold_loop.resistance_q13 = model->run_loop.resistance_q13;
}

static void scale_gains(pi_cfg_t *to, const pi_cfg_t *from, int32_t ratio_q14, int32_t pace_q14)
{
    to->kp = times(times(from->kp, ratio_q14), pace_q14);
    to->ki = times(times(from->ki, ratio_q14), pace_q14);
}

/*
 * Sets η for the corrected L, so that κ = η·(φ/L)² stays. κ is the square of a rate, so it scales
 * with the square of the pace.
 */
static void apply_eta(model_t *model, const nn_observer_cfg_t *from)
{
    const int32_t l = model->inductance_q14;
    const int32_t pace = model->pace_q14;
    const int32_t eta = times(times(from->eta, l), l);

    model->observer.eta = times(times(times(eta, pace), pace), model->kappa_q14);
}

/*
 * Sets the gains for the corrected L. κ_p scales with L², as η does. K_p is ω_c·L. K_i scales with
 * K_p, so that the corner of the integral stays. κ_p and K_p are rates, so they scale with the
 * pace.
 */
static void apply_gains(model_t *model, const model_nominal_t *nominal)
{
    const nn_observer_cfg_t *const from = nominal->observer;
    nn_observer_cfg_t *const to = &model->observer;
    const int32_t pace = model->pace_q14;
    const int32_t d = model->inductance_q14;
    const int32_t q = model_ratio_q_q14(model);

    apply_eta(model, from);
    to->kappa_p = times(times(times(from->kappa_p, d), d), pace);
    to->rho_max_q13 = times(from->rho_max_q13, pace);
    scale_gains(&model->run_loop.pi_d, &nominal->run_loop->pi_d, d, pace);
    scale_gains(&model->run_loop.pi_q, &nominal->run_loop->pi_q, q, pace);
}

/* Sets the reactances of both loops. */
static void apply_inductances(model_t *model, const model_nominal_t *nominal)
{
    const int32_t d = model->inductance_q14;
    const int32_t q = model_ratio_q_q14(model);
    current_loop_cfg_t *const run = &model->run_loop;
    current_loop_cfg_t *const hold = &model->hold_loop;

    run->reactance_d_q13 = times(nominal->run_loop->reactance_d_q13, d);
    run->reactance_q_q13 = times(nominal->run_loop->reactance_q_q13, q);
    hold->reactance_d_q13 = run->reactance_d_q13;
    hold->reactance_q_q13 = run->reactance_q_q13;
}

static void apply_all(model_t *model, const model_nominal_t *nominal)
{
    apply_weights(model, nominal);
    apply_gains(model, nominal);
    apply_inductances(model, nominal);
    apply_flux(model, nominal);
    seal(model);
}

static int32_t limited_saliency(const model_cfg_t *cfg, int32_t ratio_q14)
{
    const int32_t most = fx_min(MODEL_RATIO_ONE + cfg->saliency_limit_q14, FX_Q15_MAX);

    return fx_clamp(ratio_q14, inverse_q14(most), most);
}

static int32_t limited_flux(const model_cfg_t *cfg, int32_t ratio_q30)
{
    const uint32_t unit = 1UL << Q14_TO_Q30;
    const int32_t band_q30 = cfg->flux_limit_q14 * (int32_t)unit;

    return fx_clamp(ratio_q30, ONE_Q30 - band_q30, ONE_Q30 + band_q30);
}

/* Returns the correction of the saliency: measured / configured saliency, limited. */
static int32_t saliency_ratio(const model_cfg_t *cfg, int32_t nominal_q13, int32_t measured_q13)
{
    int32_t ratio = MODEL_RATIO_ONE;

    if (measured_q13 > 0) {
        ratio = (measured_q13 * MODEL_RATIO_ONE) / fx_max(nominal_q13, 1);
    }
    if (fx_abs(ratio - MODEL_RATIO_ONE) <= SALIENCY_CERTAIN) {
        ratio = MODEL_RATIO_ONE;
    }
    return limited_saliency(cfg, ratio);
}

void model_reset(model_t *model, const model_nominal_t *nominal)
{
    *model = (model_t){
        .observer = *nominal->observer,
        .run_loop = *nominal->run_loop,
        .hold_loop = *nominal->hold_loop,
        .resistance_q14 = MODEL_RATIO_ONE,
        .inductance_q14 = MODEL_RATIO_ONE,
        .inductance_inverse_q14 = MODEL_RATIO_ONE,
        .saliency_q14 = MODEL_RATIO_ONE,
        .pace_q14 = MODEL_RATIO_ONE,
        .kappa_q14 = MODEL_RATIO_ONE,
        .flux_q30 = ONE_Q30,
    };
    seal(model);
}

NEVER_INLINED void model_set(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                             const model_measured_t *measured)
{
    const int32_t nominal_q13 = fx_max(nominal->run_loop->resistance_q13, 1);

    if (measured->resistance_q13 > 0) {
        const int32_t ratio_q14 = (measured->resistance_q13 * MODEL_RATIO_ONE) / nominal_q13;

        model->resistance_q14 = limited(ratio_q14, cfg->resistance_limit_q14);
    }
    model->inductance_q14 = limited(measured->inductance_q14, cfg->inductance_limit_q14);
    model->inductance_inverse_q14 = inverse_q14(model->inductance_q14);
    model->saliency_q14 =
        saliency_ratio(cfg, nominal->observer->saliency_q13, measured->saliency_q13);
    apply_all(model, nominal);
}

RARE void model_change(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal)
{
    model->observer = *nominal->observer;
    model->run_loop = *nominal->run_loop;
    model->hold_loop = *nominal->hold_loop;
    model->resistance_q14 = limited(model->resistance_q14, cfg->resistance_limit_q14);
    model->inductance_q14 = limited(model->inductance_q14, cfg->inductance_limit_q14);
    model->inductance_inverse_q14 = inverse_q14(model->inductance_q14);
    model->saliency_q14 = limited_saliency(cfg, model->saliency_q14);
    model->flux_q30 = limited_flux(cfg, model->flux_q30);
    apply_all(model, nominal);
}

void model_track_flux(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                      int32_t error_d, step_t speed)
{
    if ((cfg->flux_limit_q14 != 0) && (fx_abs(speed) >= cfg->flux_speed_min)) {
        const int32_t flux_q30 = model->flux_q30 - (error_d * cfg->flux_rate);

        model->flux_q30 = limited_flux(cfg, flux_q30);
        apply_flux(model, nominal);
    }
}

/* Returns speed / full_speed, Q14, within least_q14…1. */
static int32_t share_at(const gain_share_cfg_t *cfg, step_t speed)
{
    int32_t share_q14 = MODEL_RATIO_ONE;

    if (speed < cfg->full_speed) {
        const int32_t mantissa = fx_min(fx_asr(speed, cfg->shift), MODEL_RATIO_ONE);

        share_q14 = fx_clamp(fx_asr(mantissa * cfg->gain, 14U), cfg->least_q14, MODEL_RATIO_ONE);
    }
    return share_q14;
}

void model_pace(model_t *model, const model_cfg_t *cfg, const model_nominal_t *nominal,
                step_t speed)
{
    const step_t magnitude = fx_abs(speed);
    const int32_t pace_q14 = share_at(&cfg->pace, magnitude);
    const int32_t kappa_q14 = share_at(&cfg->kappa, magnitude);

    if (pace_q14 != model->pace_q14) {
        model->pace_q14 = pace_q14;
        model->kappa_q14 = kappa_q14;
        apply_gains(model, nominal);
        model->check_gains = gains_word(model);
    } else if (kappa_q14 != model->kappa_q14) {
        /*
         * Only the change of κ goes into the check word, so a bit that has flipped in another word
         * stays visible.
         */
        const int32_t before = model->kappa_q14 ^ model->observer.eta;

        model->kappa_q14 = kappa_q14;
        apply_eta(model, nominal->observer);
        model->check_gains ^= fx_unsigned(before ^ (model->kappa_q14 ^ model->observer.eta));
    } else {
        /* both shares are in force already */
    }
}

static bool holds_flux(model_t *model, const model_nominal_t *nominal)
{
    const int32_t before = flux_word(model);

    apply_flux(model, nominal);
    return flux_word(model) == before;
}

bool model_holds(model_t *model, const model_nominal_t *nominal, model_part_t part)
{
    bool holds;

    switch (part) {
    case MODEL_PART_OBSERVER:
        holds = observer_word(model) == model->check_observer;
        break;
    case MODEL_PART_LOOPS:
        holds = loops_word(model) == model->check_loops;
        break;
    case MODEL_PART_GAINS:
        holds = gains_word(model) == model->check_gains;
        break;
    default: /* FLUX */
        holds = holds_flux(model, nominal);
        break;
    }
    return holds;
}
