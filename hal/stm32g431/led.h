/* SPDX-License-Identifier: MIT */
/*
 * The status LED, PC6: on in RUN, fast blinking in FAULT, slow blinking in any other state.
 */
#ifndef LED_H
#define LED_H

#include "drive.h"

#include <stdint.h>

/* `ticks` counts control ticks. Context: background. */
void led_show(drive_state_t state, uint32_t ticks);

#endif
