/*
 * Arithmetic for which Cortex-M3 has an instruction: contracts in port/generic, results the same bit for bit.
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
    const int64_t product = (int64_t)a * b;
    const uint64_t shifted = (uint64_t)product >> 16U;

    return sum + (int32_t)(uint32_t)(shifted & 0xFFFFFFFFU);
}

static inline uint32_t fx_leading_zeros(uint32_t x)
{
    return (uint32_t)__builtin_clz(x);
}

#endif
