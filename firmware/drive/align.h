/* SPDX-License-Identifier: MIT */
/*
 * Alignment: pull a standing rotor to a known angle with an imposed current, and measure R and L with it.
 *
 *   PULL          the current rises fast to its level while its vector turns by half a turn, then rests: whatever
 *                 the rotor's angle, it is caught by the turning vector and comes to rest on it
 *   MEASURE_HIGH  mean voltage and current
 *   STEP          a voltage step for a few ticks lowers the current: its change gives L_d
 *   SETTLE        at the lower level
 *   MEASURE_LOW   mean voltage and current: the difference to the first gives R, without the offset that dead
 *                 time and device drop leave
 *
 * Why a turning vector: from a fixed one a rotor opposite to it does not start, and one just before it swings back
 * by half a turn and more under load; the vector that moves on in the wanted direction meets the rotor.
 *
 * The current vector lies on the d axis of a frame, which the caller turns by frame_speed. Pure, total; one step a
 * control tick.
 */
#ifndef ALIGN_H
#define ALIGN_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t current_high; /* Q15 of I_b, 1…16384 */
    int32_t current_low;  /* of the second measurement, 0…current_high − 1 */
    int32_t slope;        /* change of the current in a tick, Q15 of I_b, 1…16384 */
    step_t
        sweep_speed; /* of the vector while it turns, 1…2^29, within the observer's speed_limit */
    uint32_t sweep_ticks;  /* half a turn takes so long, 1…pull_ticks */
    uint32_t pull_ticks;   /* the whole PULL, 1…2^20 */
    uint32_t settle_ticks; /* 1…2^20 */
    uint32_t measure_log2; /* the means are over 2^n ticks, 6…16 */
    uint32_t step_ticks;   /* 2…16 */
    int32_t step_voltage;  /* Q15 of U_b, 1…32767 */
    int32_t
        step_fall; /* it alone, on the nominal L_d, lowers the current so far, Q15 of I_b, 1…16384 */
    int32_t step_drop_q14; /* R·t/(2·L_d): the falling current's own part in it, 0…8192 */
} align_cfg_t;

typedef enum {
    ALIGN_PULL = 0,
    ALIGN_MEASURE_HIGH,
    ALIGN_STEP,
    ALIGN_SETTLE,
    ALIGN_MEASURE_LOW,
    ALIGN_DONE
} align_phase_t;

/* Sum of the samples while measuring, then 64 times the mean, Q15 of the bases. */
typedef struct {
    int32_t voltage;
    int32_t current;
} align_point_t;

typedef struct {
    align_phase_t phase;
    uint32_t tick;       /* of the phase */
    bool backwards;      /* the vector turns from β to α */
    int32_t current_ref; /* i_d* */
    step_t frame_speed;
    int32_t step_start; /* i_d before the step acts */
    int32_t step_fall;  /* by how much the step has lowered it */
    align_point_t high;
    align_point_t low;
} align_t;

/* Begin. backwards: the drive will turn that way. */
void align_reset(align_t *align, bool backwards);

/* Begin with the measurements: the rotor has come to rest on a vector of current_ref already. */
void align_reset_held(align_t *align, const align_cfg_t *cfg, int32_t current_ref);

/*
 * One tick. current: measured i_d; voltage: v_d asked for in the last tick; Q15, ±32767. Sets current_ref and
 * frame_speed for this tick.
 */
void align_step(align_t *align, const align_cfg_t *cfg, int32_t current, int32_t voltage);

#define ALIGN_UNKNOWN (-1)

/*
 * The current control rests in this tick: v_d stays, lowered by step_voltage once in the first tick of STEP. True from
 * the tick that ends MEASURE_HIGH on.
 */
bool align_steps_voltage(const align_t *align, const align_cfg_t *cfg);

/*
 * What was measured, when DONE: R in U_b/I_b, Q13, 0…32767, and the ratio L_d / nominal in Q14, 1…32767, to first
 * order in the nominal R·t/(2·L_d); ALIGN_UNKNOWN where it cannot be told. One division each.
 */
int32_t align_resistance_q13(const align_t *align);
int32_t align_inductance_q14(const align_t *align, const align_cfg_t *cfg);

#endif
