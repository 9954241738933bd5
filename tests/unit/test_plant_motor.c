/* SPDX-License-Identifier: MIT */
/* The simulated motor against closed forms, its energy balance and itself with finer steps. */
#include "motor.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

/* Error of a transient relative to the scale of its currents, as motor.h states it. */
#define ACCURACY 1.0e-6
#define ACCURACY_DRONE 1.0e-5

/* Sums of some 10^5 roundings of 2^-53. */
#define ROUNDING 1.0e-10

/* Holds the speed in a test of the currents: one second of 100 N m changes it by 1e-7 rad/s. */
#define INERTIA_OF_A_WALL 1.0e9

static const plant_motor_cfg_t ROUND_ROTOR = {
    .pole_pairs = 2,
    .resistance_ohm = 2.125,
    .inductance_d_h = 0.0116,
    .inductance_q_h = 0.0116,
    .flux_linkage_wb = 0.387,
    .inertia_kg_m2 = 0.003,
    .viscous_friction_nm_s = 0.001,
};

static const plant_motor_cfg_t SALIENT = {
    .pole_pairs = 2,
    .resistance_ohm = 0.405,
    .inductance_d_h = 0.0135,
    .inductance_q_h = 0.0235,
    .flux_linkage_wb = 0.375,
    .inertia_kg_m2 = 0.011,
};

/* 7 pole pairs, time constant 0.4 ms, 12 000 rpm. */
static const plant_motor_cfg_t DRONE = {
    .pole_pairs = 7,
    .resistance_ohm = 0.05,
    .inductance_d_h = 20.0e-6,
    .inductance_q_h = 26.0e-6,
    .flux_linkage_wb = 0.9e-3,
    .inertia_kg_m2 = 2.0e-6,
    .viscous_friction_nm_s = 1.0e-6,
    .initial_speed_mech_rad_s = 1256.0,
};

static plant_motor_t motor;

static void start(const plant_motor_cfg_t *cfg)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_motor_init(&motor, cfg, &bad), bad);
}

static void run(double duration_s, double v_alpha, double v_beta)
{
    const plant_interval_t interval = {duration_s, {v_alpha, v_beta}};

    plant_motor_run_driven(&motor, 1, &interval);
    plant_motor_wrap(&motor);
}

static double omega_mech(void)
{
    return motor.now.omega_el_rad_s / motor.pole_pairs;
}

/* Magnetic plus kinetic energy. */
static double stored_j(void)
{
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);
    const double magnetic =
        0.75 * (motor.inductance_d_h * i_d * i_d + motor.inductance_q_h * i_q * i_q);

    return magnetic + 0.5 * (motor.pole_pairs / motor.acceleration) * omega_mech() * omega_mech();
}

