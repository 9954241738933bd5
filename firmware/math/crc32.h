/* SPDX-License-Identifier: MIT */
/*
 * CRC-32 (IEEE 802.3, reflected), for the configuration and for recordings that are sent.
 *
 * Polynomial 0xEDB88320, four bits at a time with a table of 16 words: about 60 instructions for
 * four bytes. Begin with the CRC word CRC32_START. The CRC is the complement of the last CRC word.
 * Pure, any context.
 */
#ifndef CRC32_H
#define CRC32_H

#include <stdint.h>

#define CRC32_START (0xFFFFFFFFU)

/* Returns the CRC word after the four bytes at `bytes`. before: the CRC word before them. */
uint32_t crc32_step(uint32_t before, const uint8_t *bytes);

/* Returns the CRC word after the four bytes of a word, the lowest first. */
uint32_t crc32_word(uint32_t before, uint32_t word);

/* Returns the CRC word after one more byte. */
uint32_t crc32_byte(uint32_t before, uint8_t byte);

#endif
