/* SPDX-License-Identifier: MIT */
/*
 * The distances of firmware/record/ring.h between whole entries of one array, for the proof: what a
 * rotation of bits says of two places is beyond intervals. test_proof_port.c compares both.
 */
#ifndef RING_H
#define RING_H

#define RING_ENTRY_LOG2 (4U) /* bytes */

#include "recorder_entry.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*@ requires first <= end; */
static inline size_t ring_entries_between(const recorder_entry_t *first,
                                          const recorder_entry_t *end)
{
    return (size_t)(end - first);
}

static inline bool ring_is_within(const recorder_entry_t *at, const recorder_entry_t *stop,
                                  uint32_t span)
{
    bool within = false;

    if ((stop != NULL) && (at <= stop)) {
        within = (stop - at) <= (ptrdiff_t)span;
    }
    return within;
}

#endif
