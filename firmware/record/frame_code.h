/* SPDX-License-Identifier: MIT */
/*
 * Codes entries of the flight recorder in few bytes, so that the inputs of the ticks can be sent
 * over a line. The outputs are left out, because a receiver computes them from the inputs.
 *
 * A code is complete in itself: it begins with whole values and needs no code before it. Each later
 * value is coded as its difference from a prediction. There are three predictions: the value
 * before, a line through the last two values, and a smoother line. Each channel uses the one that
 * fits these entries best. The differences are Rice codes, with the parameter that fits best. A
 * channel that is constant takes 6 bits.
 */
#ifndef FRAME_CODE_H
#define FRAME_CODE_H

#include "recorder.h"

#include <stdbool.h>
#include <stdint.h>

#define FRAME_CODE_ENTRIES_MAX (64U)

/*
 * Codes as many of the entries, from entries[0] on, as fit into `room` bytes; count is
 * 1…FRAME_CODE_ENTRIES_MAX, room at least 32. Returns the number of coded entries, at least 1;
 * *length: bytes written. Context: background.
 */
uint32_t frame_code_encode(const recorder_entry_t *entries, uint32_t count, uint8_t *bytes,
                           uint32_t room, uint32_t *length);

/*
 * Decodes exactly `count` entries, 1…FRAME_CODE_ENTRIES_MAX; the words of the outputs are 0.
 * Returns false when the bytes are not a code of `count` entries, or when there are more bytes than
 * the code needs; the entries may then hold anything. It never reads beyond `length`, whatever the
 * bytes are. Pure.
 */
bool frame_code_decode(const uint8_t *bytes, uint32_t length, recorder_entry_t *entries,
                       uint32_t count);

#endif
