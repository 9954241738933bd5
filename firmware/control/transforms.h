/*
 * Clarke and Park transforms and their inverses, amplitude invariant (factor 2/3).
 *
 * Paper B (39) prints the Park matrix without the factor 2/3 and with +sin in the q row; that is a
 * frame whose q axis points backwards. The standard form is used here everywhere:
 *     i_d =  i_α·cosθ + i_β·sinθ,   i_q = −i_α·sinθ + i_β·cosθ
 *
 * All values are Q15 per unit of one common base, saturated, rounded to nearest. Pure functions.
 */
#ifndef TRANSFORMS_H
#define TRANSFORMS_H

#include "fx.h"
#include "trig.h"

/* A vector in the stationary frame, Q15. */
typedef struct {
    int16_t alpha;
    int16_t beta;
} ab_t;

/* A vector in the rotor frame, Q15, d axis on the rotor flux. */
typedef struct {
    int16_t d;
    int16_t q;
} dq_t;

/*
 * Phase values a, b (the third is −a − b) to the stationary frame: α = a, β = (a + 2b)/√3.
 * Saturation: β only, where |a + 2b| > √3. Error ≤ 1 LSB.
 */
ab_t transforms_clarke(int16_t a, int16_t b);

/* Stationary to rotor frame at the angle whose sine and cosine are given. Error ≤ 2 LSB. */
dq_t transforms_park(ab_t v, sincos_t angle);

/* Rotor to stationary frame. Error ≤ 2 LSB. */
ab_t transforms_park_inverse(dq_t v, sincos_t angle);

#endif
