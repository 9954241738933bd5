/* SPDX-License-Identifier: MIT */
/*
 * Codes for times in the registers of this chip. The time asked for is a minimum: the time of the
 * code is never shorter.
 */
#ifndef CODES_H
#define CODES_H

#include <stdint.h>

/* The longest sampling time used: 47.5 cycles, 1.1 µs, for dividers of some kΩ with a capacitor. */
#define CODES_SAMPLING_MAX (4UL)

/*
 * Returns the code of the shortest dead time of at least `ticks` timer ticks, 0 to 1008; RM0440
 * 28.6.20 (DTG). The codes have steps of 1 tick up to 127, of 2 up to 254, of 8 up to 504, then of
 * 16.
 */
uint32_t codes_dead_time(uint32_t ticks);

/*
 * Returns the code of the shortest sampling time of at least `ns`, 0 to 1100; for more it returns
 * CODES_SAMPLING_MAX. RM0440 21.7.6 (SMP): 2.5, 6.5, 12.5, 24.5 or 47.5 cycles of the converters'
 * clock of 42.5 MHz.
 */
uint32_t codes_sampling(uint32_t ns);

#endif