TEST(test_locked_rotor_current_rises_along_the_exponential_of_its_axis)
{
    plant_motor_cfg_t cfg = SALIENT;
    const double v = 10.0;
    const double t = 0.02;

    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    start(&cfg);
    run(t, v, 0.0);
    const double i_end = v / cfg.resistance_ohm;
    const double i_d = i_end * -expm1(-t * cfg.resistance_ohm / cfg.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, i_d, plant_motor_i_d(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, 0.0, plant_motor_i_q(&motor));

    start(&cfg);
    run(t, 0.0, v);
    const double i_q = i_end * -expm1(-t * cfg.resistance_ohm / cfg.inductance_q_h);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, i_q, plant_motor_i_q(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, 0.0, plant_motor_i_d(&motor));
}

TEST(test_short_circuit_currents_settle_on_the_algebraic_solution)
{
    plant_motor_cfg_t cfg = SALIENT;

    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = 125.6;
    start(&cfg);
    for (int k = 0; k < 100; k++) {
        run(0.015, 0.0, 0.0); /* in all 26 time constants L_q/R, e^-26 = 5e-12 */
    }
    const double w = motor.now.omega_el_rad_s;
    const double r = cfg.resistance_ohm;
    const double phi = cfg.flux_linkage_wb;
    const double d = r * r + w * w * cfg.inductance_d_h * cfg.inductance_q_h;
    const double scale = phi / cfg.inductance_d_h;
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale, -w * w * cfg.inductance_q_h * phi / d,
                              plant_motor_i_d(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale, -w * r * phi / d, plant_motor_i_q(&motor));
}

TEST(test_voltage_fed_currents_settle_on_the_algebraic_solution)
{
    plant_motor_cfg_t cfg = SALIENT;
    const double v_d = -20.0;
    const double v_q = 95.0;
    const double h = 2.0e-6; /* a stair of vectors: its mean is short by (w h)^2 / 24 = 1e-8 */

    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = 125.6;
    start(&cfg);
    for (long k = 0; k < 500000; k++) {
        const double middle = motor.now.theta_el_rad + 0.5 * h * motor.now.omega_el_rad_s;
        run(h, v_d * cos(middle) - v_q * sin(middle), v_d * sin(middle) + v_q * cos(middle));
    }
    const double w = motor.now.omega_el_rad_s;
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);
    /* Left over of e^(-t R/L_q) = 3e-8, of 100 V; and the ripple of the stair. */
    const double tolerance_v = 2.0e-5;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, v_d,
                              cfg.resistance_ohm * i_d - w * cfg.inductance_q_h * i_q);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, v_q,
                              cfg.resistance_ohm * i_q +
                                  w * (cfg.inductance_d_h * i_d + cfg.flux_linkage_wb));
}

TEST(test_torque_is_that_of_magnet_and_reluctance)
{
    start(&SALIENT);
    motor.now.flux_d_wb = SALIENT.inductance_d_h * -3.0 + SALIENT.flux_linkage_wb;
    motor.now.flux_q_wb = SALIENT.inductance_q_h * 7.0;
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -3.0, plant_motor_i_d(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 7.0, plant_motor_i_q(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 3.0 * (0.375 * 7.0 + (0.0135 - 0.0235) * -3.0 * 7.0),
                              plant_motor_torque(&motor));
}

/* Electrical energy in = stored + copper + friction + load, all but the first integrated here by
 * the trapezoidal rule over h. */
TEST(test_energy_is_conserved)
{
    plant_motor_cfg_t cfg = SALIENT;
    const double h = 1.0e-6;
    double in_j = 0.0;
    double out_j = 0.0;
    plant_vector_t before = {0.0, 0.0};
    double loss_before = 0.0;

    cfg.viscous_friction_nm_s = 0.01;
    cfg.coulomb_friction_nm = 0.05;
    cfg.initial_angle_el_rad = -1.2;
    start(&cfg);
    motor.load_torque_nm = 0.4;
    for (long k = 0; k < 300000; k++) {
        /* A slowly turning vector, switched on and off as by a pulse width modulator. */
        const double on = ((k % 100) < 35) ? 100.0 : 0.0;
        const double angle = 60.0 * (double)k * h;
        const plant_vector_t v = {on * cos(angle), on * sin(angle)};
        run(h, v.alpha, v.beta);
        const plant_vector_t i = plant_motor_current(&motor);
        const double speed = omega_mech();
        const double loss =
            1.5 * cfg.resistance_ohm * (i.alpha * i.alpha + i.beta * i.beta) +
            speed * (cfg.viscous_friction_nm_s * speed + copysign(0.05, speed) + 0.4);
        in_j += 0.75 * h * (v.alpha * (i.alpha + before.alpha) + v.beta * (i.beta + before.beta));
        out_j += 0.5 * h * (loss + loss_before);
        before = i;
        loss_before = loss;
    }
    /* Trapezoidal rule: (h * rate)^2 / 12 = 1e-8 for rate < 400 1/s, and half a step of the friction
     * power at each of some ten reversals. */
    const double tolerance = 1.0e-6;
    TEST_ASSERT_TRUE(in_j > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance * in_j, in_j, out_j + stored_j());
}

TEST(test_viscous_friction_slows_along_the_exponential)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;
    const double t = 1.5;

    cfg.initial_speed_mech_rad_s = 150.0;
    start(&cfg);
    for (int k = 0; k < 15000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
        plant_motor_wrap(&motor);
    }
    const double rate = cfg.viscous_friction_nm_s / cfg.inertia_kg_m2;
    TEST_ASSERT_DOUBLE_WITHIN(150.0 * ROUNDING, 150.0 * exp(-rate * t), omega_mech());
    TEST_ASSERT_DOUBLE_WITHIN(150.0 * ROUNDING, 150.0 / rate * -expm1(-rate * t),
                              plant_motor_angle_mech(&motor));
}

