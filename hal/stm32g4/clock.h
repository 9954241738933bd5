/* SPDX-License-Identifier: MIT */
/*
 * Clock tree and clocks of the peripherals. RM0440 6.1.5 (boost), 7.2.
 *
 * The clocks of system, timers and buses have 170 MHz: the PLL makes them of the board's crystal,
 * or of the oscillator in the chip, 16 MHz / 4 · 85 / 2. The oscillator is accurate to 1 % and
 * needs no part outside of the chip; with it the speed of the motor is accurate to 1 % too.
 *
 * A crystal is measured against the oscillator at the start. Later the chip watches it: when it
 * stops, the timer opens the gates in hardware, the clock falls back to the oscillator, and the NMI
 * comes.
 */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdbool.h>

/*
 * Sets the clocks to 170 MHz, with the regulator in boost mode and four wait states of the flash.
 * With a crystal that does not start within some 0.3 s, or that is off by more than 3 %, they are
 * made of the oscillator. Call it first and only once, before the variables are initialised.
 * clock_is_up() is false when the regulator or the clock has not settled.
 */
void clock_init(void);
bool clock_is_up(void);

/*
 * Returns NULL, or what was wrong with the crystal in clock_init(): the gates have to stay open
 * then. Call when clock_is_up().
 */
const char *clock_crystal_fault(void);

/* Switches on the clocks of the peripherals and of the pins' ports, and the watch of the crystal.
 */
void clock_peripherals(void);

/* Whether the crystal has stopped: the reason of an NMI. Context: NMI. */
bool clock_has_lost_crystal(void);

/*
 * After that: makes the clocks of 170 MHz of the oscillator, so that the serial line works.
 * Acknowledges the NMI. Context: NMI.
 */
void clock_do_without_crystal(void);

/*
 * Waits for 1 to 25000 µs. Context: before the tick guard is started, because it uses the guard's
 * counter.
 */
void clock_wait_us(unsigned int us);

#endif
