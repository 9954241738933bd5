/* SPDX-License-Identifier: MIT */
/*
 * Saturation and count of leading zeros by the instructions that every ARMv7-M core has. Contracts:
 * port/generic.
 */
#ifndef FX_ARMV7_H
#define FX_ARMV7_H

#include <stdint.h>

static inline int32_t fx_sat14(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 14);
}

static inline int32_t fx_sat15(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 15);
}

static inline int32_t fx_sat16(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 16);
}

static inline int32_t fx_sat27(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 27);
}

static inline int32_t fx_sat28(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 28);
}

static inline int32_t fx_sat30(int32_t x)
{
    return (int32_t)__builtin_arm_ssat(x, 30);
}

static inline int32_t fx_usat15(int32_t x)
{
    return (int32_t)__builtin_arm_usat(x, 15);
}

static inline uint32_t fx_leading_zeros(uint32_t x)
{
    return (uint32_t)__builtin_clz(x);
}

#endif
