/* SPDX-License-Identifier: MIT */
/*
 * The store: the newest configuration block, kept in flash through a loss of power at any time.
 *
 * There are two slots (hal.h). A block is written into the one that does not hold the newest block.
 * A slot is
 *
 *     units 0…191     the block, the rest erased
 *     units 192…255   stamps, one behind the other, the rest erased
 *
 * A stamp is a sequence number, and the CRC-32 of this number and of the CRC of the block. A slot
 * is whole when the CRC of its block is right and one of its stamps is good; its sequence number is
 * that of its last good stamp. The newest block is that of the whole slot with the higher number.
 *
 * Writing takes four steps. Power may fail in each of them; behind each is what a start finds then:
 *
 *     1. the slot that is kept gets two more stamps     old block
 *     2. the other slot is erased                       old block
 *     3. the new block is programmed into it            old block
 *     4. it gets its stamp                              old block, or new block
 *
 * Step 1 is for the steps after a loss of power. A unit whose programming was cut may read well at
 * one start and badly at the next, and an erase that was cut may leave a slot that still reads as
 * it was. With a stamp that was programmed to its end and has a higher number than any that the
 * other slot can have, the kept slot stays the newest whatever the other one reads as. There are
 * two stamps, because a unit that reads as erased may be one whose programming was cut: the first
 * of the two may meet it, the second does not.
 *
 * The first stamp of a block has an even number, one above that of the kept slot. Its later stamps
 * have the odd number that follows, as long as the other slot is whole: no write can have gone
 * beyond step 1 then. Else one may have come to step 4, and the block of this write may have got
 * more stamps: the number goes up by 4.
 *
 * Each write takes two units of the kept slot for stamps, and a write that succeeds changes the
 * slots: the units run out after 31 writes in a row that were cut. Step 1 then has one stamp, later
 * none; its number counts all the same.
 */
#ifndef STORE_H
#define STORE_H

#include "config_block.h"
#include "hal.h"

#include <stdbool.h>
#include <stdint.h>

#define STORE_BLOCK_UNITS (192U) /* 1536 bytes */

typedef struct {
    hal_t *hal;
    bool found;        /* a whole block */
    uint32_t slot;     /* of the newest one */
    uint32_t sequence; /* its number, wrapping */
} store_t;

/*
 * Looks for the newest whole block, of whatever schema and board. Context: background, before the
 * control interrupt is enabled. About 60000 instructions.
 */
void store_find(store_t *store, hal_t *hal);

/*
 * Copies the newest block as far as config_block_t goes. False, and the block may be anything, when
 * there is none or the flash cannot read it. Context: as store_find().
 */
bool store_read(const store_t *store, config_block_t *block);

/*
 * Writes a block, which becomes the newest. Returns NULL, or what does not work; the old block is
 * kept then. Context: that of the binding's hal_store_erase(); the caller has to see to it that the
 * drive rests.
 */
const char *store_write(store_t *store, const config_block_t *block);

#endif
