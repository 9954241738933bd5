/* SPDX-License-Identifier: MIT */
/*
 * Over-current protection that needs no software: three comparators on the shunts, their level from
 * DAC3, their outputs on the timer's break input. RM0440 24.3.
 */
#ifndef TRIP_H
#define TRIP_H

#include <stdbool.h>

/* Sets up level and comparators. Call before pwm_init(). False if the DAC does not become ready. */
bool trip_init(void);

/*
 * Tests the path of each phase from the level to the gates, without current. The level moves past
 * the signal at rest: the comparator must switch the timer's main output off and keep it off. The
 * level moves back: the main output must stay on again. Then the comparators are locked until
 * reset. Returns NULL, or which phase fails; a phase also fails with a current beyond the level.
 * Call after pwm_init() and before pwm_connect(). Takes some 0.3 ms.
 */
const char *trip_try(void);

#endif
