/* SPDX-License-Identifier: MIT */
/*
 * Words of 32 bits are stored as bytes, the lowest byte first, in files and in flash. The functions
 * do not depend on the byte order of the machine. Pure, any context; the addresses need not be
 * aligned.
 */
#ifndef WORDS_H
#define WORDS_H

#include <stdint.h>

#define WORDS_BYTES (4U) /* bytes of a word */

/* Returns the word of the four bytes at `from`. */
static inline uint32_t words_get(const uint8_t *from)
{
    return from[0] | ((uint32_t)from[1] << 8U) | ((uint32_t)from[2] << 16U) |
           ((uint32_t)from[3] << 24U);
}

/* Writes a word to the four bytes at `to`. */
static inline void words_put(uint8_t *to, uint32_t word)
{
    for (uint32_t k = 0U; k < WORDS_BYTES; k++) {
        to[k] = (uint8_t)((word >> (8U * k)) & 0xFFU);
    }
}

#endif
