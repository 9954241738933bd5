/* SPDX-License-Identifier: MIT */
/* An entry of the flight recorder, as it lies in its ring and in a dump. */
#ifndef RECORDER_ENTRY_H
#define RECORDER_ENTRY_H

#include <stdbool.h>
#include <stdint.h>

/*
 * An entry is a frame or a change.
 *
 *     frame    adc_ia, adc_ib; adc_bus, flags; compare of a and b; compare of c with gate_enable in
 *              bit 15, angle: each word has two halves of 16 bits, the lower first; a compare value
 *              has 15 bits
 *     change   marked by bit 15 of the third word; target; mode, request, adc_temperature: 8, 8 and
 *              16 bits; the fourth word is the crc of the configuration. They apply to the frames
 *              that follow, up to the next change
 *
 * A segment begins with a change.
 */
typedef struct {
    uint32_t word[4];
} recorder_entry_t;

#define RECORDER_CHANGE_MARK (0x8000U) /* in the third word of an entry: it is a change */

#define RECORDER_SUM_START (1U)
#define RECORDER_SUM_TURN (5U)
#define RECORDER_SUM_FACTOR (0x9E3779B1U) /* odd, with bits all over the word */

/*
 * Returns the check word of a row of entries with one more entry; the one of no entry is
 * RECORDER_SUM_START. On a Cortex-M4 it takes 25 instructions. A CRC takes 200, and the background
 * does this for each tick. It finds any change of one word, and others but for one in 2^32. Pure.
 */
static inline uint32_t recorder_entry_sum(uint32_t sum, const recorder_entry_t *entry)
{
    uint32_t next = sum;

    for (uint32_t k = 0U; k < 4U; k++) {
        const uint32_t turned = (next << RECORDER_SUM_TURN) | (next >> (32U - RECORDER_SUM_TURN));

        next = (turned ^ entry->word[k]) * RECORDER_SUM_FACTOR;
    }
    return next;
}

static inline bool recorder_entry_is_change(const recorder_entry_t *entry)
{
    return (entry->word[2] & RECORDER_CHANGE_MARK) != 0U;
}

#endif
