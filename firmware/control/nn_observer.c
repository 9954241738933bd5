#include "nn_observer.h"

#define STATE_TO_Q15 (12U)
#define RADIANS_PER_STEP (25736) /* 2π·2^28/2^32·2^16: W2 in Q28 from step_t */
#define TWO_THIRDS_Q16 (43691)
#define SPEED_TO_RHO (10U) /* speeds are divided by 2^10 before the division for ρ */

/* −W2 as a rotation: half the angle, its versed sine for the voltage, sine and versed sine of the angle. */
typedef struct {
    int32_t half_q16;
    int32_t half_versine_q16;
    int32_t sine_q28;
    int32_t versine_q28;
} rotation_t;

void nn_observer_reset(nn_observer_t *obs, const nn_observer_cfg_t *cfg)
{
    *obs = (nn_observer_t){.x_q27 = cfg->flux_q27};
}

void nn_observer_start(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t speed, dq_t current)
{
    const uint32_t shift = STATE_TO_Q15 - cfg->current_shift;
    const uint32_t steps = (uint32_t)1U << shift;
    const int32_t unit = (int32_t)steps;
    const step_t limited = fx_clamp(speed, -cfg->speed_limit, cfg->speed_limit);

    nn_observer_reset(obs, cfg);
    obs->x_q27 = fx_sat28(cfg->flux_q27 + (current.d * unit));
    obs->y_q27 = fx_sat28(current.q * unit); /* salient: off by L_q/L_d for a few τ */
    obs->speed = limited;
    obs->speed_out = limited;
}

/* sin Δ = Δ·(1 − Δ²/6), 1 − cos Δ = Δ²/2·(1 − Δ²/12), with h = Δ/2. |Δ| ≤ 0.8 rad. */
static rotation_t rotation(step_t speed)
{
    const int32_t angle_q28 = fx_mul_32x16(speed, RADIANS_PER_STEP);
    const int32_t half_q16 = fx_asr(angle_q28, 13U);
    const int32_t square_q16 = fx_asr(half_q16 * half_q16, 16U);
    const int32_t sixth_q16 = fx_asr(square_q16 * TWO_THIRDS_Q16, 16U);
    const int32_t versine_q28 = fx_mul_32x16(angle_q28, half_q16);

    return (rotation_t){
        .half_q16 = half_q16,
        .half_versine_q16 = fx_asr(square_q16, 1U),
        .sine_q28 = fx_mla_32x16(angle_q28, -angle_q28, sixth_q16),
        .versine_q28 = fx_mla_32x16(versine_q28, -versine_q28, fx_asr(sixth_q16, 1U)),
    };
}

/*
 * (14)–(16): the network's forward pass. x, y: the states of k−1 in Q15 of I_x. In the frame that turns with it the
 * current hardly changes in a period: that of k−1 is taken for that of the middle.
 */
static void predict(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y, dq_t v)
{
    const rotation_t r = rotation(obs->speed_out);
    const int32_t flux = fx_asr(cfg->flux_q27, STATE_TO_Q15);
    const int32_t own_x =
        fx_asr((cfg->volt_gain * v.d) - (cfg->decay_d * fx_sat16(x - flux)), cfg->weight_shift);
    const int32_t own_y = fx_asr((cfg->volt_gain * v.q) - (cfg->decay_q * y), cfg->weight_shift);
    int32_t next_x = obs->x_q27 + own_x;
    int32_t next_y = obs->y_q27 + own_y;

    next_x = fx_mla_32x16(next_x, own_y, r.half_q16);
    next_y = fx_mla_32x16(next_y, -own_x, r.half_q16);
    next_x = fx_mla_32x16(next_x, -own_x, r.half_versine_q16);
    next_y = fx_mla_32x16(next_y, -own_y, r.half_versine_q16);
    next_x = fx_mla_32x16(next_x, r.sine_q28, y);
    next_y = fx_mla_32x16(next_y, -r.sine_q28, x);
    next_x = fx_mla_32x16(next_x, -r.versine_q28, x);
    next_y = fx_mla_32x16(next_y, -r.versine_q28, y);
    obs->x_q27 = fx_sat28(next_x);
    obs->y_q27 = fx_sat28(next_y);
}

/* The network's output in the base of the measurement, the output error (17), and that error turned. */
static void compare(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured)
{
    const uint32_t shift = STATE_TO_Q15 - cfg->current_shift;
    const int32_t rho = obs->rho_q13;
    int32_t flux_error_q;
    dq_t e;

    obs->current.d = fx_asr(obs->x_q27 - cfg->flux_q27, shift);
    obs->current.q = fx_asr(fx_mul_32x16(obs->y_q27, cfg->iq_gain_q14), shift - 2U);
    e.d = fx_sat14(measured.d - obs->current.d);
    e.q = fx_sat14(measured.q - obs->current.q);
    obs->error = e;
    flux_error_q = fx_asr(e.q * cfg->saliency_q13, 13U);
    obs->turned.d = fx_sat14(e.d + fx_asr(rho * fx_sat16(flux_error_q), 13U));
    obs->turned.q = fx_sat14(flux_error_q - fx_asr(rho * e.d, 13U));
}

/* (19)–(22): train W2 along the descent direction. x, y as in predict(). */
static void train(nn_observer_t *obs, const nn_observer_cfg_t *cfg, int32_t x, int32_t y)
{
    const int32_t descent = fx_sat16(fx_asr((obs->turned.q * x) - (obs->turned.d * y), 12U));
    step_t weight_step = fx_asr(descent * cfg->rate, cfg->rate_shift);

    if (cfg->momentum_q15 != 0) {
        weight_step += fx_mul_32x16(obs->weight_step, cfg->momentum_q15) * 2;
        weight_step = fx_sat30(weight_step);
        obs->weight_step = weight_step;
    }
    obs->speed = fx_clamp(obs->speed - weight_step, -cfg->speed_limit, cfg->speed_limit);
    obs->speed_out =
        fx_sat30(obs->speed - fx_asr(descent * cfg->proportional, cfg->proportional_shift));
}

void nn_observer_step(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured, dq_t voltage)
{
    const int32_t x = fx_asr(obs->x_q27, STATE_TO_Q15);
    const int32_t y = fx_asr(obs->y_q27, STATE_TO_Q15);

    predict(obs, cfg, x, y, voltage);
    compare(obs, cfg, measured);
    train(obs, cfg, x, y);
}

void nn_observer_follow(nn_observer_t *obs, const nn_observer_cfg_t *cfg, dq_t measured,
                        dq_t voltage, step_t speed)
{
    const int32_t x = fx_asr(obs->x_q27, STATE_TO_Q15);
    const int32_t y = fx_asr(obs->y_q27, STATE_TO_Q15);

    predict(obs, cfg, x, y, voltage);
    compare(obs, cfg, measured);
    obs->speed = speed;
    obs->speed_out = speed;
    obs->weight_step = 0;
}

void nn_observer_update_rho(nn_observer_t *obs, const nn_observer_cfg_t *cfg, step_t rotor_speed)
{
    int32_t rho_q13 = 0;

    if (fx_abs(rotor_speed) >= cfg->rho_speed_min) {
        const int32_t corner_q13 = fx_asr(cfg->corner, SPEED_TO_RHO) * 8192;
        const int32_t speed = fx_asr(rotor_speed, SPEED_TO_RHO);

        rho_q13 =
            fx_clamp(corner_q13 / ((speed == 0) ? 1 : speed), -cfg->rho_max_q13, cfg->rho_max_q13);
    }
    obs->rho_q13 = rho_q13;
}
