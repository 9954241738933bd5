/* SPDX-License-Identifier: MIT */
/*
 * Current reference: which i_d*, i_q* make a torque at this speed and on this bus. Only this module
 * decides that.
 *
 *     Te = 1.5·P·ψ·i_q,  ψ = φ + (L_d − L_q)·i_d           the flux that i_q turns into torque
 *
 * In the order of a slow period:
 *     current_reference_d         i_d*
 *     current_reference_weakened  near the voltage circle: i_d*, and the largest |i_q*| with it
 *     current_reference_range     the range of i_q* that these two leave
 *     current_reference_flux      ψ at i_d*, in the model in force
 *     current_reference_q         i_q* of a torque; current_reference_torque is the way back
 *
 * Four sources decide i_d*:
 *     imposed     the current of the imposed vector, where RUN hands back to it. It alone counts
 *                 then.
 *     least       keeps the vector so large that not all legs switch near the zero crossing of
 *                 their current, where the effect of their dead time is not known
 *     MTPA        the largest torque of a current, where L_q > L_d:
 *                 i_d = −i_q² / (c + √(c² + i_q²)),  c = φ / (2·(L_q − L_d))
 *     weakening   the largest i_d* that the voltage allows (weakening.h)
 * i_d* is the larger one of least current and MTPA, and not more than weakening allows. The first
 * three follow a slope. Weakening is faster: where the voltage is short, the current control has no
 * voltage left to follow a slope with.
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

/* `reach` where the voltage does not limit i_q*. */
#define CURRENT_REFERENCE_ALL (16384)
/* Torque of the largest current and flux. */
#define CURRENT_REFERENCE_TORQUE_MAX (536854528) /* 16384 · 32767 */

typedef struct {
    /* |i_d*| + |i_q*| / 2^floor_shift is at least this where the voltage allows it, 0…16384 */
    int32_t floor;
    uint32_t floor_shift; /* 0…1 */
    int32_t slope;        /* i_d* rises by this in a tick, 1…16384 */
    int32_t slope_down;   /* and falls by this below `floor`, 1…16384 */
    uint32_t most_torque; /* 1: MTPA; 0: not */
    int32_t deepest;      /* weakening asks for −i_d* up to this, 0…16384; 0: for none */
} current_reference_cfg_t;

/* Operating point. */
typedef struct {
    dq_t present;       /* i_d*, i_q* of the last slow period, ±16384 */
    step_t speed;       /* asked for, ±2^30 */
    step_t floor_speed; /* the least current counts from this speed on, ≥ 0 */
    /* i_d* of the imposed vector that RUN goes back to now, 0…16384; 0: it does not */
    int32_t imposed;
    int32_t ticks; /* of a slow period, 6…100 */
} current_reference_in_t;

/* What the voltage leaves. */
typedef struct {
    int32_t d;     /* i_d*, ±16384 */
    int32_t reach; /* |i_q*| at most, 0…16384 */
} current_reference_t;

/*
 * Returns the next i_d*, without the limit of the voltage. It rises by at most `slope` a tick. It
 * falls by at most `slope_down` a tick below `floor`, and by the larger one of both above. The fall
 * below `floor` is slow, because the next torque may end as soon as the last one. The fall above it
 * is fast, so that the flux that a positive i_d takes from a salient machine is back before its
 * torque needs it. model: in force. Two divisions and a root at most.
 */
int32_t current_reference_d(const current_reference_cfg_t *cfg, const current_loop_cfg_t *model,
                            const current_reference_in_t *in);

/*
 * Returns i_d* within the limit of the voltage, and the largest |i_q*| that is left. Call it where
 * the voltage may decide. next_d: from current_reference_d().
 */
current_reference_t current_reference_weakened(weakening_t *weakening, const weakening_in_t *in,
                                               int32_t next_d);

/*
 * Returns the part of `range` that is left for i_q*. `reach` limits it, and with an i_d* below 0 or
 * above `floor` also the circle of radius current_max (0…16384). An i_d* of 0…floor is small enough
 * to be left out of the circle. Rounded towards less current.
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
 * Returns the largest torque of a current of this amplitude (1…16384), Q28: with MTPA where it is
 * on. Rounded down; the limit of the voltage is ignored. From any context.
 */
int32_t current_reference_torque_max(const current_reference_cfg_t *cfg,
                                     const current_loop_cfg_t *model, int32_t current_max);

/*
 * Returns i_q* of a torque (Q28, any) at ψ (Q13, 1…32767): rounded towards zero, saturated at
 * ±16384. One division.
 */
int32_t current_reference_q(int32_t torque_q28, int32_t flux_q13);

#endif
