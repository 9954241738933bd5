/* SPDX-License-Identifier: MIT */
#include "pi.h"

#include "fx.h"

#define Q15_TO_Q26 (2048)

void pi_reset(pi_t *pi, int32_t output)
{
    pi->integral_q26 = output * Q15_TO_Q26;
}

int32_t pi_output(const pi_t *pi)
{
    return fx_asr(pi->integral_q26, PI_INTEGRAL_BITS);
}

int32_t pi_limit(pi_t *pi, int32_t integral_q26, int32_t u, int32_t limit)
{
    int32_t output = u;

    if (output > limit) {
        output = limit;
        pi->integral_q26 = fx_min(integral_q26, pi->integral_q26);
    } else if (output < -limit) {
        output = -limit;
        pi->integral_q26 = fx_max(integral_q26, pi->integral_q26);
    } else {
        pi->integral_q26 = integral_q26;
    }
    return output;
}

int32_t pi_step(pi_t *pi, const pi_cfg_t *cfg, int32_t error, int32_t feed_forward, int32_t limit)
{
    const int32_t integral_q26 = pi_integral(pi, cfg, error);

    return pi_limit(pi, integral_q26, pi_sum(cfg, error, integral_q26) + feed_forward, limit);
}

void pi_unwind(pi_t *pi, int32_t excess)
{
    pi->integral_q26 = fx_sat27(pi->integral_q26 - (excess * Q15_TO_Q26));
}
