/* SPDX-License-Identifier: MIT */
/*
 * Fixed-point arithmetic: saturation, shifts and mixed-width products.
 *
 * Formats. Qn means an integer that stands for value = integer / 2^n. Signals are Q15 in 16 bits
 * (±1 per unit). Controller and observer states are 32 bits wide with guard bits above ±1, so that
 * a sum of a few products needs one clamp at its end and not one at each term.
 *
 * Cost. A 32×32→64 product is one instruction on Cortex-M3 and later but a library call on M0+. The
 * widest product here is 32×16 with the lower 16 bits dropped. It takes at most two 32-bit
 * multiplications on any core.
 *
 * All functions are pure, total over the stated ranges and callable from any context.
 */
#ifndef FX_H
#define FX_H

#include "fx_plain.h"
#include "fx_port.h"
#include "fx_shift.h"

#include <stdint.h>

/* Angle. One turn, not one radian, is the unit: 2^32 is one turn, so angles wrap by themselves. */
typedef uint32_t angle_t;

/* Change of an angle in a control tick, signed, in the unit of angle_t. 2^32 is one turn a tick. */
typedef int32_t step_t;

#define FX_Q15_MAX (32767)
#define FX_Q15_MIN (-32768)

/* fx_min() returns the smaller, fx_max() the larger of two values. */
static inline int32_t fx_min(int32_t a, int32_t b)
{
    return (a < b) ? a : b;
}

static inline int32_t fx_max(int32_t a, int32_t b)
{
    return (a > b) ? a : b;
}

/* Returns x limited to lo…hi, lo ≤ hi. */
static inline int32_t fx_clamp(int32_t x, int32_t lo, int32_t hi)
{
    return fx_min(fx_max(x, lo), hi);
}

/*
 * Returns `from` moved towards `to` by at most `step` ≥ 0. `from` ± `step` must fit into 32 bits.
 */
static inline int32_t fx_towards(int32_t from, int32_t to, int32_t step)
{
    return (to > from) ? fx_min(from + step, to) : fx_max(from - step, to);
}

/* Returns |x|. x must not be INT32_MIN. */
static inline int32_t fx_abs(int32_t x)
{
    return (x < 0) ? -x : x;
}

/* Returns floor(a·b / 2^16), exact for every a and for −32768 ≤ b ≤ 32767. */
static inline int32_t fx_mul_32x16(int32_t a, int32_t b)
{
    return fx_mla_32x16(0, a, b);
}

#endif
