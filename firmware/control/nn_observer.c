#include "nn_observer.h"

#define STATE_LIMIT_Q27 ((1 << 27) - 1)
#define STATE_TO_Q15 (12U)
#define ERROR_LIMIT (16383)      /* ±½: keeps b(k) below 2^30 */
#define RADIANS_PER_STEP (25736) /* 2π·2^28/2^32·2^16: W2 in Q28 from step_t */

void nn_observer_reset(nn_observer_t *obs, const nn_observer_cfg_t *cfg)
{
    *obs = (nn_observer_t){.x_q27 = cfg->flux_q27};
}

static int32_t limit_state(int32_t state_q27)
{
    return fx_clamp(state_q27, -STATE_LIMIT_Q27, STATE_LIMIT_Q27);
}

/* (14)–(16): the network's forward pass. x, y: the states of k−1 in Q15 of I_x. */
static void predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y, dq_t v)
{
    const int32_t w2_q28 = -fx_mul_32x16(obs->speed_out, RADIANS_PER_STEP);

    obs->x_q27 =
        limit_state(obs->x_q27 - fx_mul_32x16(cfg->decay_d_q28, x) - fx_mul_32x16(w2_q28, y) +
                    fx_mul_32x16(cfg->volt_gain_q28, v.d) + cfg->flux_drive_q27);
    obs->y_q27 = limit_state(obs->y_q27 - fx_mul_32x16(cfg->decay_q_q28, y) +
                             fx_mul_32x16(w2_q28, x) + fx_mul_32x16(cfg->volt_gain_q28, v.q));
}

/* The network's output in the base of the measurement, and the output error (17). */
static void compare(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured)
{
    const uint32_t shift = STATE_TO_Q15 - cfg->current_shift;

    obs->current.d = fx_sat16(fx_asr(obs->x_q27 - cfg->flux_q27, shift));
    obs->current.q = fx_sat16(fx_asr(fx_mul_32x16(obs->y_q27, cfg->iq_gain_q14), shift - 2U));
    obs->error.d =
        (int16_t)fx_clamp((int32_t)measured.d - obs->current.d, -ERROR_LIMIT, ERROR_LIMIT);
    obs->error.q =
        (int16_t)fx_clamp((int32_t)measured.q - obs->current.q, -ERROR_LIMIT, ERROR_LIMIT);
}

/* (19)–(22): train W2 along the descent direction. x, y as in predict(). */
static void train(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y)
{
    const int32_t descent = (obs->error.q * x) - (obs->error.d * y);
    const step_t momentum = fx_mul_32x16(obs->weight_step, cfg->momentum_q15) * 2;
    const step_t weight_step = fx_asr(fx_mul_32x16(descent, cfg->rate), cfg->rate_shift) + momentum;

    obs->weight_step = fx_clamp(weight_step, -cfg->speed_limit, cfg->speed_limit);
    obs->speed = fx_clamp(obs->speed - obs->weight_step, -cfg->speed_limit, cfg->speed_limit);
    obs->speed_out =
        obs->speed - fx_asr(fx_mul_32x16(descent, cfg->proportional), cfg->proportional_shift);
}

void nn_observer_step(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured, dq_t voltage)
{
    const int32_t x = fx_asr(obs->x_q27, STATE_TO_Q15);
    const int32_t y = fx_asr(obs->y_q27, STATE_TO_Q15);

    predict(obs, cfg, x, y, voltage);
    compare(obs, cfg, measured);
    train(obs, cfg, x, y);
}
