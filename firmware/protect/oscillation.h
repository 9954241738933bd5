/* SPDX-License-Identifier: MIT */
/*
 * Oscillation: finds a swing of the torque current that goes on while the motion asked for does not
 * change. A speed loop that is too fast, a wrong dead time or an elastic shaft can cause one.
 *
 * A half-wave is the way from one turning point of i_q* to the next. i_q* has turned when it has
 * come back from its extreme by twice the amplitude limit, or by a quarter of the last half-wave if
 * that is more. So ripple does not cut a large swing into pieces. Half-waves form a run while each
 * is about as long as the last one of its direction, and at least half as high as the highest of
 * the run. A run of `halves_max` is a swing.
 *
 * A transient dies out earlier: with the damping ζ each half-wave is lower than the one before by
 * the factor exp(−πζ/√(1−ζ²)), so a swing that is found has ζ < ln 2/(π·(halves_max − 1)). To
 * continue a run a half-wave needs two slow periods at least, because noise mostly turns after one.
 * Each change of the motion asked for ends a run, so nothing is found on a ramp.
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
    uint32_t halves_max; /* half-waves in a run that are a swing, 4…1000 */
    /* slow periods from a turning point until the next is seen; more end a run, 2…60000 */
    uint32_t periods_max;
    /*
     * period at which the speed loop lags by half a turn, sixteenths of a slow period, 1…10^6; only
     * the diagnosis of a swing uses it
     */
    uint32_t lag_periods_q4;
    int32_t amplitude_max; /* of i_q*, 1…16383 */
} oscillation_cfg_t;

typedef struct {
    uint32_t now;          /* slow periods, wraps */
    step_t motion;         /* last motion asked for */
    bool falls;            /* direction of the half-wave under way */
    int32_t extreme;       /* the furthest i_q* since the last turning point … */
    uint32_t at;           /* … and when */
    int32_t back;          /* how far it has to come back from there to have turned */
    int32_t turned;        /* i_q* at the last turning point … */
    uint32_t since;        /* … and when */
    uint32_t periods_up;   /* of the last rising half-wave … */
    uint32_t periods_down; /* … and of the last falling one */
    int32_t highest;       /* highest half-wave of the run */
    uint32_t halves;       /* half-waves in the run … */
    uint32_t begun;        /* … and when it began */
    /*
     * slow periods that the halves_max half-waves of the last swing took; 0: none was found since
     * the start
     */
    uint32_t span;
} oscillation_t;

typedef struct {
    /* asked for: the reference of the speed, in position control the profile's speed; ±2^29 */
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
