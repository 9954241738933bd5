/* SPDX-License-Identifier: MIT */
/*
 * The pins that the board file names. RM0440 9.3.
 */
#ifndef PINS_H
#define PINS_H

#include <stdbool.h>
#include <stdint.h>

/*
 * Sets the pins, and the levels of the outputs before they drive. Until TIM1 drives the gate pins,
 * pull-downs, or pull-ups on gates that are active low, hold the gates off. Call after the clocks
 * of the ports are on.
 */
void pins_init(void);

/*
 * The number of pins; whether a pin has the mode, the function and the resistor that pins_init()
 * gave it; its name, such as "PA8". pin: below pins_count(). Context: background.
 */
uint32_t pins_count(void);
bool pins_hold(uint32_t pin);
const char *pins_name(uint32_t pin);

/*
 * Turns the gate pins into inputs. The resistors hold the gates off, whatever the timer does. It is
 * the second way to open the gates; the first one is the timer's main output enable. Context:
 * background or NMI.
 */
void pins_release_gates(void);

#endif
