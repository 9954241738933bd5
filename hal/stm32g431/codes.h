/* SPDX-License-Identifier: MIT */
/*
 * Times as the fields of this chip's registers tell them. What is asked for is a least time: no
 * code is shorter.
 */
#ifndef CODES_H
#define CODES_H

#include <stdint.h>

/* The longest sampling used: 47.5 cycles, 1.1 µs, for dividers of some kΩ with a capacitor. */
#define CODES_SAMPLING_MAX (4UL)

/*
 * Dead time, RM0440 28.6.20 (DTG): the shortest of at least `ticks` of the timer, 0 to 1008. Steps
 * grow with it: 1 up to 127, 2 up to 254, 8 up to 504, then 16.
 */
uint32_t codes_dead_time(uint32_t ticks);

/*
 * Sampling time, RM0440 21.7.6 (SMP): at least `ns`, 0 to 1100; beyond, CODES_SAMPLING_MAX. 2.5,
 * 6.5, 12.5, 24.5 or 47.5 cycles of the converters' clock of 42.5 MHz.
 */
uint32_t codes_sampling(uint32_t ns);

#endif
