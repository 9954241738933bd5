/* SPDX-License-Identifier: MIT */
/*
 * The sum of the three phase currents, which is zero in a motor whose star point is not connected.
 * On a board that measures all three it shows a sensor that is wrong, and a current to ground.
 *
 * Means over a window of 2^mean_shift supervision periods, some 64 ms, and over at most
 * CURRENT_SUM_SAMPLES_MAX samples: CURRENT_SUM where
 *
 *     mean |i_a + i_b + i_c| > sum_max + sum_share · mean (|i_a| + |i_b| + |i_c|)
 *
 * The zero of the sum is measured while that of the sensors is. Pure, total within the ranges;
 * background only.
 */
#ifndef CURRENT_SUM_H
#define CURRENT_SUM_H

#include "fault.h"
#include "supervision.h"

#include <stdbool.h>
#include <stdint.h>

#define CURRENT_SUM_SAMPLES_MAX (4096U)

typedef struct {
    int32_t zero_sum; /* of the sums without current, Q15 of I_b, and … */
    int32_t zeros;    /* … how many, 0…CURRENT_SUM_SAMPLES_MAX; 0: the zero is not known */
    uint32_t samples; /* of this window */
    uint32_t sum;     /* of |i_a + i_b + i_c| in it, Q15 of I_b */
    uint32_t flowing; /* of |i_a| + |i_b| + |i_c| */
} current_sum_t;

/* Forgets the zero. Call when the sensors' own are about to be measured. */
void current_sum_reset(current_sum_t *state);

/* Forgets the window. Call where no current is judged. */
void current_sum_begin(current_sum_t *state);

/* One sample of the zero: the sum without current, as below. */
void current_sum_zero(current_sum_t *state, int32_t sum);

typedef struct {
    int32_t a; /* phase currents, Q15 of I_b, ±16384 */
    int32_t b;
    /* of all three as they are converted, with what their zeros are off: Q15 of I_b, ±2^17 */
    int32_t sum;
} current_sum_in_t;

/* One sample, while the current is controlled. ends: the window's time is over. */
fault_id_t current_sum_step(current_sum_t *state, const supervision_cfg_t *cfg,
                            const current_sum_in_t *in, bool ends, fault_t *fault);

#endif
