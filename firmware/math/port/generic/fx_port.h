/* SPDX-License-Identifier: MIT */
/*
 * Arithmetic for which some cores have an instruction. This is the form in plain C, for all other
 * cores.
 *
 * The build chooses one folder of port/ for the core. All folders give the same results, bit for
 * bit. The saturating functions take any int32_t. Pure, any context.
 */
#ifndef FX_PORT_H
#define FX_PORT_H

#include "fx_shift.h"

#include <stdint.h>

/*
 * Returns x saturated to a signed number of `bits` bits. x fits when extending the sign of its
 * lower bits gives x again.
 */
static inline int32_t fx_sat(int32_t x, uint32_t bits)
{
    const uint32_t ones = ((uint32_t)1U << (bits - 1U)) - 1U;
    const int32_t largest = (int32_t)ones;
    const uint32_t high = (uint32_t)x << (32U - bits);
    int32_t y = x;

    if (fx_asr((int32_t)high, 32U - bits) != x) {
        y = (x < 0) ? (-largest - 1) : largest;
    }
    return y;
}

static inline int32_t fx_sat14(int32_t x)
{
    return fx_sat(x, 14U);
}

static inline int32_t fx_sat15(int32_t x)
{
    return fx_sat(x, 15U);
}

static inline int32_t fx_sat16(int32_t x)
{
    return fx_sat(x, 16U);
}

static inline int32_t fx_sat27(int32_t x)
{
    return fx_sat(x, 27U);
}

static inline int32_t fx_sat28(int32_t x)
{
    return fx_sat(x, 28U);
}

static inline int32_t fx_sat30(int32_t x)
{
    return fx_sat(x, 30U);
}

/* Returns x saturated to 0…32767. */
static inline int32_t fx_usat15(int32_t x)
{
    int32_t y = x;

    if (fx_asr(x, 15U) != 0) {
        y = (x < 0) ? 0 : 0x7FFF;
    }
    return y;
}

/*
 * Returns sum + floor(a·b / 2^16), exact for every a and for −32768 ≤ b ≤ 32767. The caller makes
 * sure that the sum fits 32 bits. With a = a_hi·2^16 + a_lo the second term is a_hi·b +
 * floor(a_lo·b / 2^16), |a_lo·b| < 2^31.
 */
static inline int32_t fx_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    const int32_t a_hi = fx_asr(a, 16U);
    const uint32_t a_lo = (uint32_t)a & 0xFFFFU;

    return sum + ((a_hi * b) + fx_asr((int32_t)a_lo * b, 16U));
}

/* Returns the number of zero bits above the highest set bit of x, x > 0. */
static inline uint32_t fx_leading_zeros(uint32_t x)
{
    uint32_t rest = x;
    uint32_t zeros = 0U;

    for (uint32_t width = 16U; width != 0U; width >>= 1U) {
        if ((rest >> (32U - width)) == 0U) {
            rest <<= width;
            zeros += width;
        }
    }
    return zeros;
}

#endif
