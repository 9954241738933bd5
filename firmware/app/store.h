/* SPDX-License-Identifier: MIT */
/*
 * The store: the newest configuration block, kept in flash through a loss of power at any time.
 *
 * There are two slots (hal.h). A block is written into the slot that does not hold the newest
 * block. A slot is
 *
 *     units 0…191     the block, the rest erased
 *     units 192…255   stamps, one after the other, the rest erased
 *
 * A stamp is a sequence number, and the CRC-32 of this number and of the CRC of the block. A slot
 * is whole if the CRC of its block is right and at least one of its stamps is good. The sequence
 * number of a slot is the number of its last good stamp. If both slots are whole, the slot with the
 * higher number has the newest block.
 *
 * Writing takes four steps. Power may fail in each of them; the right column says which block a
 * start finds then:
 *
 *     1. the slot that is kept gets two more stamps     old block
 *     2. the other slot is erased                       old block
 *     3. the new block is programmed into it            old block
 *     4. it gets its stamp                              old block, or new block
 *
 * Step 1 protects against a loss of power in this write or an earlier one. A unit whose programming
 * was interrupted may read well at one start and badly at the next, and a slot whose erasing was
 * interrupted may still read as before. So the kept slot gets a stamp that is programmed to its end
 * and has a higher number than any stamp that the other slot can have: the kept slot stays the
 * newest, whatever is read from the other slot. There are two stamps, because a unit that reads as
 * erased may be one whose programming was interrupted. The first stamp may be written into such a
 * unit, the second is not.
 *
 * The first stamp of a block has an even number, one above the number of the kept slot. Its later
 * stamps have the odd number that follows. As long as the other slot is whole, no write has gone
 * beyond step 1, and later stamps get the same odd number. If the other slot is not whole, a write
 * may have reached step 4, and its block may have got more stamps. Then the number of the next
 * stamps is higher by 4.
 *
 * Each write takes two units of the kept slot for stamps, and a write that succeeds exchanges the
 * slots. So the units run out after 31 interrupted writes in a row. Then step 1 writes one stamp,
 * later none, but the sequence number goes up as if it had written both.
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
    bool found;        /* there is a whole block */
    uint32_t slot;     /* slot of the newest block */
    uint32_t sequence; /* sequence number of the newest block, wraps */
} store_t;

/*
 * Looks for the newest whole block, of any schema and board. Context: background, before the
 * control interrupt is enabled. About 60000 instructions.
 */
void store_find(store_t *store, hal_t *hal);

/*
 * Copies the newest block, as many words as config_block_t has. Returns false when there is none or
 * the flash cannot read it: *block may be anything then. Context: as store_find().
 */
bool store_read(const store_t *store, config_block_t *block);

/*
 * Writes a block, which becomes the newest. Returns NULL, or the reason for a failure; after a
 * failure the old block is still the newest. Context: as for the binding's hal_store_erase(); the
 * caller has to make sure that the drive is at rest.
 */
const char *store_write(store_t *store, const config_block_t *block);

#endif
