/* SPDX-License-Identifier: MIT */
/*
 * Over-current protection that needs no software: three comparators on the shunts, their level from DAC3,
 * their outputs on the timer's break input. RM0440 24.3.
 */
#ifndef TRIP_H
#define TRIP_H

#include <stdbool.h>

/* Level and comparators, locked until reset. Call before pwm_init(). False when the DAC is not ready. */
bool trip_init(void);

#endif
