/* SPDX-License-Identifier: MIT */
/*
 * A motor's constants and state, and what its terminals are connected to. motor.h says what they
 * mean and what can be done with them; the files of the ideal and of the real motor know no more of
 * it than this.
 */
#ifndef PLANT_MOTOR_STATE_H
#define PLANT_MOTOR_STATE_H

#include "iron.h"
#include "legs.h"
#include "rotation.h"
#include "windings.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Bound on rate * step of an ideal motor, dimensionless. */
#define PLANT_MOTOR_STEP 0.025

typedef struct {
    double flux_d_wb; /* flux linkage, rotor frame, magnet included */
    double flux_q_wb;
    double cosine; /* of theta_el_rad */
    double sine;
    double omega_el_rad_s;
    double theta_el_rad;   /* -pi ... pi after plant_motor_wrap, until then it runs on */
    double cogging_cosine; /* of N theta_m, with cogging only */
    double cogging_sine;
    double twist_rad;        /* mechanical, with an elastic shaft only */
    double load_speed_rad_s; /* likewise */
} plant_motor_state_t;

typedef struct {
    /* Constants, derived from the configuration. */
    double pole_pairs;
    double resistance_ohm;
    double inductance_d_h;
    double inductance_q_h;
    double flux_linkage_wb;
    double inverse_d;      /* 1/L_d */
    double inverse_q;      /* 1/L_q */
    double decay_d;        /* R/L_d, 1/s */
    double decay_q;        /* R/L_q, 1/s */
    double cross_d;        /* L_q/L_d */
    double cross_q;        /* L_d/L_q */
    double emf_d;          /* phi/L_d, A */
    double emf_q;          /* phi/L_q, A */
    double saliency;       /* 1/L_d - 1/L_q */
    double torque_factor;  /* 1.5 P */
    double torque_magnet;  /* 1.5 P phi, N m/A */
    double torque_salient; /* 1.5 P (L_d - L_q), N m/A2 */
    double acceleration;   /* P/J, electrical */
    double decay_shaft;    /* B/J, 1/s */
    double coulomb_nm;
    double free_acceleration; /* acceleration and decay_shaft of a shaft that is not blocked */
    double free_decay_shaft;
    double rate_constant; /* part of the step bound that does not depend on speed, 1/s */
    double rate_speed;    /* and the factor of |w| */
    double step_bound;    /* of rate * step */
    bool is_real;         /* has anything of this: */
    plant_iron_t iron;
    plant_windings_t windings;
    double harmonic_d_wb; /* phi a */
    double harmonic_q_wb; /* phi b */
    double cogging_nm;
    double cogging_ratio; /* N/P: its periods in an electrical turn */
    double load_gain;     /* 1/J_L; 0: the shaft is rigid */
    double stiffness_nm;
    double damping_nm_s;
    /* State and input. */
    plant_motor_state_t now;
    int64_t turns_el; /* whole electrical turns to add to now.theta_el_rad */
    double load_torque_nm;
} plant_motor_t;

/* A voltage for a time. */
typedef struct {
    double duration_s;
    plant_vector_t v;
} plant_interval_t;

/* A terminal voltage of which a part may follow the phase currents. */
typedef struct {
    plant_vector_t constant;
    /*
     * 1/s, of motor and source: plant_motor_rate, or |dv/di| of what follows over the smallest
     * inductance if that is larger.
     */
    double rate;
    const plant_soft_legs_t *legs; /* add to the constant; NULL: nothing follows */
} plant_source_t;

/* Upper bound of the rates of change of a motor that does not saturate, 1/s. */
static inline double plant_motor_linear_rate(const plant_motor_t *motor)
{
    return motor->rate_constant + motor->rate_speed * fabs(motor->now.omega_el_rad_s);
}

#ifdef __cplusplus
}
#endif

#endif
