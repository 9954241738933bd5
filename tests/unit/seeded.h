/* SPDX-License-Identifier: MIT */
/*
 * Seeded pseudo-random numbers (xorshift, 32 bits, period 2^32 − 1): the same sequence everywhere.
 */
#ifndef SEEDED_H
#define SEEDED_H

#include <stdint.h>

typedef struct {
    uint32_t state; /* not 0 */
} seeded_t;

static inline uint32_t seeded_u32(seeded_t *s)
{
    s->state ^= s->state << 13U;
    s->state ^= s->state >> 17U;
    s->state ^= s->state << 5U;
    return s->state;
}

/* Any 32-bit pattern as a signed number. */
static inline int32_t seeded_i32(seeded_t *s)
{
    const uint32_t bits = seeded_u32(s);

    return (bits <= (uint32_t)INT32_MAX) ? (int32_t)bits : (-1 - (int32_t)(UINT32_MAX - bits));
}

/* lo…hi, both included. */
static inline int32_t seeded_in(seeded_t *s, int32_t lo, int32_t hi)
{
    const uint64_t span = (uint64_t)((int64_t)hi - lo) + 1U;

    return (int32_t)(lo + (int64_t)((seeded_u32(s) * span) >> 32U));
}

static inline int16_t seeded_i16(seeded_t *s)
{
    return (int16_t)seeded_in(s, INT16_MIN, INT16_MAX);
}

#endif
