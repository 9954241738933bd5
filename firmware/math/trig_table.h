/* SPDX-License-Identifier: MIT */
/* Tables of trig.c. Generated values, see tools/gen_trig_table.py. Private to firmware/math. */
#ifndef TRIG_TABLE_H
#define TRIG_TABLE_H

#include "fx.h"

#include <stdint.h>

#define TRIG_SIN_QUARTER (256U) /* entries per quarter turn */
#define TRIG_SLOPE_BITS (12U)
#define TRIG_INDEX_SHIFT (22U)
#define TRIG_FRACTION_SHIFT (9U)
#define TRIG_FRACTION_MASK (0x1FFFU)

/*
 * s(k) = 32767·sin(2π·k / 1024), k = 0…1279: one turn, and a quarter turn more for the cosine. One
 * entry holds value and slope. Its lower 12 bits are the slope 2^3·(s(k + 1) − s(k)), rounded and
 * signed. The entry is the number with these lower bits that is nearest to 2^16·(s(k) + ½). (entry
 * + slope·fraction) >> 16 is the rounded sine for a fraction of 13 bits.
 */
extern const int32_t trig_sin_table[1280];

/* Returns the sine at an entry of the table and a fraction of 13 bits, Q15. */
static inline int32_t trig_interpolate(int32_t entry, int32_t fraction)
{
    const uint32_t slope_high = fx_unsigned(entry) << (32U - TRIG_SLOPE_BITS);
    const int32_t slope = fx_asr(fx_signed(slope_high), 32U - TRIG_SLOPE_BITS);

    return fx_asr(entry + (slope * fraction), 16U);
}

#define TRIG_ATAN_BITS (8U)
#define TRIG_ATAN_SIZE (256U)

/* round(2^16·atan(k / 256) / (π/4)), k = 0…256, the last entry limited to 65535. */
extern const uint16_t trig_atan_table[257];

#define TRIG_RSQRT_FIRST (64U)

/*
 * round(2^15 / √((k + 64.5) / 256)), k = 0…191: reciprocal roots in the middle of their intervals.
 */
extern const uint16_t trig_rsqrt_table[192];

#endif
