#include "nn_observer.h"

#define STATE_TO_Q15 (12U)
#define RADIANS_PER_STEP (25736) /* 2π·2^28/2^32·2^16: W2 in Q28 from step_t */

void nn_observer_reset(nn_observer_t *obs, const nn_observer_cfg_t *cfg)
{
    *obs = (nn_observer_t){.x_q27 = cfg->flux_q27};
}

/* (14)–(16): the network's forward pass. x, y: the states of k−1 in Q15 of I_x. */
static void predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y, dq_t v)
{
    const int32_t minus_w2_q28 = fx_mul_32x16(obs->speed_out, RADIANS_PER_STEP);
    const int32_t own_x = fx_asr((cfg->volt_gain * v.d) - (cfg->decay_d * x), cfg->weight_shift);
    const int32_t own_y = fx_asr((cfg->volt_gain * v.q) - (cfg->decay_q * y), cfg->weight_shift);

    obs->x_q27 = fx_sat28(fx_mla_32x16(obs->x_q27 + own_x + cfg->flux_drive_q27, minus_w2_q28, y));
    obs->y_q27 = fx_sat28(fx_mla_32x16(obs->y_q27 + own_y, -minus_w2_q28, x));
}

/* The network's output in the base of the measurement, and the output error (17). */
static void compare(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured)
{
    const uint32_t shift = STATE_TO_Q15 - cfg->current_shift;

    obs->current.d = fx_asr(obs->x_q27 - cfg->flux_q27, shift);
    obs->current.q = fx_asr(fx_mul_32x16(obs->y_q27, cfg->iq_gain_q14), shift - 2U);
    obs->error.d = fx_sat14(measured.d - obs->current.d);
    obs->error.q = fx_sat14(measured.q - obs->current.q);
}

/* (19)–(22): train W2 along the descent direction. x, y as in predict(). */
static void train(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y)
{
    const int32_t descent = fx_asr((obs->error.q * x) - (obs->error.d * y), 14U);
    step_t weight_step = fx_asr(descent * cfg->rate, cfg->rate_shift);

    if (cfg->momentum_q15 != 0) {
        weight_step += fx_mul_32x16(obs->weight_step, cfg->momentum_q15) * 2;
        weight_step = fx_sat30(weight_step);
        obs->weight_step = weight_step;
    }
    obs->speed = fx_clamp(obs->speed - weight_step, -cfg->speed_limit, cfg->speed_limit);
    obs->speed_out = obs->speed - fx_asr(descent * cfg->proportional, cfg->proportional_shift);
}

void nn_observer_step(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured, dq_t voltage)
{
    const int32_t x = fx_asr(obs->x_q27, STATE_TO_Q15);
    const int32_t y = fx_asr(obs->y_q27, STATE_TO_Q15);

    predict(obs, cfg, x, y, voltage);
    compare(obs, cfg, measured);
    train(obs, cfg, x, y);
}
