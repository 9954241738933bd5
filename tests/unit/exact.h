/* SPDX-License-Identifier: MIT */
/*
 * Wide arithmetic that expected values are made of, written in another way than what it is compared
 * with.
 */
#ifndef EXACT_H
#define EXACT_H

#include <stdint.h>

/* floor(x / 2^n) without shifting a negative number. */
static inline int64_t floor_div_pow2(int64_t x, uint32_t n)
{
    const int64_t divisor = (int64_t)1 << n;
    const int64_t quotient = x / divisor;

    return ((x % divisor) < 0) ? (quotient - 1) : quotient;
}

static inline int64_t clamp64(int64_t x, int64_t lo, int64_t hi)
{
    int64_t result = x;

    if (x > hi) {
        result = hi;
    } else if (x < lo) {
        result = lo;
    }
    return result;
}

#endif
