/* SPDX-License-Identifier: MIT */
/*
 * Conduction of a bridge whose legs commutate softly: what a leg loses against its current follows
 * the current smoothly, instead of turning at zero as with the ideal diodes of bridge.h.
 *
 * The output of a leg has a capacitance C. In a dead time t_d the current alone recharges it
 * between the rails, U apart: in C U/i, or not completely. In the two dead times of a period the
 * leg so loses in all, against its current i,
 *
 *   U t_d f(i / i_k),   f(z) = z/2 for |z| <= 1, sign(z) (1 - 1/(2 |z|)) beyond,   i_k = C U / t_d:
 *
 * half of what an ideal diode takes at the knee i_k, and all of it for a large current. The device
 * drop goes the same way, as a forward voltage does.
 *
 * An open leg has in each instant the potential that makes this mean, a closed one its rail and the
 * drop:
 *
 *   switch closed     potential
 *   high side         bus - drop f(i/i_k)
 *   low side              - drop f(i/i_k)
 *   none              bus/2 - (bus/2 + drop) f(i/i_k)
 *
 * The current of an open leg is taken from the positive rail as far as its potential is from it: (1
 * - f)/2 of it. So the bus gives what the motor takes and what the drops turn into heat.
 *
 * It is a function of the current, so a current does not stop at zero and nothing has to be located
 * in time. A broken phase floats. Made for gates that switch and at most one open wire: all else is
 * the business of bridge.h.
 */
#ifndef PLANT_KNEE_H
#define PLANT_KNEE_H

#include "bridge.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As plant_bridge_run, for rails->knee_a > 0. */
void plant_knee_run(plant_motor_t *motor, const plant_segment_t *segment,
                    const plant_rails_t *rails, double *charge_c);

#ifdef __cplusplus
}
#endif

#endif
