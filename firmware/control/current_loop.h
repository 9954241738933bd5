/* SPDX-License-Identifier: MIT */
/*
 * Current control in the rotor frame: one PI per axis, decoupling, voltage limited to a circle.
 *
 *     v_d = PI_d(i_d* − i_d) + R·i_d* − ω·L_q·i_q
 *     v_q = PI_q(i_q* − i_q) + R·i_q* + ω·(L_d·i_d + φ)    motor equations (1), (2) of paper A
 *     √(v_d² + v_q²) ≤ v_limit
 * The d axis has priority, because it holds the flux: v_q gets the part of the circle that v_d
 * leaves. While the motor brakes (ω·i_q* < 0), the q axis has priority: if v_q were too small for
 * the EMF, the EMF would drive a current that nothing limits.
 *
 * Speed, reference and model change once a slow period. So current_loop_plan() computes their
 * products then, and a tick multiplies them by the measured current only.
 *
 * Currents Q15 of I_b, voltages Q15 of U_b, speed_q15: Q15 of the speed base Ω_b. Pure, total
 * within the ranges.
 */
#ifndef CURRENT_LOOP_H
#define CURRENT_LOOP_H

#include "fx.h"
#include "pi.h"
#include "transforms.h"

#include <stdint.h>

#define CURRENT_LOOP_GAIN_BITS (13U) /* fractional bits of the model's gains below: Q13 */

typedef struct {
    pi_cfg_t pi_d;
    pi_cfg_t pi_q;
    int32_t reactance_d_q13; /* Ω_b·L_d·I_b/U_b, 0…32767 */
    int32_t reactance_q_q13; /* Ω_b·L_q·I_b/U_b */
    int32_t emf_q13;         /* Ω_b·φ/U_b */
    int32_t resistance_q13;  /* R·I_b/U_b */
} current_loop_cfg_t;

/* A loop of zeros begins without integrals and plan. */
typedef struct {
    pi_t pi_d;
    pi_t pi_q;
    dq_t reactance_q14; /* ω·L_d, ω·L_q of the last plan, Q14 of U_b/I_b */
    dq_t constant;      /* R·i_d* and R·i_q* + ω·φ of the last plan, Q15 of U_b */
} current_loop_t;

/*
 * Change to a frame that is turned by `angle` against the present one. The integrals are turned
 * back by that angle, so that the voltage vector stays. They are rounded and saturate at ±1.
 */
void current_loop_turn(current_loop_t *loop, sincos_t angle);

/*
 * Computes the parts of the model that stay constant for a slow period. Call it when the reference,
 * the gains or the speed have changed. |reference| ≤ 23171, |speed_q15| ≤ 32768. Each product is
 * rounded down.
 */
void current_loop_plan(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       int32_t speed_q15);

/*
 * Returns the voltage that the model needs for this current: R·i* of the plan, decoupling and EMF
 * at the plan's speed, Q15 of U_b, ±2^19. The current saturates at ±1. The products are rounded
 * down.
 */
dq_t current_loop_model(const current_loop_t *loop, dq_t current);

/*
 * Adds `voltage` to the integrals. Call it when the model no longer gives this voltage, so that the
 * output does not jump. `voltage` is limited to ±32767; the integrals saturate at ±1.
 */
void current_loop_take_over(current_loop_t *loop, dq_t voltage);

/*
 * One tick. Returns the voltage to apply, |v| ≤ limit. |reference| ≤ 23171, |measured| ≤ 42364.
 * limit: 0…32766, so that a demand that saturates at 16 bits lies outside of the circle. Within the
 * circle both integrals move freely. Outside, each axis is first limited as by pi_limit(). Then the
 * axis without priority is reduced to the circle by a square root. Its integral is reduced by the
 * same voltage.
 */
dq_t current_loop_step(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       dq_t measured, int32_t limit);

#endif
