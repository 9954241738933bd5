/* SPDX-License-Identifier: MIT */
/*
 * Flux maps of saturated iron, from one energy: so reciprocal, dpsi_d/di_q = dpsi_q/di_d, and
 * lossless.
 *
 * psi: flux linkage of the currents (less the magnet's), rotor frame. With the current I_s at which
 * saturation is stated, x = psi_d / (L_d I_s), y = psi_q / (L_q I_s), and two thirds of the energy
 *
 *   W = I_s { L_d I_s [x^2/2 + g_d (x^3 + x^4/4)] + L_q I_s [y^2/2 + g_q y^4/4]
 *             + C/2 (x + x^2/2) y^2 }
 *
 * the currents are its derivatives:
 *
 *   i_d = I_s [x + g_d (3 x^2 + x^3) + C/(2 L_d I_s) (1 + x) y^2]
 *   i_q = I_s [y + g_q y^3 + C/(L_q I_s) (x + x^2/2) y]
 *
 * The magnet counts for the d axis as one L_d I_s of flux that is there already: the fourth powers
 * are those of 1 + x and y. So L_d falls with i_d > 0, rises with i_d < 0, and L_d, L_q are those
 * without current. Cross-saturation takes flux from the d axis when there is q current. C = s 2
 * sqrt(g_d g_q L_d L_q) I_s: with s = 1 both axes share their iron.
 *
 * What is stated is the fall of flux over current of one axis at I_s, without current in the other
 * one:
 *   g_q = f / (1 - f)^3,   g_d = f / ((1 - f)^2 (4 - f)).
 */
#ifndef PLANT_IRON_H
#define PLANT_IRON_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest falls: g_d below 1/3 and L_d at most twice as large for any i_d. */
#define PLANT_IRON_FALL_D_MAX 0.3
#define PLANT_IRON_FALL_Q_MAX 0.5

typedef struct {
    double inductance_d_h; /* H, > 0, without current */
    double inductance_q_h;
    double current_a; /* I_s, A, > 0 */
    double fall_d;    /* of L_d at i_d = I_s, 0 ... PLANT_IRON_FALL_D_MAX */
    double fall_q;    /* of L_q at i_q = +-I_s, 0 ... PLANT_IRON_FALL_Q_MAX */
    double shared;    /* s, 0 ... 1; below plant_iron_shared_max() */
} plant_iron_cfg_t;

/* In the rotor frame. */
typedef struct {
    double d;
    double q;
} plant_dq_t;

typedef struct {
    bool saturates; /* else the inductances are constant, and all that follows is not used */
    double current_a;
    plant_dq_t per_flux; /* 1 / (L I_s) */
    plant_dq_t inverse;  /* 1 / L */
    double bend_d;       /* g_d */
    double bend_q;       /* g_q */
    double cross_d;      /* C / (L_d I_s) */
    double cross_q;      /* C / (L_q I_s) */
} plant_iron_t;

/* Derivatives of the currents by the fluxes, 1/H: symmetric. */
typedef struct {
    plant_dq_t straight; /* di_d/dpsi_d, di_q/dpsi_q */
    double cross;
} plant_stiffness_t;

/* The largest s with which the map is invertible everywhere, 1 at most. */
double plant_iron_shared_max(const plant_iron_cfg_t *cfg);

/* The configuration has to be in range. */
void plant_iron_init(plant_iron_t *iron, const plant_iron_cfg_t *cfg);

static inline plant_dq_t plant_iron_current(const plant_iron_t *iron, plant_dq_t flux)
{
    const double x = iron->per_flux.d * flux.d;
    const double y = iron->per_flux.q * flux.q;
    const double d = x + iron->bend_d * x * x * (3.0 + x) + 0.5 * iron->cross_d * (1.0 + x) * y * y;
    const double q = y * (1.0 + iron->bend_q * y * y + iron->cross_q * (x + 0.5 * x * x));
    const plant_dq_t current = {iron->current_a * d, iron->current_a * q};
    return current;
}

static inline plant_stiffness_t plant_iron_stiffness(const plant_iron_t *iron, plant_dq_t flux)
{
    const double x = iron->per_flux.d * flux.d;
    const double y = iron->per_flux.q * flux.q;
    const double d = 1.0 + 3.0 * iron->bend_d * x * (2.0 + x) + 0.5 * iron->cross_d * y * y;
    const double q = 1.0 + 3.0 * iron->bend_q * y * y + iron->cross_q * (x + 0.5 * x * x);
    const plant_stiffness_t stiffness = {
        {iron->inverse.d * d, iron->inverse.q * q},
        iron->inverse.d * iron->cross_q * (1.0 + x) * y,
    };
    return stiffness;
}

/* The flux that goes with a current. */
plant_dq_t plant_iron_flux(const plant_iron_t *iron, plant_dq_t current);

#ifdef __cplusplus
}
#endif

#endif
