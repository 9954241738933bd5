/* SPDX-License-Identifier: MIT */
/*
 * Over-current protection that needs no software: three comparators on the shunts, their level from
 * DAC3, their outputs on the timer's break input. RM0440 24.3.
 */
#ifndef TRIP_H
#define TRIP_H

#include <stdbool.h>

/* Level and comparators. Call before pwm_init(). False when the DAC is not ready. */
bool trip_init(void);

/*
 * Try each way from level to gates without current: the level moves past the signal at rest, and
 * the comparator must take the timer's main output away and keep it; it must give it back when the
 * level is where it belongs. Then the comparators are locked until reset. NULL, or which phase
 * fails; a current beyond the level does, too. Call behind pwm_init() and before pwm_connect():
 * some 0.3 ms.
 */
const char *trip_try(void);

#endif
