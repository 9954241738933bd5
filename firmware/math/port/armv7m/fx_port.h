/* SPDX-License-Identifier: MIT */
/*
 * The arithmetic of port/generic on Cortex-M3: contracts as there, results the same bit for bit.
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
