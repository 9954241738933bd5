/* SPDX-License-Identifier: MIT */
/*
 * The test of the RAM, between reset and the first use of a variable.
 *
 * The chip starts at reset_entry, which sets the clock and then tests the whole RAM by March C-,
 * with 0x55555555 and 0xAAAAAAAA. It writes a pattern. Twice upwards, and then twice downwards, it
 * reads each word and writes its opposite. At last it reads all words. This finds bits that are
 * stuck or do not change, neighbours that change each other, and addresses that select a wrong
 * word. It takes 4 ms at most with 32 KiB of RAM, 16 ms with 128 KiB. If the parity of the RAM is
 * enabled, the test also gives each word its first parity.
 */
#ifndef RAM_H
#define RAM_H

#include <stdint.h>

/*
 * The first address that did not hold the written word; 0: there is none. reset_entry writes this
 * variable, and the initialisation of the variables does not change it.
 */
extern uint32_t ram_fault;

#endif
