/* SPDX-License-Identifier: MIT */
/*
 * Conduction of a three-leg bridge into the motor while no switch changes.
 *
 * Each leg has two limits of its output potential (negative rail = 0):
 *
 *   switch closed     lower limit         upper limit
 *   high side         bus - drop          bus + drop
 *   low side          -drop               +drop
 *   none (diodes)     -drop               bus + drop
 *
 * A leg whose current flows into the motor (i > 0) is at its lower limit, one whose current flows
 * out is at its upper limit. A leg without current takes whatever potential the motor gives it as
 * long as that lies within the limits: it floats, its current stays zero. Beyond a limit it begins
 * to conduct there. This one rule covers the dead time, the drop of a conducting device, the
 * clamping of a current that reaches zero, and rectification by the diodes of an open bridge.
 *
 * A phase whose wire is open has no limits: it floats at any potential.
 *
 * Events (a current reaches zero, a floating potential reaches a limit) are located in time until
 * they are overstepped by less than PLANT_BRIDGE_TOLERANCE. Currents below it count as zero.
 */
#ifndef PLANT_BRIDGE_H
#define PLANT_BRIDGE_H

#include "inverter.h"
#include "motor.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A, and V for potentials. */
#define PLANT_BRIDGE_TOLERANCE 1.0e-6

/* What the legs connect to, constant over a segment. */
typedef struct {
    double bus_v;  /* V, > 0 */
    double drop_v; /* V, >= 0 */
    double knee_a; /* A, >= 0, for knee.h; 0: ideal diodes, as above */
    uint32_t
        broken; /* mask of the phases whose wire is open; their current must be 0 at the start */
} plant_rails_t;

/* Unit vectors of the phases. */
extern const plant_vector_t plant_bridge_axis[PLANT_LEGS];

/*
 * Runs the motor on the bridge for one segment. Adds the charge that flows out of the positive rail
 * to *charge_c (C), by the trapezoidal rule over the motor's steps: with (rate h)^2 / 12 the error
 * is within 5e-5 of the current's scale. NULL: nobody wants to know.
 */
void plant_bridge_run(plant_motor_t *motor, const plant_segment_t *segment,
                      const plant_rails_t *rails, double *charge_c);

/* Takes the current out of the phases of a mask, as an arc at the broken wire would in no time. */
void plant_bridge_break(plant_motor_t *motor, uint32_t broken);

#ifdef __cplusplus
}
#endif

#endif
