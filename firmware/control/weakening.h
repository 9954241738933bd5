/* SPDX-License-Identifier: MIT */
/*
 * Field weakening: limits i_d* to the values that the bus voltage allows at the present speed.
 *
 * The voltage that the stator flux induces is limited to E:
 *
 *     (X_q·i_q)² + (ω·φ + X_d·i_d)² ≤ E²,  X = ω·L               the voltage ellipse
 *
 * So for a given i_q, i_d is at most
 *
 *     upper = (√(E² − (X_q·i_q)²) − ω·φ) / X_d
 *
 * E is the lowest recent radius of the voltage circle, in the valley of the bus ripple, less 3/256
 * of it as a reserve for the current control, less the voltage that the resistance takes along the
 * demand, R·(i·v)/|v|. While `upper` decides i_d*, an integral corrects E for errors of the model:
 * E grows by the voltage that the mean demand leaves unused, and falls by the voltage that the
 * demand lacks as long as `upper` is above `lower`. The integral is a voltage, so one gain suits
 * every motor.
 *
 * An i_d below `lower` is of no use. Three limits end the useful range. `lower` is the highest i_d
 * of the three:
 *     the current         circle and ellipse meet. With y = −i_d/I, x = X·I:
 *                         y = c / (b + √(b² + a·c)),
 *                         a = x_q² − x_d²,  b = x_d·ω·φ,  c = (ω·φ)² + x_q² − E²
 *     the torque (MTPV)   the point of the ellipse with the largest torque. With Δx = x_q − x_d:
 *                         y = (ω·φ + 2·Δx·E² / (x_q·ω·φ + √((x_q·ω·φ)² + 8·Δx²·E²))) / x_d
 *     the magnets         `deepest` of the configuration
 * Where the torque or the magnets decide `lower`, `reach` is the i_q of the ellipse at `lower`.
 *
 * Units: currents Q15 of I_b; voltages Q15 of U_b; the model has the formats of current_loop.h.
 * Pure, total within the ranges. Control interrupt, once per slow period.
 */
#ifndef WEAKENING_H
#define WEAKENING_H

#include "current_loop.h"
#include "fx.h"
#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t voltage; /* the integral, a part of E, ±8192 */
    int32_t valley;  /* the lowest recent radius of the voltage circle, 0…32767 */
    uint32_t check;  /* check word of voltage and valley, see weakening_holds() */
    bool acts;       /* the voltage limits i_d*, or i_d* has not yet returned from such a limit */
} weakening_t;

/* Operating point: input of weakening_step(). */
typedef struct {
    const current_loop_cfg_t *model;
    int32_t speed_q15;   /* |ω|, Q15 of Ω_b, 0…32767 */
    dq_t reference;      /* i* of the last slow period, ±16384 */
    dq_t current;        /* measured current, ±16384 */
    dq_t voltage;        /* mean of the demanded voltage, ±32768 */
    int32_t current_max; /* radius of the current circle, 1…16384 */
    int32_t deepest;     /* largest −i_d* that weakening asks for, 0…16384 */
} weakening_in_t;

/* Limits that the voltage sets. */
typedef struct {
    int32_t upper; /* largest i_d*, ±16384 */
    /* an i_d* below this is of no use, −16384…0; −16384 where `upper` does not decide */
    int32_t lower;
    int32_t reach; /* largest |i_q*|, 0…16384 */
} weakening_limits_t;

void weakening_reset(weakening_t *weakening);

/*
 * Returns true while voltage and valley are as the functions here have written them. Returns false
 * when a bit has flipped by itself in one of them or in the check word, and stays false until the
 * reset.
 */
bool weakening_holds(const weakening_t *weakening);

/*
 * Once a slow period. voltage_max: radius of the circle at this bus, 0…32767. Returns true when the
 * voltage may decide i_d*: `acts` is set, or the demand (±32768) is above 15/16 of the lowest
 * recent radius. Otherwise the integral moves towards 0, which it reaches within some 100 slow
 * periods.
 */
bool weakening_follow_bus(weakening_t *weakening, dq_t demand, int32_t voltage_max);

/*
 * One slow period near the circle. wanted: i_d* without the limit of the voltage. Rounded towards
 * less voltage, saturated. Five square roots and seven divisions at most.
 */
weakening_limits_t weakening_step(weakening_t *weakening, const weakening_in_t *in, int32_t wanted);

#endif
