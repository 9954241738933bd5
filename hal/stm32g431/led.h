/* SPDX-License-Identifier: MIT */
/*
 * The status LED, PC6: on while the drive runs, slow blinking when it is ready, fast after a fault.
 */
#ifndef LED_H
#define LED_H

#include "drive.h"

#include <stdint.h>

/* `ticks` counts control ticks. Context: background. */
void led_show(drive_state_t state, uint32_t ticks);

#endif
