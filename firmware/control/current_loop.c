/* SPDX-License-Identifier: MIT */
#include "current_loop.h"

void current_loop_reset(current_loop_t *loop)
{
    pi_reset(&loop->pi_d, 0);
    pi_reset(&loop->pi_q, 0);
}

void current_loop_turn(current_loop_t *loop, sincos_t angle)
{
    const ab_t integral = {pi_output(&loop->pi_d), pi_output(&loop->pi_q)};
    const dq_t turned = transforms_park(integral, angle);

    pi_reset(&loop->pi_d, fx_sat16(turned.d));
    pi_reset(&loop->pi_q, fx_sat16(turned.q));
}

/* v_q limited to what v_d leaves of the circle. */
static int32_t limit_q(pi_t *pi_q, dq_t v, int32_t limit)
{
    const int32_t room = (limit * limit) - (v.d * v.d);
    int32_t v_q = v.q;

    if ((v_q * v_q) > room) {
        const int32_t bound = (int32_t)trig_sqrt((uint32_t)fx_max(room, 0));

        v_q = fx_clamp(v_q, -bound, bound);
        pi_unwind(pi_q, v.q - v_q);
    }
    return v_q;
}

dq_t current_loop_step(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       dq_t measured, int32_t speed_q15, int32_t limit)
{
    const int32_t cross_d = current_loop_cross(speed_q15, cfg->reactance_q_q13, measured.q);
    const int32_t cross_q = current_loop_cross(speed_q15, cfg->reactance_d_q13, measured.d);
    const int32_t emf = fx_asr(speed_q15 * cfg->emf_q13, CURRENT_LOOP_GAIN_BITS);
    const int32_t drop_d = fx_asr(reference.d * cfg->resistance_q13, CURRENT_LOOP_GAIN_BITS);
    const int32_t drop_q = fx_asr(reference.q * cfg->resistance_q13, CURRENT_LOOP_GAIN_BITS);
    const dq_t wanted = {
        .d = pi_step(&loop->pi_d, &cfg->pi_d, reference.d - measured.d, drop_d - cross_d, limit),
        .q = pi_step(&loop->pi_q, &cfg->pi_q, reference.q - measured.q, drop_q + cross_q + emf,
                     limit),
    };

    return (dq_t){.d = wanted.d, .q = limit_q(&loop->pi_q, wanted, limit)};
}
