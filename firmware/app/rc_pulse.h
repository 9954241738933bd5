/* SPDX-License-Identifier: MIT */
/*
 * Servo pulses of a receiver: the width of a pulse, some 1 to 2 ms, is the reading. Pulses come
 * with 50 to 490 Hz.
 *
 * A pulse is good when its width is within the range of the input and its rising edge comes
 * RC_PULSE_PERIOD_MIN to RC_PULSE_PERIOD_MAX after that of the pulse before it, good or bad, and
 * within 1/4 of the period before. So a pulse that a glitch has split is no pulse, a glitch spoils
 * the pulses around it, and pulses at random times are bad. INPUT_SIGNAL_BAD bad pulses in a row
 * lose the signal.
 *
 * Pure functions on their state. Context: background.
 */
#ifndef RC_PULSE_H
#define RC_PULSE_H

#include "hal.h"
#include "input_cfg.h"
#include "input_signal.h"

#include <stdbool.h>
#include <stdint.h>

#define RC_PULSE_PERIOD_MIN (HAL_PULSE_HZ / 526U) /* 1.9 ms: 490 Hz and 7 % */
#define RC_PULSE_PERIOD_MAX (HAL_PULSE_HZ / 40U)  /* 25 ms: 50 Hz less 20 % */

typedef struct {
    uint32_t start;  /* of the last pulse, 1/HAL_PULSE_HZ */
    uint32_t period; /* to it from the one before it; 0: there was none in range */
} rc_pulse_t;

/* Takes the next pulse of the pin and tells the signal of it. tick: the present tick. */
void rc_pulse_take(rc_pulse_t *rc, const hal_pulse_t *pulse, const input_cfg_t *cfg,
                   input_signal_t *signal, uint32_t tick);

#endif
