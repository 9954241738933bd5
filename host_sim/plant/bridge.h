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

/* Leg potentials to a stationary vector (amplitude-invariant Clarke), V. */
static inline plant_vector_t plant_bridge_clarke(double a, double b, double c)
{
    const plant_vector_t v = {(2.0 * a - b - c) * (1.0 / 3.0), (b - c) * (1.0 / PLANT_SQRT3)};
    return v;
}

/* A stationary vector to three phases. */
static inline void plant_bridge_phases(plant_vector_t v, double phase[PLANT_LEGS])
{
    phase[0] = v.alpha;
    phase[1] = 0.5 * (PLANT_SQRT3 * v.beta - v.alpha);
    phase[2] = -0.5 * (PLANT_SQRT3 * v.beta + v.alpha);
}

/* Runs the motor on the bridge for one segment. bus_v > 0, drop_v >= 0. */
void plant_bridge_run(plant_motor_t *motor, const plant_segment_t *segment, double bus_v,
                      double drop_v);

#ifdef __cplusplus
}
#endif

#endif