/* w(t) = (w0 + T_C/B) e^(-B t/J) - T_C/B down to zero. */
TEST(test_coulomb_friction_stops_the_shaft_at_the_closed_form_time)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;
    const double step_s = 1.0e-4;

    cfg.coulomb_friction_nm = 0.05;
    cfg.initial_speed_mech_rad_s = -100.0;
    start(&cfg);
    int steps = 0;
    for (; steps < 100000 && omega_mech() != 0.0; steps++) {
        plant_motor_step_open(&motor, step_s);
    }
    const double ratio = cfg.coulomb_friction_nm / cfg.viscous_friction_nm_s;
    const double rate = cfg.viscous_friction_nm_s / cfg.inertia_kg_m2;
    const double stop_s = log1p(100.0 / ratio) / rate;
    const double angle = (100.0 - ratio * log1p(100.0 / ratio)) / rate;
    TEST_ASSERT_DOUBLE_WITHIN(step_s, stop_s, step_s * (double)steps);
    /* Within the last step the friction pushes on for less than a step. */
    const double tolerance = 0.5 * step_s * step_s * 0.05 / cfg.inertia_kg_m2 + 100.0 * ROUNDING;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, -angle, plant_motor_angle_mech(&motor));
}

TEST(test_stiction_holds_exactly_up_to_the_coulomb_torque)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.coulomb_friction_nm = 0.05;
    start(&cfg);
    motor.load_torque_nm = 0.0499;
    for (int k = 0; k < 1000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
    }
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(motor.now.theta_el_rad == 0.0);

    motor.load_torque_nm = -0.0499;
    plant_motor_step_open(&motor, 1.0e-4);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
}

TEST(test_beyond_the_coulomb_torque_the_rest_accelerates)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.coulomb_friction_nm = 0.05;
    cfg.viscous_friction_nm_s = 0.0;
    start(&cfg);
    motor.load_torque_nm = 0.06;
    for (int k = 0; k < 1000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
    }
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -0.1 * 0.01 / cfg.inertia_kg_m2, omega_mech());
}

TEST(test_stiction_holds_against_the_torque_of_a_current)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;
    const double torque_per_amp = 1.5 * 2.0 * 0.387;

    cfg.coulomb_friction_nm = 0.5;
    start(&cfg);
    const double v = 0.9 * 0.5 / torque_per_amp * cfg.resistance_ohm;
    run(0.2, 0.0, v);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    run(0.2, 0.0, 1.2 * v);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s > 0.0);
}

TEST(test_reversal_under_load_passes_zero_without_sticking)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.coulomb_friction_nm = 0.05;
    cfg.viscous_friction_nm_s = 0.0;
    cfg.initial_speed_mech_rad_s = 10.0;
    start(&cfg);
    motor.load_torque_nm = 0.2;
    for (int k = 0; k < 3000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
    }
    /* Down with 0.25 N m in 0.12 s, away with 0.15 N m for the other 0.18 s. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-8, -0.15 / cfg.inertia_kg_m2 * 0.18, omega_mech());
}

/* One run with modulated voltage from a standing or turning start, each interval in so many parts. */
static plant_motor_t modulated_run(const plant_motor_cfg_t *cfg, double period_s, double v,
                                   int parts)
{
    start(cfg);
    for (int k = 0; k < 400; k++) {
        const double angle = cfg->initial_angle_el_rad + 2.0 + 0.05 * (double)k;
        for (int p = 0; p < parts; p++) {
            run(0.6 * period_s / parts, v * cos(angle), v * sin(angle));
        }
        for (int p = 0; p < parts; p++) {
            run(0.4 * period_s / parts, 0.0, 0.0);
        }
    }
    return motor;
}

