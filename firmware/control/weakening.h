/* SPDX-License-Identifier: MIT */
/*
 * Field weakening: which i_d* the voltage of this bus allows at this speed.
 *
 * The voltage that the stator flux induces is limited to E:
 *
 *     (X_q·i_q)² + (ω·φ + X_d·i_d)² ≤ E²,  X = ω·L               the voltage ellipse
 *
 * So for a given i_q, i_d is at most
 *
 *     upper = (√(E² − (X_q·i_q)²) − ω·φ) / X_d
 *
 * E is the voltage of the bus in the valley of its ripple, less 3/256 as a reserve of the current
 * control, less the voltage that the resistance takes along the demand, R·(i·v)/|v|. An integral
 * corrects E for errors of the model. While `upper` decides i_d*, E grows by the voltage that the
 * mean demand leaves of the bus. Above `lower` E sinks by the voltage that the demand lacks. The
 * integral is one of volts, so one gain suits every motor.
 *
 * An i_d below `lower` is of no use. Three limits end the useful range; the highest i_d of them is
 * `lower`:
 *     the current         circle and ellipse meet. With y = −i_d/I, x = X·I:
 *                         y = c / (b + √(b² + a·c)),
 *                         a = x_q² − x_d²,  b = x_d·ω·φ,  c = (ω·φ)² + x_q² − E²
 *     the torque (MTPV)   the point of the ellipse with the largest torque. With Δx = x_q − x_d:
 *                         y = (ω·φ + 2·Δx·E² / (x_q·ω·φ + √((x_q·ω·φ)² + 8·Δx²·E²))) / x_d
 *     the magnets         `deepest` of the configuration
 * Where one of the last two counts, `reach` is the i_q of the ellipse there.
 *
 * Units: currents Q15 of I_b; voltages Q15 of U_b; the model as current_loop.h has it.
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
    int32_t voltage; /* part of E from the integral, ±8192 */
    int32_t valley;  /* the lowest recent radius of the voltage circle, 0…32767 */
    uint32_t check;  /* check word of both: weakening_holds() */
    bool acts;       /* the voltage limits i_d*, or i_d* is on its way back */
} weakening_t;

/* Operating point. */
typedef struct {
    const current_loop_cfg_t *model;
    int32_t speed_q15;   /* |ω| of Ω_b, 0…32767 */
    dq_t reference;      /* i* of the last slow period, ±16384 */
    dq_t current;        /* that flows, ±16384 */
    dq_t voltage;        /* mean demand, ±32768 */
    int32_t current_max; /* radius of the current circle, 1…16384 */
    int32_t deepest;     /* −i_d* is at most this, 0…16384 */
} weakening_in_t;

/* What the voltage leaves. */
typedef struct {
    int32_t upper; /* i_d* at most, ±16384 */
    int32_t lower; /* a smaller i_d* is of no use, −16384…0; −16384 where `upper` does not decide */
    int32_t reach; /* |i_q*| at most, 0…16384 */
} weakening_limits_t;

void weakening_reset(weakening_t *weakening);

/*
 * Whether voltage and valley are as the functions here have written them. A bit that has flipped by
 * itself in one of them, or in the check word, makes it false, and it stays so until the reset.
 */
bool weakening_holds(const weakening_t *weakening);

/*
 * Once a slow period. voltage_max: radius of the circle at this bus, 0…32767. Returns whether the
 * voltage may decide i_d*: it does already, or the demand (±32768) is above 15/16 of the lowest
 * recent radius. If not, the integral goes back to 0 within some 100 slow periods.
 */
bool weakening_is_near(weakening_t *weakening, dq_t demand, int32_t voltage_max);

/*
 * One slow period near the circle. wanted: i_d* without the limit of the voltage. Rounded towards
 * less voltage, saturated. Five square roots and seven divisions at most.
 */
weakening_limits_t weakening_step(weakening_t *weakening, const weakening_in_t *in, int32_t wanted);

#endif
