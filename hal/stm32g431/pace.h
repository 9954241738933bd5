/* SPDX-License-Identifier: MIT */
/*
 * Whether the system's clock has its speed, by an oscillator that has nothing to do with it: TIM16
 * captures each eighth edge of the watchdog's oscillator, RM0440 30.4, and the time between two
 * captures has to be one that both oscillators allow.
 *
 * The data sheet lets the watchdog's oscillator have 29.5 to 34 kHz over all temperatures and
 * supplies, and the clock is off by 2 % at most. So a clock that is 18 % fast or 15 % slow is found
 * on any chip, and one that is 11 % fast or 8 % slow on a chip with the typical 32 kHz. It takes 4
 * captures in a row, each 0.25 ms behind the one before.
 *
 * A pass of the background that comes later than two captures tells nothing. With less than 2.5 kHz
 * of PWM that is each of them, and the speed is not checked.
 */
#ifndef PACE_H
#define PACE_H

#include <stdint.h>

/* Start to capture. Call once, before the watchdog starts its oscillator. */
void pace_init(void);

/*
 * Look for a capture. NULL, or what is wrong: the speed, or that there was no capture for 0.1 s.
 * tick: hal_ticks(). Context: background.
 */
const char *pace_step(uint32_t tick);

#endif
