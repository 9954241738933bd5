/* SPDX-License-Identifier: MIT */
/*
 * The functions of port/generic as their contracts say them, for the proof: what the shifts of
 * port/generic mean is beyond intervals. test_proof_port.c compares both, around every limit and in
 * steps over all words. Where port/generic or a core holds only for some arguments, that is asked
 * here of each call.
 */
#ifndef FX_PORT_H
#define FX_PORT_H

#include "fx_shift.h"

#include <stdint.h>

static inline int32_t fx_sat(int32_t x, int32_t largest)
{
    int32_t y;

    if (x > largest) {
        y = largest;
    } else if (x < (-largest - 1)) {
        y = -largest - 1;
    } else {
        y = x;
    }
    return y;
}

static inline int32_t fx_sat14(int32_t x)
{
    return fx_sat(x, 0x1FFF);
}

static inline int32_t fx_sat15(int32_t x)
{
    return fx_sat(x, 0x3FFF);
}

static inline int32_t fx_sat16(int32_t x)
{
    return fx_sat(x, 0x7FFF);
}

static inline int32_t fx_sat27(int32_t x)
{
    return fx_sat(x, 0x3FFFFFF);
}

static inline int32_t fx_sat28(int32_t x)
{
    return fx_sat(x, 0x7FFFFFF);
}

static inline int32_t fx_sat30(int32_t x)
{
    return fx_sat(x, 0x1FFFFFFF);
}

static inline int32_t fx_usat15(int32_t x)
{
    int32_t y;

    if (x > 0x7FFF) {
        y = 0x7FFF;
    } else if (x < 0) {
        y = 0;
    } else {
        y = x;
    }
    return y;
}

/*@ requires -32768 <= b <= 32767; */
static inline int32_t fx_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    return sum + (int32_t)(((int64_t)a * b) >> 16U);
}

/*@ requires x > 0; */
static inline uint32_t fx_leading_zeros(uint32_t x)
{
    uint32_t zeros = 0U;
    uint32_t highest = 0x80000000U;

    while (x < highest) {
        highest >>= 1U;
        zeros++;
    }
    return zeros;
}

#endif
