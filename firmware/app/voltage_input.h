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

#include "hal.h"
#include "input_cfg.h"
#include "input_signal.h"

#include <stdint.h>

typedef struct {
    int32_t smooth_q30;  /* output of the low-pass, 0…2^30 */
    uint32_t tick;       /* of the last reading */
    uint8_t conversions; /* hal_inputs_t.conversions that were taken */
} voltage_input_t;

/*
 * Tells the signal of the throttle once a conversion; a conversion that was taken before tells
 * nothing, so a converter that stands still is silent. A throttle that the board does not have is
 * bad in each call. Call at most once a tick.
 *
 * inputs->throttle: 0…2^(15 − shift) − 1, or HAL_NO_THROTTLE; shift: 0…7, from counts to Q15.
 */
void voltage_input_take(voltage_input_t *voltage, const hal_inputs_t *inputs, uint32_t shift,
                        const input_cfg_t *cfg, input_signal_t *signal, uint32_t tick);

#endif
