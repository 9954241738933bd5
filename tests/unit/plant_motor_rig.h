/* SPDX-License-Identifier: MIT */
/* A motor of the plant on its own: what starts and drives one, and what is true of any. */
#ifndef PLANT_MOTOR_RIG_H
#define PLANT_MOTOR_RIG_H

#include "plant_motors.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

/* Error of a transient relative to the scale of its currents, as motor.h states it. */
#define ACCURACY 1.0e-6
#define ACCURACY_DRONE 1.0e-5

/* Sums of some 10^5 roundings of 2^-53. */
#define ROUNDING 1.0e-10

static plant_motor_t motor;
static plant_motor_cfg_t cfg; /* of the motor that start() makes */

static inline void start(void)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_motor_init(&motor, &cfg, &bad), bad);
}

static inline void run(double duration_s, double v_alpha, double v_beta)
{
    const plant_interval_t interval = {duration_s, {v_alpha, v_beta}};

    plant_motor_run_driven(&motor, 1, &interval);
    plant_motor_wrap(&motor);
}

/* With open windings. */
static inline void coast(int steps, double step_s)
{
    for (int k = 0; k < steps; k++) {
        plant_motor_step_open(&motor, step_s);
        plant_motor_wrap(&motor);
    }
}

static inline double omega_mech(void)
{
    return motor.now.omega_el_rad_s / motor.pole_pairs;
}

static inline double kinetic_j(void)
{
    return 0.5 * (motor.pole_pairs / motor.acceleration) * omega_mech() * omega_mech();
}

/* Of the field, with constant inductances. */
static inline double linear_j(void)
{
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);

    return 0.75 * (motor.inductance_d_h * i_d * i_d + motor.inductance_q_h * i_q * i_q);
}

static inline void check_current(double tolerance_a, double i_d, double i_q)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, i_d, plant_motor_i_d(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, i_q, plant_motor_i_q(&motor));
}

/*
 * Electrical energy in = stored + copper + friction + shaft + load, all but the first integrated by
 * the trapezoidal rule over h.
 */
static inline void check_energy(double (*stored_j)(void))
{
    const double h = 1.0e-6;
    double in_j = 0.0;
    double out_j = 0.0;
    plant_vector_t before = {0.0, 0.0};
    double loss_before = 0.0;

    cfg.viscous_friction_nm_s = 0.01;
    cfg.coulomb_friction_nm = 0.05;
    cfg.initial_angle_el_rad = -1.2;
    start();
    motor.load_torque_nm = 0.4;
    const double at_first_j = stored_j();
    for (long k = 0; k < 300000; k++) {
        /* A slowly turning vector, switched on and off as by a pulse width modulator. */
        const double on = ((k % 100) < 35) ? 100.0 : 0.0;
        const double angle = 60.0 * (double)k * h;
        const plant_vector_t v = {on * cos(angle), on * sin(angle)};
        run(h, v.alpha, v.beta);
        const plant_vector_t i = plant_motor_current(&motor);
        const double speed = omega_mech();
        const double load = (cfg.load_inertia_kg_m2 > 0.0) ? motor.now.load_speed_rad_s : speed;
        const double loss = 1.5 * cfg.resistance_ohm * (i.alpha * i.alpha + i.beta * i.beta) +
                            speed * (cfg.viscous_friction_nm_s * speed + copysign(0.05, speed)) +
                            cfg.shaft_damping_nm_s * (speed - load) * (speed - load) + 0.4 * load;
        in_j += 0.75 * h * (v.alpha * (i.alpha + before.alpha) + v.beta * (i.beta + before.beta));
        out_j += 0.5 * h * (loss + loss_before);
        before = i;
        loss_before = loss;
    }
    /*
     * Trapezoidal rule: (h * rate)^2 / 12 = 1e-8 for rate < 400 1/s, and half a step of the
     * friction power at each of some ten reversals.
     */
    const double tolerance = 1.0e-6;
    TEST_ASSERT_TRUE(in_j > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance * in_j, in_j + at_first_j, out_j + stored_j());
}

/* One run with modulated voltage, each interval in so many parts. */
static inline plant_motor_t modulated_run(double period_s, double v, int parts)
{
    start();
    for (int k = 0; k < 400; k++) {
        const double angle = cfg.initial_angle_el_rad + 2.0 + 0.05 * (double)k;
        for (int p = 0; p < parts; p++) {
            run(0.6 * period_s / parts, v * cos(angle), v * sin(angle));
        }
        for (int p = 0; p < parts; p++) {
            run(0.4 * period_s / parts, 0.0, 0.0);
        }
    }
    return motor;
}

static inline void check_same(const plant_motor_t *a, const plant_motor_t *b, double accuracy)
{
    const double scale_a = a->flux_linkage_wb / a->inductance_d_h;
    const double speed = fmax(fabs(a->now.omega_el_rad_s), 1.0);

    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_d(a), plant_motor_i_d(b));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_q(a), plant_motor_i_q(b));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * speed, a->now.omega_el_rad_s, b->now.omega_el_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(accuracy, a->now.theta_el_rad, b->now.theta_el_rad);
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * speed, a->now.load_speed_rad_s, b->now.load_speed_rad_s);
}

static inline void check_independence_of_step(double period_s, double v, double accuracy)
{
    const plant_motor_t coarse = modulated_run(period_s, v, 1);
    const plant_motor_t fine = modulated_run(period_s, v, 16);

    check_same(&fine, &coarse, accuracy);
}

/* The init function refuses the configuration and names the field. */
static inline void check_refused(const plant_motor_cfg_t *wrong, const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_motor_init(&motor, wrong, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

/* It does so for cfg with that value in the field. */
#define CHECK_REFUSED(field, value) \
    do { \
        plant_motor_cfg_t wrong = cfg; \
        wrong.field = (value); \
        check_refused(&wrong, "motor." #field); \
    } while (false)

#endif
