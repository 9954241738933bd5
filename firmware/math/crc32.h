/* SPDX-License-Identifier: MIT */
/*
 * CRC-32 (IEEE 802.3, reflected), for the configuration and for recordings that are sent.
 *
 * Polynomial 0xEDB88320, four bits at a time with a table of 16 words: about 60 instructions for
 * four bytes. Begin with CRC32_START. The CRC is the complement of the result of the last step.
 * Pure, any context.
 */
#ifndef CRC32_H
#define CRC32_H

#include <stdint.h>

#define CRC32_START (0xFFFFFFFFU)

/* Returns the sum after the four bytes at `bytes`; before: the sum so far. */
uint32_t crc32_step(uint32_t before, const uint8_t *bytes);

/* Returns the sum after one more byte. */
uint32_t crc32_byte(uint32_t before, uint8_t byte);

#endif
