/* SPDX-License-Identifier: MIT */
/*
 * Checks the speed of the system clock against an independent oscillator. TIM16 captures each
 * eighth edge of the watchdog's oscillator, RM0440 30.4. The time between two captures has to be
 * within the tolerances of both oscillators.
 *
 * By the data sheet the watchdog's oscillator has 29.5 to 34 kHz over all temperatures and
 * supplies, and the clock is off by 2 % at most. So a clock that is 18 % fast or 15 % slow is found
 * on any chip, and one that is 11 % fast or 8 % slow on a chip with the typical 32 kHz. It is found
 * by 4 wrong times in a row, of 0.25 ms each.
 *
 * When two captures have come since the last pass of the background, the time between them is not
 * known. With a PWM below 2.5 kHz this is so in each pass, and the speed is not checked.
 */
#ifndef PACE_H
#define PACE_H

#include <stdint.h>

/* Starts the captures. Call once, before the watchdog starts its oscillator. */
void pace_init(void);

/*
 * Looks for a capture. Returns NULL, or what is wrong: the speed, or no capture for 0.1 s. tick:
 * hal_ticks(). Context: background.
 */
const char *pace_step(uint32_t tick);

#endif
