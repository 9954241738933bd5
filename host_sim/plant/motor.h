/* SPDX-License-Identifier: MIT */
/*
 * Permanent-magnet synchronous motor with saliency, and its shaft.
 *
 *   L_d di_d/dt = v_d - R i_d + w L_q i_q
 *   L_q di_q/dt = v_q - R i_q - w L_d i_d - w phi             w = P w_m, dtheta/dt = w
 *   T_e = 1.5 P (phi i_q + (L_d - L_q) i_d i_q)
 *   J dw_m/dt = T_e - T_L - B w_m - T_C sign(w_m)
 *
 * The first two are paper A (1), (2), solved for the derivatives as in paper A (3), (4), with
 * saliency; the torque is paper B (8), the shaft paper B (9) with a motor's signs and with dry
 * friction.
 *
 * Amplitude-invariant Clarke, d axis on the magnet flux, currents positive into the motor. No
 * iron loss, star point floating (no zero-sequence current).
 *
 * EMF harmonics: the EMF of phase a without current is -w phi (sin theta + h_5 sin 5 theta + h_7
 * sin 7 theta), so the magnet's flux linkage in the rotor frame is phi [1 + a cos 6 theta, b sin 6
 * theta], a = h_5/5 + h_7/7, b = h_7/7 - h_5/5. Their torque is that of the power, EMF times
 * current over speed: 1.5 P (psi_d i_q - psi_q i_d + i dpsi_magnet/dtheta).
 *
 * Saturation: L_d and L_q fall with the currents as iron.h says; the fluxes make the torque as
 * above.
 *
 * Elastic shaft: a load of inertia J_L hangs on a shaft of stiffness k and damping d. The shaft is
 * twisted by xi = theta_m - theta_L and carries the torque T_S = k xi + d (w_m - w_L). T_S takes
 * the place of T_L above, J is that of the rotor alone, and J_L dw_L/dt = T_S - T_L. Friction is
 * the rotor's.
 *
 * Cogging: -T_cog sin(N theta_m), of the energy T_cog/N (1 - cos(N theta_m)): nothing in the mean
 * of a turn.
 *
 * Windings: those of the three phases may differ, windings.h; the currents above are those that
 * make the field then.
 *
 * Stiction: a shaft at rest stays exactly at rest while |T_e - T_L| <= T_C. A shaft that passes
 * through zero speed stops there if that holds, else goes on against the reversed friction.
 *
 * Integration: Taylor series of the whole nonlinear system over steps in which the inverter voltage
 * is constant in the stationary frame, third order in flux linkage, speed and angle. The voltage
 * and the rotation enter exactly, so the error is that of R times the integral of the current:
 * (rate h)^3 / 24 * (R/L h) of the currents' scale in a step h, with rate = R/L + saliency * |w| +
 * electromechanical natural frequency + B/J. rate * h is held at or below PLANT_MOTOR_STEP: at most
 * 1.6e-8 in a step. Measured against 16 times finer steps the currents of a transient differ by
 * less than 1e-6 of phi/L_d for motors of some kW at 10 kHz, 1e-5 for a drone motor at 40 kHz.
 *
 * A motor with harmonics, saturation, cogging, an elastic shaft or windings that differ is real,
 * without them ideal. A real one is integrated by classical Runge-Kutta of the fourth order in the
 * same frame, in longer steps: rate * h <= 0.1, where the rates of harmonics and cogging count by
 * half. Steps below 0.0078 are those of the midpoint method. The accuracy of a transient is the
 * same.
 */
#ifndef PLANT_MOTOR_H
#define PLANT_MOTOR_H

#include "legs.h"
#include "motor_state.h"
#include "rotation.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Bound on the rate of a source that follows the current. The classical Runge-Kutta method errs by
 * x^5/120 = 2.6e-4 of what the current is from where the source drives it.
 */
#define PLANT_MOTOR_FED_STEP 0.5

typedef struct {
    unsigned pole_pairs;    /* 1 ... 100 */
    double resistance_ohm;  /* Ohm, phase, >= 0 */
    double inductance_d_h;  /* H, > 0 */
    double inductance_q_h;  /* H, > 0; may be smaller or larger than inductance_d_h */
    double flux_linkage_wb; /* Wb, peak, >= 0; 0: pure reluctance motor */
    double inertia_kg_m2;   /* kg m2, > 0, with the load unless that has an inertia of its own */
    double viscous_friction_nm_s; /* N m s/rad, mechanical, >= 0 */
    double coulomb_friction_nm;   /* N m, >= 0; 0: no stiction either */
    double emf_5th;               /* h_5, of the fundamental, |x| <= 0.5; 0: none */
    double emf_7th;               /* h_7, likewise */
    double saturation_d;          /* fall_d, fall_q and shared of iron.h; 0: none */
    double saturation_q;
    double saturation_shared;
    double saturation_a;    /* A, > 0, I_s of iron.h; with saturation only */
    double cogging_nm;      /* N m, >= 0, peak; 0: none */
    unsigned cogging_order; /* N, periods in a turn of the shaft, 1 ... 1000; with cogging only */
    double load_inertia_kg_m2;  /* kg m2, >= 0, behind an elastic shaft; 0: the shaft is rigid */
    double shaft_stiffness_nm;  /* N m/rad, > 0; with an elastic shaft only */
    double shaft_damping_nm_s;  /* N m s/rad, >= 0; likewise */
    double shorted[PLANT_LEGS]; /* of each winding's turns, 0 ... PLANT_SHORTED_MAX */
    double contact_ohm[PLANT_LEGS];  /* Ohm, >= 0, in series with each winding */
    double initial_angle_el_rad;     /* rad, electrical, |x| < 1e6 */
    double initial_speed_mech_rad_s; /* rad/s, mechanical */
} plant_motor_cfg_t;

