/* SPDX-License-Identifier: MIT */
#include "torque_filter.h"

#define Q15_TO_Q26 (2048)
#define STATE_BITS (11U) /* fractional bits of the states beyond those of a current */
#define HALF_LSB (1024)

void torque_filter_start(torque_filter_t *filter, int32_t current)
{
    filter->origin = current;
    filter->smooth_q26 = current * Q15_TO_Q26;
    filter->swing_q26 = (dq_t){0, 0};
}

static int32_t low_pass(torque_filter_t *filter, const torque_filter_cfg_t *cfg,
                        int32_t current_q26)
{
    const int32_t missing = current_q26 - filter->smooth_q26;

    filter->smooth_q26 =
        fx_sat27(filter->smooth_q26 + (2 * fx_mul_32x16(missing, cfg->smooth_rate_q15)));
    return filter->smooth_q26;
}

/* Returns v turned by the angle of `turn`. v: Q26, |d|, |q| ≤ 2^29. */
static dq_t turned(dq_t v, sincos_t turn)
{
    return (dq_t){
        .d = fx_sat28(2 * fx_mla_32x16(fx_mul_32x16(v.d, turn.cos), v.q, -turn.sin)),
        .q = fx_sat28(2 * fx_mla_32x16(fx_mul_32x16(v.d, turn.sin), v.q, turn.cos)),
    };
}

static int32_t notch(torque_filter_t *filter, const torque_filter_cfg_t *cfg, int32_t current_q26)
{
    const dq_t swing = filter->swing_q26;
    const int32_t rest = current_q26 - swing.d;
    const int32_t half_share = fx_mul_32x16(rest, cfg->notch_share_q15); /* μ/2·e */

    filter->swing_q26 =
        turned((dq_t){.d = swing.d + (2 * half_share), .q = swing.q}, cfg->notch_turn);
    return rest - half_share;
}

int32_t torque_filter_step(torque_filter_t *filter, const torque_filter_cfg_t *cfg, int32_t current)
{
    const int32_t origin_q26 = filter->origin * Q15_TO_Q26;
    int32_t filtered_q26 = current * Q15_TO_Q26;

    if (cfg->smooth_rate_q15 != 0) {
        filtered_q26 = low_pass(filter, cfg, filtered_q26);
    }
    if (cfg->notch_share_q15 != 0) {
        filtered_q26 = origin_q26 + notch(filter, cfg, filtered_q26 - origin_q26);
    }
    return fx_asr(filtered_q26 + HALF_LSB, STATE_BITS);
}
