/* SPDX-License-Identifier: MIT */
/* An entry of the flight recorder, as it lies in its ring and in a dump. */
#ifndef RECORDER_ENTRY_H
#define RECORDER_ENTRY_H

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

#endif
