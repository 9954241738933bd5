/* SPDX-License-Identifier: MIT */
/*
 * The chip checks itself: completely once before the first tick, then step by step in the
 * background, as long as it runs. docs/safety.md lists the faults that this finds.
 */
#ifndef CHECK_H
#define CHECK_H

#include <stdint.h>

#define CHECK_IMAGE "the flash does not hold the image that was built"

/*
 * Checks the registers and pins of settings.h and clock.h. Returns NULL, or a text that names the
 * first one that is not as it was written.
 */
const char *check_all(void);

/*
 * Checks the next register or pin, the next words of the image, and the speed of the clock. tick:
 * hal_ticks(). Returns NULL, or the fault as text, which stays valid until the next fault is found.
 * Context: background.
 */
const char *check_step(uint32_t tick);

#endif
