/* SPDX-License-Identifier: MIT */
#include "nn_observer.h"

/* shift of a state from Q26, as observer_predict_state() returns it, to Q15 */
#define STATE_BITS (11U)
#define ONE_Q13 (8192)
#define SALIENCY_NONE ONE_Q13 /* L_q = L_d */
#define STATE_MAX (46341)     /* limit of x̂ and ŷ, Q15 */
#define SPEED_TO_HALF (14U)
#define PI_Q12 (12868)     /* angle of half a step in Q15 rad = (step >> 14)·π·2^12 >> 15 */
#define SPEED_TO_RHO (10U) /* speeds are divided by 2^10 before the division for ρ */

/* Returns half a step in rad, Q15: π·step / 2^32. */
static int32_t observer_half_step(step_t speed)
{
    return fx_asr(fx_asr(speed, SPEED_TO_HALF) * PI_Q12, 15U);
}

/*
 * Returns ψ_c = φ/L_d + (1 − c·L_q/L_d)·i_d + j·(L_q/L_d − c)·i_q. For c = 1 and L_q = L_d this is
 * φ/L_d, whatever the current.
 */
static dq_t observer_gradient_state(const nn_observer_cfg_t *cfg, dq_t current)
{
    const int32_t share = cfg->frame_share_q13;
    const int32_t along = ONE_Q13 - fx_asr(share * cfg->saliency_q13, 13U);
    const int32_t across = cfg->saliency_q13 - share;
    const uint32_t shift = 13U + cfg->current_shift;
    const dq_t state = {
        .d = fx_asr(cfg->flux_q27, 12U) + fx_asr(along * current.d, shift),
        .q = fx_asr(across * current.q, shift),
    };

    return (dq_t){fx_clamp(state.d, -STATE_MAX, STATE_MAX),
                  fx_clamp(state.q, -STATE_MAX, STATE_MAX)};
}

void nn_observer_start(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t speed, dq_t current,
                       sincos_t angle)
{
    const uint32_t steps = (uint32_t)1U << (STATE_BITS + 1U - cfg->current_shift);
    const int32_t unit = (int32_t)steps;
    const int32_t x_q27 = fx_sat28(cfg->flux_q27 + (current.d * unit));
    /* With saliency this value lacks the factor L_q/L_d; the error lasts for a few τ. */
    const int32_t y_q27 = fx_sat28(current.q * unit);
    const step_t limited = fx_clamp(speed, -cfg->speed_limit, cfg->speed_limit);

    *obs = (nn_observer_t){
        .alpha_q27 = fx_sat28(2 * fx_mla_32x16(fx_mul_32x16(x_q27, angle.cos), y_q27, -angle.sin)),
        .beta_q27 = fx_sat28(2 * fx_mla_32x16(fx_mul_32x16(x_q27, angle.sin), y_q27, angle.cos)),
        .state = {fx_asr(x_q27, STATE_BITS + 1U), fx_asr(y_q27, STATE_BITS + 1U)},
        .speed = limited,
        .speed_out = limited,
        .half_step_q15 = observer_half_step(limited),
        .current = {fx_sat15(current.d), fx_sat15(current.q)},
        .rotates = cfg->saliency_q13 != SALIENCY_NONE,
    };
    if (cfg->frame_share_q13 != 0) {
        obs->state = observer_gradient_state(cfg, obs->current);
    }
}

void nn_observer_change(nn_observer_t *obs, const nn_observer_cfg_t *to, int32_t flux_q27,
                        int32_t saliency_q13, sincos_t angle)
{
    const uint32_t steps = (uint32_t)1U << (STATE_BITS + 1U - to->current_shift);
    const int32_t unit = (int32_t)steps;
    const int32_t saliency = to->saliency_q13 - saliency_q13;
    const int32_t x_q27 = to->flux_q27 - flux_q27;
    const int32_t y_q27 = fx_sat28(fx_asr(obs->current.q * saliency, 13U) * unit);
    const int32_t alpha = 2 * fx_mla_32x16(fx_mul_32x16(x_q27, angle.cos), y_q27, -angle.sin);
    const int32_t beta = 2 * fx_mla_32x16(fx_mul_32x16(x_q27, angle.sin), y_q27, angle.cos);

    obs->alpha_q27 = fx_sat28(obs->alpha_q27 + alpha);
    obs->beta_q27 = fx_sat28(obs->beta_q27 + beta);
}

/* Returns î − m·(î + e). It lies between î and −e, so it fits the range of î. */
static int32_t observer_less_measured(int32_t current, int32_t error, int32_t feedback_q15)
{
    return fx_sat15(current - fx_asr(feedback_q15 * (current + error), 15U));
}

/* Returns the current that the decay acts on, in the rotor frame of k−1. */
static dq_t observer_decaying_current(const nn_observer_t *obs, int32_t feedback_q15)
{
    dq_t i = obs->current;

    if (feedback_q15 != 0) {
        i.d = observer_less_measured(i.d, obs->error.d, feedback_q15);
        i.q = observer_less_measured(i.q, obs->error.q, feedback_q15);
    }
    return i;
}

/*
 * Returns the current that the decay acts on in the middle of the period that has just ended, in
 * the stationary frame. In the rotor frame the current hardly changes within a period, so the
 * current of k−1 is used. In the middle the rotor frame is half a step behind `angle`, the angle at
 * k.
 */
static ab_t observer_middle_current(const nn_observer_t *obs, const nn_observer_cfg_t *cfg,
                                    sincos_t angle)
{
    const int32_t half_q15 = obs->half_step_q15;
    const dq_t i = observer_decaying_current(obs, cfg->feedback_q15);
    const dq_t turned = {
        .d = i.d + fx_asr(half_q15 * i.q, 15U),
        .q = i.q - fx_asr(half_q15 * i.d, 15U),
    };

    return transforms_park_inverse(turned, angle);
}

