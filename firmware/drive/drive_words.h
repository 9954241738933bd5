/* SPDX-License-Identifier: MIT */
/*
 * The state of the drive as 32-bit words: the one description of what a state is beside its struct.
 *
 * drive_t has machine's things in it: a pointer to the configuration, and padding that differs with the
 * pointer's width. Its words, in the order of the struct, are what remains: the same number and the same values on every
 * machine. A flag or another byte is a word of its own, a 64-bit field two, the lower one first.
 *
 * Pure functions, for the background: some 15 instructions a word.
 */
#ifndef DRIVE_WORDS_H
#define DRIVE_WORDS_H

#include "drive.h"

#include <stdint.h>

/* How many words a state has. */
uint32_t drive_words_count(void);

/* One of them, `at` below their number; 0 beyond. */
uint32_t drive_words_get(const drive_t *drive, uint32_t at);

/* Puts it where drive_words_get() takes it from. Of a byte's word the lowest byte counts; a flag's has to be 0 or 1. */
void drive_words_set(drive_t *drive, uint32_t at, uint32_t word);

/* FNV-1a, 32 bits, over the bytes of the words, lowest first. */
uint32_t drive_words_hash(const drive_t *drive);

#endif
