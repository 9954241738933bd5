/* SPDX-License-Identifier: MIT */
/*
 * The arithmetic of port/generic for Cortex-M3. Contracts: port/generic. The results are equal bit
 * for bit.
 */
#ifndef FX_PORT_H
#define FX_PORT_H

#include "fx_armv7.h"

#include <stdint.h>

static inline int32_t fx_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    const int64_t product = (int64_t)a * b;
    const uint64_t shifted = (uint64_t)product >> 16U;

    return sum + (int32_t)(uint32_t)(shifted & 0xFFFFFFFFU);
}

#endif
