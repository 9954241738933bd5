/* SPDX-License-Identifier: MIT */
/*
 * Clock tree, clocks of the peripherals and pins. RM0440 6.1.5 (boost), 7.2, 9.3.
 */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdbool.h>
#include <stdint.h>

/*
 * Sets the clocks of system, timers and buses to 170 MHz from the internal 16 MHz oscillator: 16
 * MHz / 4 · 85 / 2, with the regulator in boost mode and four wait states of the flash. The
 * oscillator is accurate to 1 % and needs no part outside of the chip; the speed of the motor is as
 * accurate as the oscillator. Call it first and only once, before the variables are initialised.
 * clock_is_up() is false when the regulator or the clock has not settled.
 */
void clock_init(void);
bool clock_is_up(void);

/*
 * Sets the pins as the table in docs/board_bring_up.md says. Until TIM1 drives the gate pins,
 * pull-downs hold them low.
 */
void clock_pins(void);

/*
 * The number of pins; whether a pin has the mode, the function and the resistor that clock_pins()
 * gave it; its name, such as "PA8". pin: below clock_pin_count(). Context: background.
 */
uint32_t clock_pin_count(void);
bool clock_pin_holds(uint32_t pin);
const char *clock_pin_name(uint32_t pin);

/*
 * Turns the gate pins into inputs. The pull-downs hold them low, whatever the timer does. Context:
 * background.
 */
void clock_release_gates(void);

/*
 * Waits for 1 to 90000 µs. Context: before the tick guard is started, because it uses the guard's
 * counter.
 */
void clock_wait_us(unsigned int us);

#endif
