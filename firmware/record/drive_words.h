/* SPDX-License-Identifier: MIT */
/*
 * The state of the drive as 32-bit words, for everything that stores, sends or compares a state.
 *
 * drive_t differs between machines: it has a pointer to the configuration, and padding that depends
 * on the width of the pointer. Its words leave both out. They come in the order of the struct and
 * have the same number and the same values on every machine. A flag or another byte takes a word of
 * its own. A 64-bit field takes two words, the lower one first.
 *
 * Pure functions, for the background: about 15 instructions per word.
 */
#ifndef DRIVE_WORDS_H
#define DRIVE_WORDS_H

#include "drive.h"

#include <stdint.h>

/* Returns the number of words of a state. */
uint32_t drive_words_count(void);

/* Returns word `at`; 0 when `at` is not below drive_words_count(). */
uint32_t drive_words_get(const drive_t *drive, uint32_t at);

/*
 * Sets word `at`. If the word stands for a byte, only its lowest 8 bits are used. The word of a
 * flag must be 0 or 1.
 */
void drive_words_set(drive_t *drive, uint32_t at, uint32_t word);

#define DRIVE_WORDS_HASH_START (2166136261U)

/*
 * Continues a hash, for a caller that has no time for all words at once. `before` is the hash so
 * far. This call adds at most `count` words from *at on, and sets *at to the word after them. Begin
 * with DRIVE_WORDS_HASH_START and *at 0; the hash is complete when *at is drive_words_count().
 */
uint32_t drive_words_hash_part(uint32_t before, const drive_t *drive, uint32_t *at, uint32_t count);

/* Returns FNV-1a, 32 bits, over the bytes of all words, the lowest byte of a word first. */
uint32_t drive_words_hash(const drive_t *drive);

#endif
