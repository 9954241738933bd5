/* SPDX-License-Identifier: MIT */
/*
 * Clarke and Park transforms and their inverses, amplitude invariant (factor 2/3).
 *
 * Paper B (39) prints the Park matrix without the factor 2/3 and with +sin in the q row: the q axis
 * of that frame points backwards. The firmware uses the standard form everywhere:
 *     i_d =  i_α·cosθ + i_β·sinθ,   i_q = −i_α·sinθ + i_β·cosθ
 *
 * Values are Q15 per unit of one common base, in 32 bits, rounded to nearest. They do not saturate:
 * with components within the stated range nothing overflows. Pure functions, any context.
 */
#ifndef TRANSFORMS_H
#define TRANSFORMS_H

#include "fx.h"
#include "trig.h"

#include <stdint.h>

/* A vector in the stationary frame, Q15. */
typedef struct {
    int32_t alpha;
    int32_t beta;
} ab_t;

/* A vector in the rotor frame, Q15, d axis on the rotor flux. */
typedef struct {
    int32_t d;
    int32_t q;
} dq_t;

/*
 * Converts phase values a, b (the third is −a − b) to the stationary frame: α = a, β = (a + 2b)/√3.
 * Range: |a|, |b| ≤ 32767; |β| then stays below 56755. Error ≤ 1 LSB.
 */
ab_t transforms_clarke(int32_t a, int32_t b);

/*
 * Converts from the stationary to the rotor frame at the angle given by its sine and cosine. |α| +
 * |β| ≤ 65534. Error ≤ 2 LSB.
 */
dq_t transforms_park(ab_t v, sincos_t angle);

/* Converts from the rotor to the stationary frame. |d|, |q| ≤ 32768. Error ≤ 2 LSB. */
ab_t transforms_park_inverse(dq_t v, sincos_t angle);

/* Returns the square of a vector's length, Q30. |d|, |q| ≤ 32768. Exact. Pure, any context. */
static inline uint32_t transforms_square(dq_t v)
{
    const int32_t square_d = v.d * v.d;
    const int32_t square_q = v.q * v.q;

    return (uint32_t)square_d + (uint32_t)square_q;
}

#endif
