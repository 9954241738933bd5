/* SPDX-License-Identifier: MIT */
#include "virtual_resistance.h"

#define ONE_Q15 (32768)
#define MEAN_BITS (15U) /* bits by which the mean is finer than a current */

void virtual_resistance_start(virtual_resistance_t *res, dq_t current)
{
    res->mean_q30 = (dq_t){current.d * ONE_Q15, current.q * ONE_Q15};
}

dq_t virtual_resistance_mean(const virtual_resistance_t *res)
{
    return (dq_t){
        .d = fx_asr(res->mean_q30.d, MEAN_BITS),
        .q = fx_asr(res->mean_q30.q, MEAN_BITS),
    };
}

dq_t virtual_resistance_step(virtual_resistance_t *res, const virtual_resistance_cfg_t *cfg,
                             dq_t current)
{
    const dq_t mean = virtual_resistance_mean(res);
    const dq_t missing = {mean.d - current.d, mean.q - current.q};

    res->mean_q30.d = fx_sat30(res->mean_q30.d - (missing.d * cfg->mean_rate_q15));
    res->mean_q30.q = fx_sat30(res->mean_q30.q - (missing.q * cfg->mean_rate_q15));
    return (dq_t){missing.d * cfg->resistance_q15, missing.q * cfg->resistance_q15};
}
