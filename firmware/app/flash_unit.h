/* SPDX-License-Identifier: MIT */
/*
 * Units of a flash slot (hal.h), and stamps, for everything that is kept in flash through a loss of
 * power at any time: the store (store.h) and the black box (box.h).
 *
 * A stamp is a unit: a sequence number, and the CRC-32 of the CRC of what is stamped and of this
 * number. So a stamp is good only for what was written before it, and it is written last.
 *
 * Context: background, as the functions of hal.h.
 */
#ifndef FLASH_UNIT_H
#define FLASH_UNIT_H

#include "hal.h"

#include <stdbool.h>
#include <stdint.h>

#define FLASH_UNIT_WORDS (2U)

/* Reads a unit. False when the flash cannot read it; then the words may be anything. */
bool flash_unit_read(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t words[FLASH_UNIT_WORDS]);

/* Programs a unit with two words. False when it does not read back as written. */
bool flash_unit_program(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t first, uint32_t second);

/* The units of a slot that are for stamps: from `first` to `end` − 1. */
typedef struct {
    uint32_t slot;
    uint32_t first;
    uint32_t end;
} flash_unit_stamps_t;

/*
 * Finds the last good stamp of something with this CRC. A unit that cannot be read is not a stamp.
 * Returns false, and leaves *sequence as it is, when there is none.
 */
bool flash_unit_find_stamp(hal_t *hal, const flash_unit_stamps_t *stamps, uint32_t crc,
                           uint32_t *sequence);

/*
 * Programs `count` stamps into the first units that take them. Returns false if fewer units take a
 * stamp.
 */
bool flash_unit_put_stamps(hal_t *hal, const flash_unit_stamps_t *stamps, uint32_t count,
                           uint32_t sequence, uint32_t crc);

#endif
