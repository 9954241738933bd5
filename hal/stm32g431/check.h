/* SPDX-License-Identifier: MIT */
/*
 * The chip checks itself: once in whole before the first tick, then in the background for as long
 * as it runs, a few registers a pass. docs/safety.md has the faults that it finds.
 */
#ifndef CHECK_H
#define CHECK_H

#include <stdint.h>

#define CHECK_IMAGE "the flash does not hold the image that was built"

/* All registers and pins that protect. NULL, or the first that is not as it was written. */
const char *check_all(void);

/*
 * The next of them, the next words of the image, and the clock. tick: hal_ticks(). NULL, or what is
 * wrong with it: the text stays as it is until the next that is wrong. Context: background.
 */
const char *check_step(uint32_t tick);

#endif
