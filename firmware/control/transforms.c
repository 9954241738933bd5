#include "transforms.h"

#define ONE_OVER_SQRT3_Q15 (18919)
#define ROUND_Q15 (0x4000)

ab_t transforms_clarke(int16_t a, int16_t b)
{
    const int32_t a_plus_2b = (int32_t)a + (2 * (int32_t)b);

    return (ab_t){
        .alpha = a,
        .beta = fx_sat16(fx_asr((a_plus_2b * ONE_OVER_SQRT3_Q15) + ROUND_Q15, 15U)),
    };
}

/* a·x + b·y, Q15. |a·x + b·y| ≤ 2·2^15·32767 < 2^31 − 2^14 since x and y are ±32767 at most. */
static int16_t dot(int32_t a, int32_t x, int32_t b, int32_t y)
{
    return fx_sat16(fx_asr(((a * x) + (b * y)) + ROUND_Q15, 15U));
}

dq_t transforms_park(ab_t v, sincos_t angle)
{
    return (dq_t){
        .d = dot(v.alpha, angle.cos, v.beta, angle.sin),
        .q = dot(v.beta, angle.cos, -(int32_t)v.alpha, angle.sin),
    };
}

ab_t transforms_park_inverse(dq_t v, sincos_t angle)
{
    return (ab_t){
        .alpha = dot(v.d, angle.cos, -(int32_t)v.q, angle.sin),
        .beta = dot(v.d, angle.sin, v.q, angle.cos),
    };
}