/* Largest saturation_shared of a motor whose other fields are in range, 1 at most. */
double plant_motor_shared_max(const plant_motor_cfg_t *cfg);

/*
 * Returns false and names the offending field in *bad_field when a value is out of range.
 * Starts without current and without load.
 */
bool plant_motor_init(plant_motor_t *motor, const plant_motor_cfg_t *cfg, const char **bad_field);

/* Phase currents in the rotor frame, A. */
double plant_motor_i_d(const plant_motor_t *motor);
double plant_motor_i_q(const plant_motor_t *motor);

/* Air-gap torque, N m, that of harmonics and cogging included. */
double plant_motor_torque(const plant_motor_t *motor);

/*
 * Largest inverse inductance at present, in any direction, over that without current: 1 if nothing
 * saturates.
 */
double plant_motor_growth(const plant_motor_t *motor);

/* Upper bound of the rates of change, 1/s: see the integration paragraph above. */
static inline double plant_motor_rate(const plant_motor_t *motor)
{
    const double rate = plant_motor_linear_rate(motor);
    return motor->iron.saturates ? rate * plant_motor_growth(motor) : rate;
}

/* Into how many equal steps a time goes: its rate * time over their bound, rounded up. */
static inline double plant_motor_steps(double effort)
{
    return (effort > 1.0) ? ceil(effort) : 1.0;
}

/*
 * Of the load, mechanical: its speed, rad/s, and 1 over its inertia, 1/(kg m2). On a rigid shaft it
 * is the rotor's.
 */
static inline double plant_motor_load_speed(const plant_motor_t *motor)
{
    return motor->load_gain > 0.0 ? motor->now.load_speed_rad_s
                                  : motor->now.omega_el_rad_s / motor->pole_pairs;
}
static inline double plant_motor_load_gain(const plant_motor_t *motor)
{
    return motor->load_gain > 0.0 ? motor->load_gain : motor->free_acceleration / motor->pole_pairs;
}

/* Phase currents as a stationary vector, A. */
plant_vector_t plant_motor_current(const plant_motor_t *motor);

/* EMF without current, V. */
plant_vector_t plant_motor_emf(const plant_motor_t *motor);

/* Multi-turn mechanical angle, rad. */
double plant_motor_angle_mech(const plant_motor_t *motor);

/*
 * Stops the rotor dead and holds it against every torque, or lets it go. A load behind an elastic
 * shaft swings on.
 */
void plant_motor_block(plant_motor_t *motor, bool blocked);

/*
 * Puts the rotor elsewhere, electrical rad, |x| < 1e6: phase currents, speed and the twist of the
 * shaft stay.
 */
void plant_motor_turn(plant_motor_t *motor, double angle_el_rad);

/* Brings theta_el_rad back into -pi ... pi and counts the turn. Call at least once per turn. */
void plant_motor_wrap(plant_motor_t *motor);

/*
 * The ways to take one step of step_s seconds, 0 <= step_s * plant_motor_rate(motor) <=
 * about motor->step_bound:
 * _driven:  terminal voltage v (stationary, V) on all phases.
 * _tied:    the phase along the unit vector axis carries no current and floats; v is the voltage
 *           vector with that terminal's potential taken as zero.
 * _open:    no current at all.
 * _fed:     as _driven, or with an axis as _tied, with a source; |dv/di| over the smallest
 *           inductance times step_s is at most PLANT_MOTOR_FED_STEP. Fourth order.
 */
void plant_motor_step_driven(plant_motor_t *motor, double step_s, plant_vector_t v);
void plant_motor_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis);
void plant_motor_step_open(plant_motor_t *motor, double step_s);
void plant_motor_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                          const plant_vector_t *tied_axis);

/* Potential of the floating terminal of _tied, V, at present. */
double plant_motor_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis);

/* Removes the current along a phase axis (a phase that has just stopped conducting). */
void plant_motor_clear_phase(plant_motor_t *motor, plant_vector_t axis);

/*
 * Intervals of constant voltage on all phases, one after the other, each in as many steps of
 * plant_motor_step_driven as the step bound at the beginning of the first asks for.
 */
void plant_motor_run_driven(plant_motor_t *motor, unsigned count,
                            const plant_interval_t interval[]);

#ifdef __cplusplus
}
#endif

#endif
