/* SPDX-License-Identifier: MIT */
/*
 * The status LED, PC6: on in RUN, fast blinking in FAULT, slow blinking in any other state. It is
 * off when the start has failed: then no tick gives it a time to blink in.
 */
#ifndef LED_H
#define LED_H

#include "drive.h"

#include <stdint.h>

/* `ticks` counts control ticks. Context: background. */
void led_show(drive_state_t state, uint32_t ticks);

#endif
