/* SPDX-License-Identifier: MIT */
/*
 * CRC-32 (IEEE 802.3, reflected): of the configuration, and of what is sent of a recording.
 *
 * The polynomial 0xEDB88320 over four bits at a time, by a table of 16 words: about 60 instructions for four bytes.
 * Begin with CRC32_START; the CRC is the complement of what the last step returns. Pure, any context.
 */
#ifndef CRC32_H
#define CRC32_H

#include <stdint.h>

#define CRC32_START (0xFFFFFFFFU)

/* Four bytes further. */
uint32_t crc32_step(uint32_t before, const uint8_t *bytes);

#endif
