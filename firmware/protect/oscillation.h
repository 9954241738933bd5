/* SPDX-License-Identifier: MIT */
/*
 * Oscillation: finds a swing of the torque current that persists while the commanded motion does
 * not change. A speed loop that is too fast, a wrong dead time or an elastic shaft can cause one.
 *
 * A half-wave is the change of i_q* from one turning point to the next. A turning point is found
 * when i_q* has come back from its extreme by twice the amplitude limit, or by a quarter of the
 * last half-wave if that is more. So ripple does not cut a large swing into pieces. Half-waves form
 * a run while each is about as long as the last one of its direction, and at least half as high as
 * the highest one of the run. A run of `halves_max` half-waves is a swing.
 *
 * A transient dies out earlier: with the damping ζ each half-wave is lower than the one before by
 * the factor exp(−πζ/√(1−ζ²)), so a swing that is found has ζ < ln 2/(π·(halves_max − 1)). To
 * continue a run a half-wave needs two slow periods at least, because noise mostly turns after one.
 * Each change of the commanded motion ends a run, so nothing is found on a ramp.
 *
 * Currents Q15 of I_b, speeds step_t. Pure, total within the ranges; control interrupt only, once
 * per slow period.
 */
#ifndef OSCILLATION_H
#define OSCILLATION_H

#include "fault.h"
#include "fx.h"

#include <stdbool.h>
#include <stdint.h>

/* Reaction to a swing. */
typedef enum {
    OSCILLATION_ACT_NONE = 0, /* nothing is watched */
    /* lower the bandwidth of the speed loop; a fault if a swing is found again */
    OSCILLATION_ACT_LOWER,
    OSCILLATION_ACT_FAULT
} oscillation_act_t;

typedef struct {
    uint32_t act;        /* oscillation_act_t */
    uint32_t halves_max; /* a run of this many half-waves is a swing, 4…1000 */
    /*
     * largest number of slow periods from one turning point until the next one is found; more end a
     * run, 2…60000
     */
    uint32_t periods_max;
    /*
     * period of the oscillation at which the speed loop has a phase lag of 180°, 1/16 slow period,
     * 1…10^6; only the diagnosis of a swing uses it
     */
    uint32_t lag_periods_q4;
    int32_t amplitude_max; /* limit of the amplitude of i_q*, 1…16383 */
} oscillation_cfg_t;

typedef struct {
    uint32_t now;  /* count of slow periods, wraps */
    step_t motion; /* last commanded motion */
    bool falls;    /* true: i_q* falls in the present half-wave */
    /* largest or smallest i_q* since the last turning point, in the direction of `falls` */
    int32_t extreme;
    uint32_t at; /* `now` at that extreme */
    /* i_q* has turned when it has come back from the extreme by this much */
    int32_t back;
    int32_t turned;        /* i_q* at the last turning point */
    uint32_t since;        /* `now` at the last turning point */
    uint32_t periods_up;   /* slow periods of the last rising half-wave */
    uint32_t periods_down; /* slow periods of the last falling half-wave */
    int32_t highest;       /* height of the highest half-wave of the run */
    uint32_t halves;       /* half-waves in the run */
    uint32_t begun;        /* `now` at the beginning of the run */
    /*
     * slow periods that the halves_max half-waves of the last swing took; 0: no swing since the
     * start
     */
    uint32_t span;
} oscillation_t;

typedef struct {
    /*
     * commanded motion: in speed control the speed reference, in position control the speed of the
     * profile, in torque control the torque reference; ±2^29
     */
    step_t motion;
    int32_t current; /* i_q*, ±16384 */
} oscillation_in_t;

/* Forget all half-waves and the last swing. Call at a start. */
void oscillation_reset(oscillation_t *state);

/*
 * One slow period in RUN. Finds OSCILLATION when there is a swing; value and limit are amplitudes.
 * After that a new run begins.
 */
fault_id_t oscillation_step(oscillation_t *state, const oscillation_cfg_t *cfg,
                            const oscillation_in_t *in, fault_t *fault);

#endif
