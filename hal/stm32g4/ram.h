/* SPDX-License-Identifier: MIT */
/*
 * The test of the RAM, and the part of it that a reset leaves as it was.
 *
 * The chip starts at reset_entry, which sets the clock and then tests the RAM by March C-, with
 * 0x55555555 and 0xAAAAAAAA. It writes a pattern. Twice upwards, and then twice downwards, it reads
 * each word and writes its opposite. At last it reads all words. This finds bits that are stuck or
 * do not change, neighbours that change each other, and addresses that select a wrong word. It
 * takes 4 ms at most with 32 KiB of RAM, 16 ms with 128 KiB. If the parity of the RAM is enabled,
 * the test also gives each word its first parity.
 *
 * The section .kept at the end of the RAM has the flight recorder and what it needs. A mark in a
 * backup register says that this image has filled it. Then the reset entry leaves .kept out, and
 * ram_test_kept() tests it later, when its content has been saved. The two tests then do not find
 * an address in one part that leads to a word of the other part. Without the mark, as after a loss
 * of the supply, with another image, or when the start before has not come to its end, the whole
 * RAM is tested at once.
 */
#ifndef RAM_H
#define RAM_H

#include <stdbool.h>
#include <stdint.h>

#define RAM_KEPT __attribute__((section(".kept")))

/*
 * The first address that did not hold the written word; 0: there is none. reset_entry writes this
 * variable, and the initialisation of the variables does not change it.
 */
extern uint32_t ram_fault;

/* Where reset_entry has ended its test: the end of the RAM, or the beginning of .kept. */
extern const uint32_t *ram_tested_end;

/* Returns where reset_entry has to end its test. Only for it. */
const uint32_t *ram_test_end(void);

/*
 * Tests the words from `first` to before `end`, and returns as ram_fault. Uses registers only. What
 * they held is lost. reset_entry and ram_test_kept() call it.
 */
uint32_t ram_test(uint32_t *first, const uint32_t *end);

/* Whether .kept has what the run before has left. The same at each call. */
bool ram_is_kept(void);

/* Tests .kept if the reset entry has not done so. Sets ram_fault. */
void ram_test_kept(void);

/*
 * Sets the mark: from now on a reset leaves .kept as it is. ram_forget() takes it away: if the
 * start does not come to ram_keep(), the next one begins with an empty RAM. Needs the clocks of the
 * peripherals.
 */
void ram_keep(void);
void ram_forget(void);

#endif
