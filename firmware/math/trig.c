/* SPDX-License-Identifier: MIT */
#include "trig.h"

#include "trig_table.h"

/* fx_asr relies on sign-extending right shifts, as every supported compiler has them. */
/* cppcheck-suppress misra-c2012-10.1 ; D1 */
_Static_assert((-3 >> 1) == -2, "right shift must keep the sign");

#define EIGHTH_TURN (0x20000000U)
#define QUARTER_TURN (0x40000000U)
#define HALF_TURN (0x80000000U)

#define ATAN_FRACTION_BITS (16U - TRIG_ATAN_BITS)
#define ATAN_FRACTION_SCALE (0x100U)
#define ATAN_FRACTION_MASK (0xFFU)
#define ATAN_UNIT_SHIFT (29U - 16U) /* a table entry counts 2^-16 of an eighth turn (2^29) */
#define ATAN_SCALE (0x20U)          /* 2^(ATAN_UNIT_SHIFT − ATAN_FRACTION_BITS) */

#define ROOT_ERROR (4)
#define ROOT_MIN (0x8000U) /* √m of the smallest m, 2^30 */
#define ROOT_MAX (65535)

/*
 * Returns atan(small / large), an angle between 0 and an eighth of a turn; 0 ≤ small ≤ large, large
 * > 0.
 */
static angle_t atan_octant(uint32_t small, uint32_t large)
{
    const uint32_t ratio_q16 = (small << 16U) / large;
    const uint32_t index = ratio_q16 >> ATAN_FRACTION_BITS;
    const uint32_t fraction = ratio_q16 & ATAN_FRACTION_MASK;
    angle_t angle = EIGHTH_TURN;

    if (index < TRIG_ATAN_SIZE) {
        const uint32_t left = trig_atan_table[index];
        const uint32_t right = trig_atan_table[index + 1U];

        angle = ((left * ATAN_FRACTION_SCALE) + ((right - left) * fraction)) * ATAN_SCALE;
    }
    return angle;
}

angle_t trig_atan2(int16_t y, int16_t x)
{
    const uint32_t abs_x = (uint32_t)fx_abs(x);
    const uint32_t abs_y = (uint32_t)fx_abs(y);
    angle_t angle = 0U;

    if (abs_y > abs_x) {
        angle = QUARTER_TURN - atan_octant(abs_x, abs_y);
    } else if (abs_x > 0U) {
        angle = atan_octant(abs_y, abs_x);
    } else {
        /* the vector (0, 0) has no direction */
    }
    if (x < 0) {
        angle = HALF_TURN - angle;
    }
    if (y < 0) {
        angle = 0U - angle;
    }
    return angle;
}

/* Returns floor(√m), or `above` if that is smaller. m ≥ 2^30. */
static uint32_t whole_root(uint32_t m, uint32_t above)
{
    uint32_t root = above;

    while ((root > ROOT_MIN) && ((root * root) > m)) {
        root--;
    }
    return root;
}

/*
 * Returns floor(√m) by a reciprocal root r ≈ 2^31/√m from the table and one Newton step on s = m·r:
 *     s ← s + (m − s²)·r/2^32
 * m = 2^30…2^32 − 1. The table is right within 2^-8, which leaves an error of 1.5·2^-16 of s. The
 * loop in whole_root() makes the root exact.
 */
static uint32_t root_of_normalised(uint32_t m)
{
    /*@ assert BLOCKS(m); */
    const uint32_t reciprocal = trig_rsqrt_table[(m >> 24U) - TRIG_RSQRT_FIRST];
    const uint32_t estimate = ((m >> 16U) * reciprocal) >> 15U;
    const uint32_t start = (estimate < (uint32_t)ROOT_MAX) ? estimate : (uint32_t)ROOT_MAX;
    const uint32_t m_high = m >> 11U;
    const uint32_t square_high = (start * start) >> 11U;
    const int32_t rest = (int32_t)m_high - (int32_t)square_high;
    const uint32_t half = reciprocal >> 1U;
    const int32_t step = fx_asr(rest * (int32_t)half, 20U);
    const int32_t above = fx_min((int32_t)start + step + ROOT_ERROR, ROOT_MAX);

    return whole_root(m, (uint32_t)above);
}

uint16_t trig_sqrt(uint32_t x)
{
    uint32_t root = 0U;

    if (x != 0U) {
        const uint32_t half_shift = fx_leading_zeros(x) / 2U;

        const uint32_t m = x << (2U * half_shift);
        /*@ slevel merge; */
        root = root_of_normalised(m) >> half_shift;
    }
    return (uint16_t)root;
}
