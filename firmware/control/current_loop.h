/* SPDX-License-Identifier: MIT */
/*
 * Current control in the rotor frame: one PI per axis, decoupling, voltage limited to a circle.
 *
 *     v_d = PI_d(i_d* − i_d) + R·i_d* − ω·L_q·i_q
 *     v_q = PI_q(i_q* − i_q) + R·i_q* + ω·(L_d·i_d + φ)    motor equations (1), (2) of paper A
 *     √(v_d² + v_q²) ≤ v_limit
 * The d axis has priority, because it holds the flux: v_q gets what v_d leaves of the circle.
 *
 * Currents Q15 of I_b, voltages Q15 of U_b, speed_q15: Q15 of the speed base Ω_b. Pure, total within the
 * ranges. Call once a control tick.
 */
#ifndef CURRENT_LOOP_H
#define CURRENT_LOOP_H

#include "fx.h"
#include "pi.h"
#include "transforms.h"

#include <stdint.h>

#define CURRENT_LOOP_GAIN_BITS (13U) /* fractional bits of the model's gains below: Q13 */

/* Limit of speed times reactance, Q15. Its product with the largest current stays below 2^31. */
#define CURRENT_LOOP_REACH_MAX (65000)

typedef struct {
    pi_cfg_t pi_d;
    pi_cfg_t pi_q;
    int32_t reactance_d_q13; /* Ω_b·L_d·I_b/U_b, 0…32767 */
    int32_t reactance_q_q13; /* Ω_b·L_q·I_b/U_b */
    int32_t emf_q13;         /* Ω_b·φ/U_b */
    int32_t resistance_q13;  /* R·I_b/U_b */
} current_loop_cfg_t;

typedef struct {
    pi_t pi_d;
    pi_t pi_q;
} current_loop_t;

/*
 * The voltage that the current of one axis induces in the other axis, Q15 of U_b: speed × reactance × current.
 * |speed_q15| ≤ 32767, reactance 0…32767, any current. Speed times reactance saturates at ±CURRENT_LOOP_REACH_MAX; with a
 * configuration that config_check accepts it does not get there. The current saturates at ±1. Each product is rounded
 * down. Pure, any context.
 */
static inline int32_t current_loop_cross(int32_t speed_q15, int32_t reactance_q13, int32_t current)
{
    const int32_t reach = fx_clamp(fx_asr(speed_q15 * reactance_q13, CURRENT_LOOP_GAIN_BITS),
                                   -CURRENT_LOOP_REACH_MAX, CURRENT_LOOP_REACH_MAX);

    return fx_asr(reach * fx_sat16(current), 15U);
}

/* Set both integrals to zero. */
void current_loop_reset(current_loop_t *loop);

/*
 * Change to a frame that is turned by `angle` against the present one. The integrals are turned back by that angle, so
 * that the voltage vector stays. They are rounded and saturate at ±1.
 */
void current_loop_turn(current_loop_t *loop, sincos_t angle);

/*
 * One tick. Returns the voltage to apply, |v| ≤ limit. |reference| ≤ 23171, |measured| ≤ 32770, |speed_q15| ≤ 32767,
 * limit 0…32767. The square root is computed only when the demand is outside of the circle. The q integral is then
 * reduced by what was cut off v_q.
 */
dq_t current_loop_step(current_loop_t *loop, const current_loop_cfg_t *cfg, dq_t reference,
                       dq_t measured, int32_t speed_q15, int32_t limit);

#endif
