/* SPDX-License-Identifier: MIT */
/*
 * The right shift of signed numbers. All other functions of this folder shift signed numbers by it.
 */
#ifndef FX_SHIFT_H
#define FX_SHIFT_H

#include <stdint.h>

/*
 * Returns x / 2^n rounded down (towards −∞). Range: any x, n 0…31. No saturation. Pure, any
 * context.
 */
static inline int32_t fx_asr(int32_t x, uint32_t n)
{
    return x >> n; /* cppcheck-suppress misra-c2012-10.1 ; D1 */
}

#endif
