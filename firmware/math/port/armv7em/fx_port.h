/*
 * Arithmetic for which Cortex-M4 and M7 have an instruction: contracts in port/generic, results the same bit for bit.
 */
#ifndef FX_PORT_H
#define FX_PORT_H

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

static inline int32_t fx_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    return __builtin_arm_smlawb(a, b, sum);
}

static inline uint32_t fx_leading_zeros(uint32_t x)
{
    return (uint32_t)__builtin_clz(x);
}

#endif
