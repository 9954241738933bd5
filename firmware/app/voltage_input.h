/* SPDX-License-Identifier: MIT */
/*
 * A voltage as the reading: of a potentiometer, or of another sensor of a throttle.
 *
 * The reading is the count in Q15 of the converter's full scale, behind a first-order low-pass. A
 * count outside the range of the input is bad, and the low-pass leaves it out: with a margin at
 * both ends of its travel, an open or shorted wire of a potentiometer reads like that.
 *
 * Pure functions on their state. Context: background.
 */
#ifndef VOLTAGE_INPUT_H
#define VOLTAGE_INPUT_H

#include "input_cfg.h"
#include "input_signal.h"

#include <stdint.h>

typedef struct {
    int32_t smooth_q30; /* output of the low-pass, 0…2^30 */
} voltage_input_t;

/*
 * Takes the present count and tells the signal of it. Call at most once a tick.
 *
 * count: 0…2^(15 − shift) − 1, or HAL_NO_THROTTLE; shift: 0…7, from counts to Q15; ticks: passed
 * since the last call, 1 or more.
 */
void voltage_input_take(voltage_input_t *voltage, uint32_t count, uint32_t shift,
                        const input_cfg_t *cfg, input_signal_t *signal, uint32_t tick,
                        uint32_t ticks);

#endif
