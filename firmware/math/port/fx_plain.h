/* SPDX-License-Identifier: MIT */
/*
 * Conversions between signed and unsigned words, and the low-pass. The proof reads an equal form of
 * these functions (tests/proof/port) and the rest of the firmware as it is.
 *
 * Angles and counters that wrap use these conversions: the bits stay, the value may change. No
 * other conversion in the firmware changes a value, so a reader or a checker can tell the two
 * apart. Every supported compiler converts to a signed type modulo 2^n. Range: any x. No
 * instruction. Pure, any context.
 */
#ifndef FX_PLAIN_H
#define FX_PLAIN_H

#include "fx_shift.h"

#include <stdint.h>

/* Returns the number that has the bits of x: x − 2^32 for x ≥ 2^31. */
static inline int32_t fx_signed(uint32_t x)
{
    return (int32_t)x;
}

/* Returns the bits of x as a number: x + 2^32 for x < 0. */
static inline uint32_t fx_unsigned(int32_t x)
{
    return (uint32_t)x;
}

/* The same conversions with 64 bits. */
static inline int64_t fx_signed64(uint64_t x)
{
    return (int64_t)x;
}

static inline uint64_t fx_unsigned64(int64_t x)
{
    return (uint64_t)x;
}

/*
 * Returns `from` moved towards `to` by 2^-shift of the distance, rounded down. Called in each
 * sample, it is a low-pass. The distance must fit into 32 bits.
 */
static inline int32_t fx_approach(int32_t from, int32_t to, uint32_t shift)
{
    return from + fx_asr(to - from, shift);
}

#endif
