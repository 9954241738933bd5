/* SPDX-License-Identifier: MIT */
/*
 * Three windings that differ: shorted turns, and a bad contact.
 *
 * Winding k, of the axis n_k, has the share s_k of its turns left, and a resistance r_k of its
 * contact in series. A turn links the same flux in each winding, so with the flux vector psi that
 * the field m of the currents and the magnet make
 *
 *   m = W i,   v = E i + W dpsi/dt,
 *   W = 2/3 sum s_k n_k n_k^T,   E = 2/3 sum (R s_k + r_k) n_k n_k^T
 *
 * for the vectors i and v of phase currents and terminal voltages: n_k . psi is the flux linkage of
 * a turn, v and i have no zero sequence to drive (the star point floats), and that of the windings'
 * fields has no iron to go through. Hence
 *
 *   dpsi/dt = v' - W^-1 E W^-1 m,   v' = W^-1 v,   i = W^-1 m:
 *
 * the motor of motor.h with m in place of i, v' in place of v, and a resistance that depends on the
 * direction. The power is the same on both sides, v . (W^-1 m) = v' . m.
 *
 * The shorted turns themselves are taken out, with no current around them: that of a real short
 * brakes the rotor in addition, and heats.
 *
 * Windings that are alike: are_alike, and nothing else is looked at.
 */
#ifndef PLANT_WINDINGS_H
#define PLANT_WINDINGS_H

#include "legs.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest share of a winding's turns that may be shorted. */
#define PLANT_SHORTED_MAX 0.9

/* A symmetric matrix of the plane. */
typedef struct {
    double aa;
    double ab;
    double bb;
} plant_symmetric_t;

typedef struct {
    bool are_alike;
    plant_symmetric_t linkage;    /* W */
    plant_symmetric_t inverse;    /* W^-1 */
    plant_symmetric_t resistance; /* W^-1 E W^-1 */
    /*
     * Largest eigenvalue of W^-2: by so much the terminals may be less inductive than the motor; 1:
     * alike.
     */
    double compliance;
    double resistance_max_ohm; /* largest eigenvalue of the resistance, at most */
} plant_windings_t;

/*
 * resistance_ohm: of a whole winding. shorted: of its turns, 0 ... PLANT_SHORTED_MAX. contact_ohm:
 * >= 0.
 */
void plant_windings_init(plant_windings_t *windings, double resistance_ohm,
                         const double shorted[PLANT_LEGS], const double contact_ohm[PLANT_LEGS]);

static inline plant_vector_t plant_symmetric_times(const plant_symmetric_t *matrix,
                                                   plant_vector_t x)
{
    const plant_vector_t y = {matrix->aa * x.alpha + matrix->ab * x.beta,
                              matrix->ab * x.alpha + matrix->bb * x.beta};
    return y;
}

/* v' of v, i of m, and the direction in which the motor sees a terminal. */
static inline plant_vector_t plant_windings_inside(const plant_windings_t *windings,
                                                   plant_vector_t x)
{
    return windings->are_alike ? x : plant_symmetric_times(&windings->inverse, x);
}

#ifdef __cplusplus
}
#endif

#endif
