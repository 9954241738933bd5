/* SPDX-License-Identifier: MIT */
/*
 * Speed and position control, called at the slow rate (every N-th control tick).
 *
 * Speed: the target is ramped; a PI and an acceleration feed-forward turn the reference into i_q*.
 * Position: a profile with limited speed, acceleration and deceleration runs to the target; the speed
 * reference is the profile's speed plus a gain times the position lag.
 *
 * Speeds are step_t (2^32 = one electrical turn a control tick), positions Q32 electrical turns in 64
 * bits, currents Q15 of I_b. Pure, total; call from the control interrupt.
 */
#ifndef MOTION_LOOP_H
#define MOTION_LOOP_H

#include "fx.h"
#include "pi.h"

#include <stdint.h>

typedef struct {
    pi_cfg_t pi;      /* speed error Q15 of 2·Ω_b in, i_q* out; paper B (28)–(30) */
    step_t ramp;      /* largest change of the reference in a slow period, > 0 */
    step_t speed_max; /* |reference| is kept within, ≤ 2^29 */
    /* i_q for an acceleration: change · inertia / 2^(16 + inertia_shift − inertia_lift) */
    int32_t inertia;
    uint32_t inertia_shift; /* 0…30 */
    uint32_t inertia_lift;  /* 0…14: where a step of speed takes more than half an LSB of current */
    uint32_t error_shift;   /* Q15 of 2·Ω_b = step >> error_shift, 1…17 */
} speed_loop_cfg_t;

typedef struct {
    pi_t pi;
    step_t reference; /* the speed asked for in the last slow period, after all limits */
} speed_loop_t;

typedef struct {
    step_t ramp;             /* acceleration: change of the profile speed in a slow period, > 0 */
    step_t speed_max;        /* profile speed limit, 1…2^29 */
    int32_t braking_inverse; /* 2^30 / B, B = braking distance from speed_max, 2^13…2^14 units */
    int32_t softness_q15;    /* c below: braking fades out under c·speed_max, 0…12288 */
    int32_t gain;            /* speed = (lag, Q16 turns) · gain / 2^gain_shift, 0…32767 */
    uint32_t gain_shift;     /* 0…30 */
    uint32_t distance_shift; /* one distance unit = 2^distance_shift of Q32 turns, 8…48 */
} position_loop_cfg_t;

typedef struct {
    int64_t profile_q32;  /* where the profile is */
    step_t profile_speed; /* how fast it goes */
} position_loop_t;

/* Where i_q* may go, lower ≤ 0 ≤ upper, Q15 of I_b, ±16384. */
typedef struct {
    int32_t lower;
    int32_t upper;
} torque_range_t;

/* Start from the present speed with no current demand: no bump. */
void speed_loop_reset(speed_loop_t *loop, step_t speed);

/* The reference one slow period further on its ramp to `target`. */
step_t speed_loop_ramp(const speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t target);

/* i_q for the acceleration from the last reference to this one, within `range`. Takes it over. */
int32_t speed_loop_accelerate(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                              torque_range_t range);

/* The next output with zero error and a steady reference is `current` (Q15 of I_b, ±32767). */
void speed_loop_start(speed_loop_t *loop, step_t reference, int32_t current);

/*
 * One slow period: follow `reference` (limited to ±speed_max), given the measured speed.
 * Returns i_q*, saturated to `range` and 16383.
 */
int32_t speed_loop_step(speed_loop_t *loop, const speed_loop_cfg_t *cfg, step_t reference,
                        step_t measured, torque_range_t range);

/* Start the profile at the present position and speed, so that a moving rotor brakes along it. */
void position_loop_reset(position_loop_t *loop, int64_t position_q32, step_t speed);

/*
 * One slow period of `ticks` control ticks, 6…100. The profile brakes along
 *     v(d) = speed_max·(√(d/B + c²) − c),
 * d the distance left: its deceleration stays below speed_max²/(2B) and fades out linearly at the end.
 * Positions wrap; a distance is the shorter way, so it is exact for less than 2^31 turns. Returns the
 * speed reference: the profile's, and by at most speed_max more what takes the lag back.
 */
step_t position_loop_step(position_loop_t *loop, const position_loop_cfg_t *cfg, int64_t target_q32,
                          int64_t measured_q32, uint32_t ticks);

#endif
