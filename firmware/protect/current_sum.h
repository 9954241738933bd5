/* SPDX-License-Identifier: MIT */
/*
 * The sum of the three phase currents, which is zero in a motor whose star point is not connected.
 * On a board that measures all three, a sum other than zero shows a wrong sensor or a current to
 * ground.
 *
 * CURRENT_SUM is found when
 *
 *     mean |i_a + i_b + i_c| > sum_max + sum_share · mean (|i_a| + |i_b| + |i_c|)
 *
 * The means are over a window of 2^mean_shift supervision periods, about 64 ms, and over at most
 * CURRENT_SUM_SAMPLES_MAX samples.
 *
 * The zero of the sum is measured during the offset calibration of the sensors. Pure, total within
 * the ranges; background only.
 */
#ifndef CURRENT_SUM_H
#define CURRENT_SUM_H

#include "fault.h"
#include "supervision.h"

#include <stdbool.h>
#include <stdint.h>

#define CURRENT_SUM_SAMPLES_MAX (4096U)

typedef struct {
    int32_t zero_sum; /* sum of the samples without current, Q15 of I_b */
    /* number of samples in zero_sum, 0…CURRENT_SUM_SAMPLES_MAX; 0: the zero is not known */
    int32_t zeros;
    uint32_t samples; /* samples in this window */
    uint32_t sum;     /* sum of |i_a + i_b + i_c| in this window, Q15 of I_b */
    uint32_t flowing; /* sum of |i_a| + |i_b| + |i_c| in this window, Q15 of I_b */
} current_sum_t;

/* Forgets the zero. Call before the zeros of the sensors are measured. */
void current_sum_reset(current_sum_t *state);

/* Forgets the window. Call while no current is judged. */
void current_sum_begin(current_sum_t *state);

/*
 * Adds a sample to the zero of the sum. Call while no current flows. sum: as in current_sum_in_t.
 */
void current_sum_zero(current_sum_t *state, int32_t sum);

typedef struct {
    int32_t a; /* phase currents, Q15 of I_b, ±16384 */
    int32_t b;
    /*
     * sum of all three as converted, not corrected by the zeros of the sensors, Q15 of I_b, ±2^17
     */
    int32_t sum;
} current_sum_in_t;

/* Adds a sample while the current is controlled. ends: the time of the window is over. */
fault_id_t current_sum_step(current_sum_t *state, const supervision_cfg_t *cfg,
                            const current_sum_in_t *in, bool ends, fault_t *fault);

#endif
