#include "pi.h"

#include "fx.h"

#include <stdbool.h>

#define Q15_TO_Q30 (32768)
#define BASE_SHIFT (15U)

void pi_reset(pi_t *pi, int16_t output)
{
    pi->integral_q30 = (int32_t)output * Q15_TO_Q30;
}

int16_t pi_step(pi_t *pi, const pi_cfg_t *cfg, int32_t error, int32_t feed_forward, int32_t limit)
{
    const int32_t bound_q30 = limit * Q15_TO_Q30;
    /* Both summands are below 2^30 in magnitude. */
    const int32_t integral_q30 = fx_clamp(pi->integral_q30, -bound_q30, bound_q30) +
                                 fx_asr(error * cfg->ki, (uint32_t)cfg->ki_shift - BASE_SHIFT);
    const int32_t sum =
        fx_asr(error * cfg->kp, cfg->kp_shift) + fx_asr(integral_q30, 15U) + feed_forward;
    const int32_t output = fx_clamp(sum, -limit, limit);
    const bool pushes_into_limit =
        ((sum > limit) && (error > 0)) || ((sum < -limit) && (error < 0));

    if (!pushes_into_limit) {
        pi->integral_q30 = fx_clamp(integral_q30, -bound_q30, bound_q30);
    }
    return (int16_t)output;
}

void pi_unwind(pi_t *pi, int32_t excess)
{
    pi->integral_q30 =
        fx_sub_sat(pi->integral_q30, fx_clamp(excess, -FX_Q15_MAX, FX_Q15_MAX) * Q15_TO_Q30);
}
