/* SPDX-License-Identifier: MIT */
/*
 * What the files of the motor share: its state while it is worked on, the ideal motor's currents,
 * dry friction, and the steps of the two kinds of motor.
 *
 * Ideal (ideal_motor.c): constant inductances, sinusoidal EMF, no cogging, a rigid shaft. Real
 * (real_motor.c): all else that motor.h says, and any motor at a voltage that follows its current.
 * The steps are those of motor.h, by their names there.
 */
#ifndef PLANT_MOTOR_INSIDE_H
#define PLANT_MOTOR_INSIDE_H

#include "motor_state.h"
#include "pair.h"

/* The state while it is worked on, in registers. */
typedef struct {
    pair_t flux;
    pair_t axis; /* cosine and sine of theta */
    double omega;
    double theta;
} core_t;

static inline core_t load(const plant_motor_t *motor)
{
    const plant_motor_state_t *now = &motor->now;
    return (core_t){
        {now->flux_d_wb, now->flux_q_wb},
        {now->cosine, now->sine},
        now->omega_el_rad_s,
        now->theta_el_rad,
    };
}

static inline void store(plant_motor_t *motor, const core_t *core)
{
    plant_motor_state_t *now = &motor->now;
    now->flux_d_wb = core->flux[0];
    now->flux_q_wb = core->flux[1];
    now->cosine = core->axis[0];
    now->sine = core->axis[1];
    now->omega_el_rad_s = core->omega;
    now->theta_el_rad = core->theta;
}

static inline pair_t by_matrix(const plant_symmetric_t *matrix, pair_t x)
{
    const plant_vector_t y = plant_symmetric_times(matrix, (plant_vector_t){x[0], x[1]});
    return (pair_t){y.alpha, y.beta};
}

static inline pair_t inverse_inductance(const plant_motor_t *m)
{
    return (pair_t){m->inverse_d, m->inverse_q};
}

static inline pair_t magnet(const plant_motor_t *m)
{
    return (pair_t){m->flux_linkage_wb, 0.0};
}

static inline pair_t current_of(const plant_motor_t *m, pair_t flux)
{
    return inverse_inductance(m) * (flux - magnet(m));
}

static inline pair_t flux_of(const plant_motor_t *m, pair_t current)
{
    const pair_t inductance = {m->inductance_d_h, m->inductance_q_h};
    return inductance * current + magnet(m);
}

static inline double torque_of(const plant_motor_t *m, pair_t flux)
{
    return m->torque_factor * difference(swapped(flux) * current_of(m, flux));
}

/* What the shaft does for the length of a step: Coulomb friction does not change sign in it. */
typedef struct {
    double gain;    /* P/J, or 0 while the shaft sticks */
    double drag_nm; /* load and Coulomb torque */
} shaft_t;

/*
 * Adds dry friction: against the motion, or against the torque net_nm that would start it. A shaft
 * at rest that it can hold sticks.
 */
static inline void add_friction(const plant_motor_t *m, double net_nm, double omega, shaft_t *shaft)
{
    const double direction = (omega != 0.0) ? omega : net_nm;
    shaft->drag_nm += copysign(m->coulomb_nm, direction);
    if (omega == 0.0 && fabs(net_nm) <= m->coulomb_nm) {
        shaft->gain = 0.0;
    }
}

/*
 * Coulomb friction turned against the motion inside a step from speed before to speed after, at
 * whose end net_nm acts: the shaft stops, or leaves zero speed with the friction reversed for what
 * was left of the step.
 */
static inline double speed_past_zero(const plant_motor_t *m, double net_nm, double before,
                                     double after, double step_s)
{
    const double left_s = step_s * after / (after - before);
    if (fabs(net_nm) <= m->coulomb_nm) {
        return 0.0;
    }
    return m->acceleration * (net_nm - copysign(m->coulomb_nm, net_nm)) * left_s;
}

/* Turns the rotor by the sum; returns cosine and sine of it. */
static inline pair_t shaft_turn(core_t *core, double turn, double second, double third)
{
    const pair_t by = small_turn(turn, second, third);
    core->axis = turned(by, core->axis);
    core->theta += turn + (second + third);
    return by;
}

void plant_ideal_run_driven(plant_motor_t *motor, unsigned count, const plant_interval_t interval[],
                            double rate);
void plant_ideal_step_tied(plant_motor_t *motor, double step_s, plant_vector_t v,
                           plant_vector_t axis);
void plant_ideal_step_open(plant_motor_t *motor, double step_s);
double plant_ideal_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                      plant_vector_t axis);
void plant_ideal_clear_phase(plant_motor_t *motor, plant_vector_t axis);

/* Of any motor, also of an ideal one. */
void plant_real_step_fed(plant_motor_t *motor, double step_s, const plant_source_t *source,
                         const plant_vector_t *tied);
/* Of a real motor only. */
void plant_real_step_open(plant_motor_t *motor, double step_s);
double plant_real_floating_potential(const plant_motor_t *motor, plant_vector_t v,
                                     plant_vector_t axis);
void plant_real_clear_phase(plant_motor_t *motor, plant_vector_t axis);
pair_t plant_real_current(const plant_motor_t *motor); /* rotor frame */
double plant_real_torque(const plant_motor_t *motor);
plant_vector_t plant_real_emf(const plant_motor_t *motor);

/* Flux linkage of a real motor at its present angle with a current, both in the rotor frame. */
pair_t plant_real_flux(const plant_motor_t *motor, pair_t current);

/* plant_motor_growth of a saturated motor; never below 1. */
double plant_real_growth(const plant_motor_t *motor);

/* Puts the angle of the cogging where now and turns_el say. */
void plant_real_place_cogging(plant_motor_t *motor);

#endif
