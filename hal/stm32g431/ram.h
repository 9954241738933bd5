/* SPDX-License-Identifier: MIT */
/*
 * The test of the RAM, between reset and the first use of a variable.
 *
 * reset_entry, where the chip starts, sets the clock and then marches through the whole RAM: writes
 * a pattern, and reads it and writes its opposite upwards, upwards, downwards and downwards, and
 * reads (March C-, with 0x55555555 and 0xAAAAAAAA). It finds bits that are stuck or do not change,
 * neighbours that change each other, and addresses that are not their own. 4 ms at most. With the
 * parity of the RAM in force it gives each word its first parity, too.
 */
#ifndef RAM_H
#define RAM_H

#include <stdint.h>

/*
 * The first address that does not hold what was written; 0: there is none. Kept from before the
 * variables are set.
 */
extern uint32_t ram_fault;

#endif
