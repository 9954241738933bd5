/* SPDX-License-Identifier: MIT */
/*
 * The arithmetic of port/generic for Cortex-M4 and M7. Contracts: port/generic. The results are
 * equal bit for bit.
 */
#ifndef FX_PORT_H
#define FX_PORT_H

#include "fx_armv7.h"

#include <stdint.h>

static inline int32_t fx_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    return __builtin_arm_smlawb(a, b, sum);
}

#endif
