/* SPDX-License-Identifier: MIT */
#include "transforms.h"

#define ONE_OVER_SQRT3_Q15 (18919)
#define ROUND_Q15 (0x4000)

ab_t transforms_clarke(int32_t a, int32_t b)
{
    return (ab_t){
        .alpha = a,
        .beta = fx_asr(((a + (2 * b)) * ONE_OVER_SQRT3_Q15) + ROUND_Q15, 15U),
    };
}

/*
 * Returns a·x + b·y in Q15; |a| + |b| ≤ 65534 and |x|, |y| ≤ 32767 keep the sum below 2^31 − 2^14.
 */
static int32_t dot(int32_t a, int32_t x, int32_t b, int32_t y)
{
    return fx_asr(((a * x) + ROUND_Q15) + (b * y), 15U);
}

dq_t transforms_park(ab_t v, sincos_t angle)
{
    return (dq_t){
        .d = dot(v.alpha, angle.cos, v.beta, angle.sin),
        .q = dot(v.beta, angle.cos, -v.alpha, angle.sin),
    };
}

ab_t transforms_park_inverse(dq_t v, sincos_t angle)
{
    return (ab_t){
        .alpha = dot(v.d, angle.cos, -v.q, angle.sin),
        .beta = dot(v.d, angle.sin, v.q, angle.cos),
    };
}
