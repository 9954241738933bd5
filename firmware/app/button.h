/* SPDX-License-Identifier: MIT */
/*
 * A push button: pressed or not once it has been so for BUTTON_US.
 *
 * Pure functions on their state. Time is in control ticks. Context: background.
 */
#ifndef BUTTON_H
#define BUTTON_H

#include <stdbool.h>
#include <stdint.h>

#define BUTTON_US (20000U)

typedef struct {
    bool raw;       /* level of the last pass */
    bool pressed;   /* debounced */
    uint32_t since; /* tick in which `raw` has changed */
} button_t;

/*
 * Takes the level of this pass; call once a tick or less often. bounce_ticks: BUTTON_US in ticks.
 * Returns true in the pass in which the button becomes pressed.
 */
bool button_step(button_t *button, bool raw, uint32_t tick, uint32_t bounce_ticks);

#endif
