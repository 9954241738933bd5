/* SPDX-License-Identifier: MIT */
/*
 * Current reference: chooses i_d* and i_q* for a torque, at the present speed and bus voltage. No
 * other module chooses them.
 *
 *     Te = 1.5·P·ψ·i_q,  ψ = φ + (L_d − L_q)·i_d           the flux that i_q turns into torque
 *
 * The functions, in the order in which a slow period calls them:
 *     current_reference_d         i_d*
 *     current_reference_weakened  near the voltage circle: i_d*, and the largest |i_q*| with this
 * i_d* current_reference_range     the range of i_q* that i_d* and the voltage leave
 *     current_reference_flux      ψ at i_d*, in the model in force
 *     current_reference_q         i_q* of a torque; current_reference_torque is its inverse
 *
 * Four sources decide i_d*:
 *     imposed     while RUN hands back to an imposed vector: the current of that vector. `least`
 *                 and `MTPA` do not count then
 *     least       keeps the vector so large that not all legs switch near the zero crossing of
 *                 their current, where the effect of their dead time is not known
 *     MTPA        the i_d at which a current gives its largest torque, where L_q > L_d:
 *                 i_d = −i_q² / (c + √(c² + i_q²)),  c = φ / (2·(L_q − L_d))
 *     weakening   the largest i_d* that the voltage allows (weakening.h)
 * i_d* is the larger one of `least` and `MTPA`, and at most the i_d* that weakening allows. The
 * first three follow a slope. Weakening is faster: where the voltage is short, the current control
 * has no voltage left to follow a slope with.
 *
 * Without current regulators (voltage_drive.h) both references are 0. There the phase compensator
 * holds i_d at 0.
 *
 * Units: currents Q15 of I_b; voltages Q15 of U_b; flux Q13 of U_b/Ω_b; torque Q28 of T_b =
 * 1.5·P·U_b·I_b/Ω_b; speeds step_t. Pure, total within the ranges. Control interrupt, once per slow
 * period.
 */
#ifndef CURRENT_REFERENCE_H
#define CURRENT_REFERENCE_H

#include "current_loop.h"
#include "fx.h"
#include "motion_loop.h"
#include "transforms.h"
#include "weakening.h"

#include <stdbool.h>
#include <stdint.h>

/* Value of `reach` where the voltage does not limit i_q*. */
#define CURRENT_REFERENCE_ALL (16384)
/* Largest torque, Q28: largest current times largest flux. */
#define CURRENT_REFERENCE_TORQUE_MAX (536854528) /* 16384 · 32767 */

typedef struct {
    /* |i_d*| + |i_q*| / 2^floor_shift is at least this where the voltage allows it, 0…16384 */
    int32_t floor;
    uint32_t floor_shift; /* 0…1 */
    int32_t slope;        /* i_d* rises by at most this in a tick, 1…16384 */
    /* i_d* falls by at most this in a tick while it is below `floor`, 1…16384 */
    int32_t slope_down;
    uint32_t most_torque; /* 1: MTPA is on; 0: MTPA is off */
    /* largest −i_d* that weakening asks for, 0…16384; 0: it asks for no i_d* below 0 */
    int32_t deepest;
} current_reference_cfg_t;

/* Operating point: input of current_reference_d(). */
typedef struct {
    dq_t present;       /* i_d*, i_q* of the last slow period, ±16384 */
    step_t speed;       /* speed reference, ±2^30 */
    step_t floor_speed; /* `floor` counts while |speed| is at least this, ≥ 0 */
    /* current of the vector that RUN hands back to now, 0…16384; 0: RUN does not hand back */
    int32_t imposed;
    int32_t ticks; /* control ticks in a slow period, 6…100 */
} current_reference_in_t;

/* i_d*, and the limit of |i_q*| with this i_d*. */
typedef struct {
    int32_t d;     /* i_d*, ±16384 */
    int32_t reach; /* largest |i_q*| that the voltage allows, 0…16384 */
} current_reference_t;

/*
 * Returns the next i_d*; the limit by the voltage is not applied yet. i_d* rises by at most `slope`
 * a tick. Below `floor` it falls by at most `slope_down` a tick, above `floor` by at most the
 * larger one of `slope` and `slope_down`. The fall below `floor` is slow, because the next torque
 * may end as soon as the last one did. The fall above `floor` is fast: a positive i_d takes flux
 * from a salient machine, and this flux must be back before the torque needs it. model: the model
 * in force. At most two divisions and a root.
 */
int32_t current_reference_d(const current_reference_cfg_t *cfg, const current_loop_cfg_t *model,
                            const current_reference_in_t *in);

/*
 * Returns i_d* within the limit of the voltage, and the largest |i_q*| that the voltage then
 * leaves. Call it where weakening_follow_bus() is true. next_d: result of current_reference_d().
 */
current_reference_t current_reference_weakened(weakening_t *weakening, const weakening_in_t *in,
                                               int32_t next_d);

/*
 * Returns the part of `range` that is left for i_q*. `reach` limits it. If i_d* is below 0 or above
 * `floor`, the circle of radius current_max (0…16384) limits it too. An i_d* of 0…`floor` is too
 * small for the circle to matter. Rounded towards less current.
 */
torque_range_t current_reference_range(const current_reference_cfg_t *cfg, torque_range_t range,
                                       const current_reference_t *reference, int32_t current_max);

/* Returns ψ, Q13, 1…32767: rounded down and saturated. current_d: ±16384. */
int32_t current_reference_flux(const current_loop_cfg_t *model, int32_t current_d);

/* Returns Te of i_q at ψ (Q13, 1…32767), Q28, exact. current_q: ±16384. */
static inline int32_t current_reference_torque(int32_t current_q, int32_t flux_q13)
{
    return current_q * flux_q13;
}

/*
 * Returns the largest torque, Q28, of a current with the amplitude current_max (1…16384). MTPA is
 * used where it is on. Rounded down; the limit by the voltage is ignored. From any context.
 */
int32_t current_reference_torque_max(const current_reference_cfg_t *cfg,
                                     const current_loop_cfg_t *model, int32_t current_max);

/*
 * Returns i_q* of a torque (Q28, any) at ψ (Q13, 1…32767): rounded towards zero, saturated at
 * ±16384. One division.
 */
int32_t current_reference_q(int32_t torque_q28, int32_t flux_q13);

#endif
