/* SPDX-License-Identifier: MIT */
/*
 * The functions of firmware/math/port/fx_plain.h for the proof: conversions that keep the value, so
 * that it can ask that of all of them, and a low-pass that says what intervals do not know, that it
 * stays between its arguments. test_proof_port.c compares both.
 */
#ifndef FX_PLAIN_H
#define FX_PLAIN_H

#include "fx_shift.h"

#include <stdint.h>

static inline int32_t fx_signed(uint32_t x)
{
    return (x > (uint32_t)INT32_MAX) ? (-1 - (int32_t)(~x)) : (int32_t)x;
}

static inline uint32_t fx_unsigned(int32_t x)
{
    return (x < 0) ? ~(uint32_t)(-1 - x) : (uint32_t)x;
}

static inline int64_t fx_signed64(uint64_t x)
{
    return (x > (uint64_t)INT64_MAX) ? (-1 - (int64_t)(~x)) : (int64_t)x;
}

static inline uint64_t fx_unsigned64(int64_t x)
{
    return (x < 0) ? ~(uint64_t)(-1 - x) : (uint64_t)x;
}

static inline int32_t fx_approach(int32_t from, int32_t to, uint32_t shift)
{
    const int32_t y = from + fx_asr(to - from, shift);
    int32_t between = y;

    if (from < to) {
        if (y > to) {
            between = to;
        } else if (y < from) {
            between = from;
        } else {
            between = y;
        }
    } else {
        if (y < to) {
            between = to;
        } else if (y > from) {
            between = from;
        } else {
            between = y;
        }
    }
    return between;
}

#endif
