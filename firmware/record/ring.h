/* SPDX-License-Identifier: MIT */
/*
 * Distances in the ring of the recorder. They are right even if bits of the pointers have flipped
 * by themselves. This header is separate, because the proof replaces it by an equal formulation.
 * Pure, any context.
 */
#ifndef RING_H
#define RING_H

#include "recorder_entry.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RING_ENTRY_LOG2 (4U) /* log2 of the bytes of an entry */
#define RING_TOP_SHIFT ((8U * sizeof(size_t)) - RING_ENTRY_LOG2)

/*
 * Returns the distance in entries. The bits of the distance below one entry move to the top, so a
 * distance that is not a whole number of entries becomes a huge number.
 */
static inline size_t ring_entries_between(const recorder_entry_t *first,
                                          const recorder_entry_t *end)
{
    const uint8_t *const from = (const uint8_t *)first;
    const uint8_t *const to = (const uint8_t *)end;
    const ptrdiff_t distance = to - from; /* cppcheck-suppress misra-c2012-18.4 ; D6 */
    const size_t bytes = (size_t)distance;

    return (bytes >> RING_ENTRY_LOG2) | (bytes << RING_TOP_SHIFT);
}

/*
 * Whether `at` is not beyond `stop`, and at most `span` entries before it. If `at` is beyond the
 * stop or between two entries, the distance is a huge number. If the stop is NULL, nothing is
 * within.
 */
static inline bool ring_is_within(const recorder_entry_t *at, const recorder_entry_t *stop,
                                  uint32_t span)
{
    return ring_entries_between(at, stop) <= span;
}

#endif
