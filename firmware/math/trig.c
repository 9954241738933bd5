#include "trig.h"

#include "trig_table.h"

#include <stdbool.h>

/* fx_asr relies on sign-extending right shifts, as every supported compiler has them. */
/* cppcheck-suppress misra-c2012-10.1 ; D1 */
_Static_assert((-3 >> 1) == -2, "right shift must keep the sign");

#define INDEX_SHIFT (32U - TRIG_SIN_BITS)
#define FRACTION_SHIFT (INDEX_SHIFT - 15U)
#define FRACTION_MASK (0x7FFFU)

#define EIGHTH_TURN (0x20000000U)
#define QUARTER_TURN (0x40000000U)
#define HALF_TURN (0x80000000U)

#define ATAN_FRACTION_BITS (16U - TRIG_ATAN_BITS)
#define ATAN_FRACTION_SCALE (0x100U)
#define ATAN_FRACTION_MASK (0xFFU)
#define ATAN_UNIT_SHIFT (29U - 16U) /* table unit: 2^-16 of an eighth turn, 2^29 */
#define ATAN_SCALE (0x20U)          /* 2^(ATAN_UNIT_SHIFT − ATAN_FRACTION_BITS) */

/* Table value at index + fraction / 2^15, rounded to nearest; neighbours differ by less than 2^8. */
static inline int32_t interpolate(uint32_t index, int32_t fraction_q15)
{
    const int32_t left = trig_sin_table[index];
    const int32_t right = trig_sin_table[index + 1U];

    return left + fx_asr(((right - left) * fraction_q15) + 0x4000, 15U);
}

sincos_t trig_sincos(angle_t angle)
{
    const uint32_t index = angle >> INDEX_SHIFT;
    const uint32_t fraction_q15 = (angle >> FRACTION_SHIFT) & FRACTION_MASK;

    return (sincos_t){
        .sin = interpolate(index, (int32_t)fraction_q15),
        .cos = interpolate(index + TRIG_SIN_QUARTER, (int32_t)fraction_q15),
    };
}

/* atan(small / large) as an angle between 0 and an eighth of a turn; 0 ≤ small ≤ large, large > 0. */
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
    const bool steep = abs_y > abs_x;
    angle_t angle = 0U;

    if ((abs_x | abs_y) != 0U) {
        angle = steep ? (QUARTER_TURN - atan_octant(abs_x, abs_y)) : atan_octant(abs_y, abs_x);
    }
    if (x < 0) {
        angle = HALF_TURN - angle;
    }
    if (y < 0) {
        angle = 0U - angle;
    }
    return angle;
}

uint16_t trig_sqrt(uint32_t x)
{
    uint32_t remainder = x;
    uint32_t root = 0U;

    /* Digit by digit, one result bit a pass. */
    for (uint32_t bit = 0x40000000U; bit != 0U; bit >>= 2U) {
        const uint32_t trial = root + bit;

        root >>= 1U;
        if (remainder >= trial) {
            remainder -= trial;
            root += bit;
        }
    }
    return (uint16_t)root;
}
