/* SPDX-License-Identifier: MIT */
/*
 * Pulses of the command pin. RM0440 29.4.6 (input capture), 12, 13.
 *
 * Timer 2 counts 0.1 µs. One of its channels captures the rising edges of the pin and another one
 * the falling edges. The DMA moves the captures into two rings, without the core. The input's
 * filter takes what is shorter than 188 ns away, and delays both edges alike.
 */
#ifndef PULSES_H
#define PULSES_H

#include "hal.h"

#include <stdbool.h>
#include <stdint.h>

/* Slots of a ring. One less can be filled between two calls of pulses_take(). */
#define PULSES_SLOTS (48U)

/* BOARD_CLOCK_HZ / HAL_PULSE_HZ, less one. */
#define PULSES_PRESCALER (16U)

/* The rings, written by the DMA. They have no use in an image without a command pin. */
extern volatile uint32_t pulses_rises[PULSES_SLOTS];
extern volatile uint32_t pulses_falls[PULSES_SLOTS];

/* Their addresses, for the registers of the DMA. */
#define PULSES_OF_RISES ((uint32_t)pulses_rises)
#define PULSES_OF_FALLS ((uint32_t)pulses_falls)

/* Starts the timer. Call once, after pins_init(). */
void pulses_init(void);

/* As hal_pulse() and hal_pulse_now(). */
bool pulses_take(hal_pulse_t *pulse);
uint32_t pulses_now(void);

#endif
