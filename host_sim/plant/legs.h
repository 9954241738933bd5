/* SPDX-License-Identifier: MIT */
/*
 * The three legs of a bridge: a vector of the plane seen from them, and what a leg loses that
 * commutates softly (knee.h).
 *
 * Inline: the integration of the motor asks for the loss in each of its stages.
 */
#ifndef PLANT_LEGS_H
#define PLANT_LEGS_H

#include "rotation.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLANT_LEGS 3

/* A vector in the stationary frame. */
typedef struct {
    double alpha;
    double beta;
} plant_vector_t;

/* Leg potentials to a stationary vector (amplitude-invariant Clarke), V. */
static inline plant_vector_t plant_clarke(double a, double b, double c)
{
    const plant_vector_t v = {(2.0 * a - b - c) * (1.0 / 3.0), (b - c) * (1.0 / PLANT_SQRT3)};
    return v;
}

/* A stationary vector to three phases. */
static inline void plant_phases(plant_vector_t v, double phase[PLANT_LEGS])
{
    phase[0] = v.alpha;
    phase[1] = 0.5 * (PLANT_SQRT3 * v.beta - v.alpha);
    phase[2] = -0.5 * (PLANT_SQRT3 * v.beta + v.alpha);
}

/* A leg's potential is half_v f(i/knee_a) below that without current. */
typedef struct {
    double half_v[PLANT_LEGS]; /* V, >= 0 */
    double knee_a;             /* A, > 0 */
} plant_soft_legs_t;

/* f(z) of knee.h. */
static inline double plant_share_lost(double current_a, double knee_a)
{
    const double z = current_a / knee_a;
    return (fabs(z) <= 1.0) ? 0.5 * z : copysign(1.0 - 0.5 / fabs(z), z);
}

/* The voltage that the legs add to that without current, V. */
static inline plant_vector_t plant_soft_legs_v(const plant_soft_legs_t *legs,
                                               plant_vector_t current)
{
    double v[PLANT_LEGS];
    plant_phases(current, v);
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        const double half_v = legs->half_v[leg];
        v[leg] = (half_v > 0.0) ? -half_v * plant_share_lost(v[leg], legs->knee_a) : 0.0;
    }
    return plant_clarke(v[0], v[1], v[2]);
}

#ifdef __cplusplus
}
#endif

#endif
