/* SPDX-License-Identifier: MIT */
/*
 * Functions of which the proof needs another, equal formulation: tests/proof/port. The rest of the firmware is proven as
 * it stands.
 *
 * Words of which the sign bit is read anew, as angles and counters that wrap are. To a reader as to a checker, a
 * conversion that changes the value looks like one that should not. These change it; all others in the firmware keep
 * it. Every supported compiler converts to a signed type modulo 2^n. Any x, no instruction. Pure, any context.
 */
#ifndef FX_PLAIN_H
#define FX_PLAIN_H

#include "fx_shift.h"

#include <stdint.h>

/* The number that has the bits of x: x − 2^32 for x ≥ 2^31. */
static inline int32_t fx_signed(uint32_t x)
{
    return (int32_t)x;
}

/* The bits of x as a number: x + 2^32 for x < 0. */
static inline uint32_t fx_unsigned(int32_t x)
{
    return (uint32_t)x;
}

/* The same with 64 bits. */
static inline int64_t fx_signed64(uint64_t x)
{
    return (int64_t)x;
}

static inline uint64_t fx_unsigned64(int64_t x)
{
    return (uint64_t)x;
}

/* From `from` towards `to` by 2^-shift of the distance, rounded down: a low-pass. The distance must fit into 32 bits. */
static inline int32_t fx_approach(int32_t from, int32_t to, uint32_t shift)
{
    return from + fx_asr(to - from, shift);
}

#endif
