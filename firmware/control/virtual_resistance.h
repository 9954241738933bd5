/* SPDX-License-Identifier: MIT */
/*
 * A resistance that acts only on changes of the current.
 *
 * Without current regulators nothing but R/L damps the currents' own mode: a vector that stands
 * still in space and thus turns with −ω in the frame of the rotor. A real resistance would cost
 * power. This one subtracts a voltage in proportion to the difference between the current and its
 * mean, so it costs no power in the steady state:
 *     v(n) = −R_v·(i(n) − m(n)),  m(n+1) = m(n) + r·(i(n) − m(n))
 * With a = r/T the mode's damping rises by R_v/L · ω²/(ω² + a²), in 1/s. If the mean is faster than
 * the mode, it follows the mode, and nothing is damped.
 *
 * For the difference the mean is rounded down to an LSB of current; the products are exact. So the
 * mean settles on a constant current to the LSB, and no voltage remains.
 *
 * Currents Q15 of I_b. Pure, total. Call once a control tick, from the control interrupt only.
 */
#ifndef VIRTUAL_RESISTANCE_H
#define VIRTUAL_RESISTANCE_H

#include "fx.h"
#include "transforms.h"

#include <stdint.h>

typedef struct {
    int32_t resistance_q15; /* R_v, Q15 of U_b/I_b, 0…16384; 0: none */
    int32_t mean_rate_q15;  /* r of the mean, 1…16384 */
} virtual_resistance_cfg_t;

typedef struct {
    dq_t mean_q30; /* the mean m, ±2^29 */
} virtual_resistance_t;

/* Start with `current` as the mean, ±16384. */
void virtual_resistance_start(virtual_resistance_t *res, dq_t current);

/* Returns the mean m, ±16384, rounded down. */
dq_t virtual_resistance_mean(const virtual_resistance_t *res);

/*
 * One sample. Returns the voltage v to add, Q30 of U_b, ±832045056. current: |i| ≤ 34400 in each
 * axis. The mean saturates at ±2^29.
 */
dq_t virtual_resistance_step(virtual_resistance_t *res, const virtual_resistance_cfg_t *cfg,
                             dq_t current);

#endif
