/* SPDX-License-Identifier: MIT */
/*
 * Entries of the flight recorder in few bytes: the inputs of the ticks, for a line. The outputs are
 * left out, because whoever has the inputs computes them.
 *
 * A code stands for itself: it begins with whole values and needs no code before it. What follows
 * is coded as the difference from a prediction, for each channel by the one of three that fits
 * these entries best: the value before, or a line, steep or smooth, through those before. The
 * differences are Rice codes, with the parameter that fits. A channel that is constant takes 6
 * bits.
 */
#ifndef FRAME_CODE_H
#define FRAME_CODE_H

#include "recorder.h"

#include <stdbool.h>
#include <stdint.h>

#define FRAME_CODE_ENTRIES_MAX (64U)

/*
 * Codes entries[0] to at most entries[count − 1], count 1…FRAME_CODE_ENTRIES_MAX, as many as fit
 * into `room` bytes, at least 32. Returns how many, at least 1; *length: bytes written. Context:
 * background.
 */
uint32_t frame_code_encode(const recorder_entry_t *entries, uint32_t count, uint8_t *bytes,
                           uint32_t room, uint32_t *length);

/*
 * Decodes exactly `count` entries, 1…FRAME_CODE_ENTRIES_MAX; the words of the outputs are 0. False,
 * and the entries may be anything, when the bytes are no code of so many entries, or are longer. No
 * bytes make it read beyond `length`. Pure.
 */
bool frame_code_decode(const uint8_t *bytes, uint32_t length, recorder_entry_t *entries,
                       uint32_t count);

#endif