static void check_independence_of_step(const plant_motor_cfg_t *cfg, double period_s, double v,
                                       double accuracy)
{
    const plant_motor_t coarse = modulated_run(cfg, period_s, v, 1);
    const plant_motor_t fine = modulated_run(cfg, period_s, v, 16);
    const double scale_a = cfg->flux_linkage_wb / cfg->inductance_d_h;
    const double speed = fmax(fabs(fine.now.omega_el_rad_s), 1.0);

    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_d(&fine), plant_motor_i_d(&coarse));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_q(&fine), plant_motor_i_q(&coarse));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * speed, fine.now.omega_el_rad_s, coarse.now.omega_el_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(accuracy, fine.now.theta_el_rad, coarse.now.theta_el_rad);
}

TEST(test_result_does_not_depend_on_the_step_for_the_round_rotor)
{
    check_independence_of_step(&ROUND_ROTOR, 1.0e-4, 100.0, ACCURACY);
}

TEST(test_result_does_not_depend_on_the_step_for_the_salient_rotor)
{
    check_independence_of_step(&SALIENT, 1.0e-4, 60.0, ACCURACY);
}

TEST(test_result_does_not_depend_on_the_step_for_a_drone_motor)
{
    check_independence_of_step(&DRONE, 2.5e-5, 8.0, ACCURACY_DRONE);
}

TEST(test_angle_counts_turns_both_ways_and_its_cosine_stays_true)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    for (int sign = -1; sign <= 1; sign += 2) {
        cfg.initial_speed_mech_rad_s = sign * 100.0;
        cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
        cfg.initial_angle_el_rad = 1.0;
        start(&cfg);
        for (int k = 0; k < 100000; k++) {
            plant_motor_step_open(&motor, 1.0e-4);
            plant_motor_wrap(&motor);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1000.0 * ROUNDING, 0.5 + sign * 1000.0,
                                  plant_motor_angle_mech(&motor));
        TEST_ASSERT_TRUE(fabs(motor.now.theta_el_rad) <= PLANT_PI);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, cos(motor.now.theta_el_rad), motor.now.cosine);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, sin(motor.now.theta_el_rad), motor.now.sine);
    }
}

TEST(test_rotation_agrees_with_the_library)
{
    for (int k = -2000; k <= 2000; k++) {
        const double angle = 0.01 * k + 1.0e-3 * k * k;
        const plant_rotation_t r = plant_rotation_from_angle(angle);
        /* As rotation.h states: the reduction to one turn loses 2^-52 of the angle. */
        const double tolerance = 1.0e-14 + fabs(angle) * 0x1p-52;
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, cos(angle), r.cosine);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, sin(angle), r.sine);
    }
}

static void check_rejected(const plant_motor_cfg_t *cfg, const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_motor_init(&motor, cfg, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;
    cfg.pole_pairs = 0;
    check_rejected(&cfg, "motor.pole_pairs");
    cfg = ROUND_ROTOR;
    cfg.resistance_ohm = -1.0;
    check_rejected(&cfg, "motor.resistance_ohm");
    cfg = ROUND_ROTOR;
    cfg.inductance_q_h = 0.0;
    check_rejected(&cfg, "motor.inductance_q_h");
    cfg = ROUND_ROTOR;
    cfg.inertia_kg_m2 = (double)NAN;
    check_rejected(&cfg, "motor.inertia_kg_m2");
    cfg = ROUND_ROTOR;
    cfg.initial_angle_el_rad = 1.0e7;
    check_rejected(&cfg, "motor.initial_angle_el_rad");
}