/* Returns the change of a state component in a period: W3·v less the decay. */
static int32_t observer_flux_step(const nn_observer_cfg_t *cfg, int32_t voltage, int32_t current)
{
    return fx_asr((cfg->volt_gain * voltage) - (cfg->decay * current), cfg->weight_shift);
}

/* Computes (14)–(16). Returns x̂(k), ŷ(k), Q26 of I_x. */
static dq_t observer_predict_state(nn_observer_t *obs, const nn_observer_cfg_t *cfg, ab_t voltage,
                                   sincos_t angle)
{
    const ab_t current = observer_middle_current(obs, cfg, angle);
    const int32_t alpha =
        fx_sat28(obs->alpha_q27 + observer_flux_step(cfg, voltage.alpha, current.alpha));
    const int32_t beta =
        fx_sat28(obs->beta_q27 + observer_flux_step(cfg, voltage.beta, current.beta));

    obs->alpha_q27 = alpha;
    obs->beta_q27 = beta;
    return (dq_t){
        .d = fx_mla_32x16(fx_mul_32x16(alpha, angle.cos), beta, angle.sin),
        .q = fx_mla_32x16(fx_mul_32x16(beta, angle.cos), alpha, -angle.sin),
    };
}

/* Returns e' = (1 − jρ)·(e_d + j·(L_q/L_d)·e_q). */
static dq_t observer_rotate(const nn_observer_cfg_t *cfg, int32_t rho, dq_t e)
{
    const int32_t flux_error_q = fx_asr(e.q * cfg->saliency_q13, 13U);

    return (dq_t){
        .d = fx_sat14(e.d + fx_asr(rho * flux_error_q, 13U)),
        .q = fx_sat14(flux_error_q - fx_asr(rho * e.d, 13U)),
    };
}

/* Sets î, the network's output in Q15 of I_b, and the output error (17). Returns e'. */
static dq_t observer_compare(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t state_q26,
                             dq_t measured)
{
    const uint32_t shift = STATE_BITS - cfg->current_shift;
    const int32_t flux_q26 = fx_asr(cfg->flux_q27, 1U);
    const int32_t rho = obs->rho_q13;
    const dq_t current = {
        .d = fx_asr(state_q26.d - flux_q26, shift),
        .q = fx_asr(fx_mul_32x16(state_q26.q, cfg->iq_gain_q14), shift - 2U),
    };
    const dq_t e = {fx_sat14(measured.d - current.d), fx_sat14(measured.q - current.q)};

    obs->current.d = fx_sat15(current.d);
    obs->current.q = fx_sat15(current.q);
    obs->error = e;
    return obs->rotates ? observer_rotate(cfg, rho, e) : e;
}

void nn_observer_predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                         ab_t voltage, sincos_t angle)
{
    const dq_t state_q26 = observer_predict_state(obs, cfg, voltage, angle);
    const dq_t rotated = observer_compare(obs, cfg, state_q26, measured);
    const dq_t before = obs->state;

    obs->rotated_error = rotated;
    obs->gradient =
        fx_sat16(fx_asr((rotated.q * before.d) - (rotated.d * before.q), cfg->gradient_shift));
    if (cfg->frame_share_q13 == 0) {
        obs->state.d = fx_asr(state_q26.d, STATE_BITS);
        obs->state.q = fx_asr(state_q26.q, STATE_BITS);
    }
}

void nn_observer_train(nn_observer_t *obs, const nn_observer_cfg_t *cfg)
{
    const int32_t gradient = obs->gradient;
    step_t weight_step = fx_asr(gradient * cfg->eta, cfg->eta_shift);

    if (cfg->momentum_q15 != 0) {
        weight_step += fx_mul_32x16(obs->weight_step, cfg->momentum_q15) * 2;
        weight_step = fx_sat30(weight_step);
        obs->weight_step = weight_step;
    }
    obs->speed = fx_clamp(obs->speed - weight_step, -cfg->speed_limit, cfg->speed_limit);
    obs->speed_out = fx_sat30(obs->speed - fx_asr(gradient * cfg->kappa_p, cfg->kappa_p_shift));
}

void nn_observer_follow(nn_observer_t *obs, step_t speed)
{
    obs->speed = speed;
    obs->speed_out = speed;
    obs->weight_step = 0;
}

void nn_observer_accelerate(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t change)
{
    obs->speed = fx_clamp(obs->speed + change, -cfg->speed_limit, cfg->speed_limit);
}

/* Returns ρ = corner / ω̂, limited; 0 at low speed. */
static int32_t observer_rho(const nn_observer_cfg_t *cfg, step_t rotor_speed)
{
    int32_t rho_q13 = 0;

    if (fx_abs(rotor_speed) >= cfg->rho_speed_min) {
        const int32_t corner_q13 = fx_asr(cfg->corner, SPEED_TO_RHO) * 8192;
        const int32_t speed = fx_asr(rotor_speed, SPEED_TO_RHO);
        /*@ assert speed > 0 || speed <= 0; */

        rho_q13 =
            fx_clamp(corner_q13 / ((speed == 0) ? 1 : speed), -cfg->rho_max_q13, cfg->rho_max_q13);
    }
    return rho_q13;
}

void nn_observer_refresh(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t rotor_speed)
{
    obs->rho_q13 = observer_rho(cfg, rotor_speed);
    obs->rotates = (obs->rho_q13 != 0) || (cfg->saliency_q13 != SALIENCY_NONE);
    obs->half_step_q15 = observer_half_step(obs->speed);
    if (cfg->frame_share_q13 != 0) {
        obs->state = observer_gradient_state(cfg, obs->current);
    }
}
