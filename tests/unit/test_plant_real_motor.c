/* SPDX-License-Identifier: MIT */
/* A real motor beyond an ideal one: closed forms, its energy, and itself with finer steps. */
#include "plant_motor_rig.h"

#include <complex.h>

#define EMF_5TH 0.05
#define EMF_7TH 0.03
#define COGGING_NM 0.2
#define COGGING_ORDER 24U
#define FALL_D 0.2
#define FALL_Q 0.3
#define SHARED 0.8
#define SATURATION_A 4.0
#define LOAD_KG_M2 0.02
#define STIFFNESS_NM 900.0
#define DAMPING_NM_S 0.05

enum {
    HARMONICS = 1,
    COGGING = 2,
    SATURATION = 4,
    SHAFT = 8,
    EVERYTHING = 15
};

/* cfg becomes the salient one with these parts. */
static void take(unsigned parts)
{
    cfg = SALIENT;
    if ((parts & HARMONICS) != 0U) {
        cfg.emf_5th = EMF_5TH;
        cfg.emf_7th = EMF_7TH;
    }
    if ((parts & COGGING) != 0U) {
        cfg.cogging_nm = COGGING_NM;
        cfg.cogging_order = COGGING_ORDER;
    }
    if ((parts & SATURATION) != 0U) {
        cfg.saturation_d = FALL_D;
        cfg.saturation_q = FALL_Q;
        cfg.saturation_shared = SHARED;
        cfg.saturation_a = SATURATION_A;
    }
    if ((parts & SHAFT) != 0U) {
        cfg.load_inertia_kg_m2 = LOAD_KG_M2;
        cfg.shaft_stiffness_nm = STIFFNESS_NM;
        cfg.shaft_damping_nm_s = DAMPING_NM_S;
    }
}

/* Flux linkage of a current alone, rotor frame. */
static plant_dq_t own_flux(double i_d, double i_q)
{
    const plant_dq_t linear = {motor.inductance_d_h * i_d, motor.inductance_q_h * i_q};

    return motor.iron.saturates ? plant_iron_flux(&motor.iron, (plant_dq_t){i_d, i_q}) : linear;
}

/* Sets the current, rotor frame, and leaves all else. */
static void set_current(double i_d, double i_q)
{
    const plant_dq_t before = own_flux(plant_motor_i_d(&motor), plant_motor_i_q(&motor));
    const plant_dq_t after = own_flux(i_d, i_q);

    motor.now.flux_d_wb += after.d - before.d;
    motor.now.flux_q_wb += after.q - before.q;
}

/* Magnetic energy of saturated iron by the formula of iron.h. */
static double magnetic_j(void)
{
    const double g_d = FALL_D / ((1.0 - FALL_D) * (1.0 - FALL_D) * (4.0 - FALL_D));
    const double g_q = FALL_Q / pow(1.0 - FALL_Q, 3.0);
    const double scale_d = motor.inductance_d_h * SATURATION_A;
    const double scale_q = motor.inductance_q_h * SATURATION_A;
    const double common = SHARED * 2.0 * sqrt(g_d * g_q * scale_d * scale_q);
    const plant_dq_t flux = own_flux(plant_motor_i_d(&motor), plant_motor_i_q(&motor));
    const double x = flux.d / scale_d;
    const double y = flux.q / scale_q;
    const double d = 0.5 * x * x + g_d * (x * x * x + 0.25 * x * x * x * x);
    const double q = 0.5 * y * y + 0.25 * g_q * y * y * y * y;
    return 1.5 * SATURATION_A *
           (scale_d * d + scale_q * q + 0.5 * common * (x + 0.5 * x * x) * y * y);
}

/* ---- EMF harmonics ---- */

TEST(test_emf_of_each_phase_has_its_harmonics)
{
    double emf_v[PLANT_LEGS];

    take(HARMONICS);
    cfg.initial_speed_mech_rad_s = 100.0;
    const double peak_v = 100.0 * cfg.pole_pairs * cfg.flux_linkage_wb;
    for (int k = 0; k < 60; k++) {
        cfg.initial_angle_el_rad = 0.11 * k - 3.0;
        start();
        check_current(ROUNDING, 0.0, 0.0);
        plant_phases(plant_motor_emf(&motor), emf_v);
        for (int phase = 0; phase < PLANT_LEGS; phase++) {
            const double x = cfg.initial_angle_el_rad - PLANT_TWO_PI / 3.0 * phase;
            const double shape = sin(x) + EMF_5TH * sin(5.0 * x) + EMF_7TH * sin(7.0 * x);
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING * peak_v, -peak_v * shape, emf_v[phase]);
        }
        plant_motor_step_open(&motor, 1.0e-4);
        check_current(ROUNDING, 0.0, 0.0);
    }
}

/* The EMF takes the mechanical power, at any angle and current; reluctance has its own. */
TEST(test_torque_has_the_power_of_emf_and_current)
{
    const double i_d = -3.0;
    const double i_q = 7.0;

    take(HARMONICS);
    cfg.initial_speed_mech_rad_s = 50.0;
    for (int k = 0; k < 60; k++) {
        cfg.initial_angle_el_rad = 0.11 * k - 3.0;
        start();
        set_current(i_d, i_q);
        const plant_vector_t e = plant_motor_emf(&motor);
        const plant_vector_t i = plant_motor_current(&motor);
        const double power_w = 1.5 * (e.alpha * i.alpha + e.beta * i.beta);
        const double reluctance_nm =
            1.5 * cfg.pole_pairs * (cfg.inductance_d_h - cfg.inductance_q_h) * i_d * i_q;
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, power_w / 50.0 + reluctance_nm,
                                  plant_motor_torque(&motor));
    }
}

/*
 * Shorted windings of a magnet that turns: the wave of order 6 in the rotor frame is a motor of its
 * own. With L_d = L_q the current is the sum of three: I_n = -E_n / (R + j n w L) of orders 1, -5
 * and 7.
 */
TEST(test_short_circuit_current_is_the_sum_of_its_harmonics)
{
    const double orders[] = {1.0, -5.0, 7.0};
    const double shares[] = {1.0, EMF_5TH, EMF_7TH};
    const double complex j = (double complex)I;
    double complex wanted = 0.0;

    take(HARMONICS);
    cfg.inductance_q_h = cfg.inductance_d_h;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = 40.0;
    start();
    for (int k = 0; k < 10000; k++) {
        run(1.0e-4, 0.0, 0.0); /* 30 time constants */
    }
    const double w = motor.now.omega_el_rad_s;
    for (int n = 0; n < 3; n++) {
        /* E_n = j w phi h_n (sign of n) e^(j n theta): phases a of all rise together. */
        const double e = copysign(w * cfg.flux_linkage_wb * shares[n], orders[n]);
        const double complex emf = j * e * cexp(j * orders[n] * motor.now.theta_el_rad);
        wanted -= emf / (cfg.resistance_ohm + j * orders[n] * w * cfg.inductance_d_h);
    }
    const plant_vector_t i = plant_motor_current(&motor);
    const double scale_a = cfg.flux_linkage_wb / cfg.inductance_d_h;
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale_a, creal(wanted), i.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale_a, cimag(wanted), i.beta);
}

/* ---- cogging ---- */

TEST(test_cogging_is_a_sine_of_the_shaft_whatever_the_turn)
{
    take(COGGING);
    cfg.cogging_order = 7; /* no multiple of the pole pairs: another one in each electrical turn */
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_angle_el_rad = 1.0;
    cfg.initial_speed_mech_rad_s = -110.0;
    start();
    for (int k = 0; k < 1031; k++) {
        const double wanted = -COGGING_NM * sin(7.0 * plant_motor_angle_mech(&motor));
        TEST_ASSERT_DOUBLE_WITHIN(1000.0 * ROUNDING, wanted, plant_motor_torque(&motor));
        coast(97, 1.0e-4);
    }
}

/* What the cogging takes from the kinetic energy of a free shaft it gives back in a turn. */
TEST(test_cogging_is_conservative)
{
    const double hill_j = COGGING_NM / COGGING_ORDER;

    take(COGGING);
    cfg.initial_speed_mech_rad_s = 2.0;
    start();
    const double at_first_j = kinetic_j();
    double least_j = at_first_j;
    while (plant_motor_angle_mech(&motor) < 2.0 * PLANT_PI) {
        coast(1, 1.0e-4);
        const double hill = hill_j * (1.0 - cos(COGGING_ORDER * plant_motor_angle_mech(&motor)));
        TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * hill_j, at_first_j, kinetic_j() + hill);
        least_j = fmin(least_j, kinetic_j());
    }
    /* The tops have been there. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * hill_j, at_first_j - 2.0 * hill_j, least_j);
}

TEST(test_cogging_holds_a_load_where_its_torque_is_the_load)
{
    const double load_nm = -0.7 * COGGING_NM;

    take(COGGING);
    cfg.viscous_friction_nm_s = 0.1; /* a tenth of a second */
    start();
    motor.load_torque_nm = load_nm;
    coast(100000, 1.0e-4);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, asin(-load_nm / COGGING_NM) / COGGING_ORDER,
                              plant_motor_angle_mech(&motor));
    motor.load_torque_nm = -1.01 * COGGING_NM;
    coast(100000, 1.0e-4);
    TEST_ASSERT_TRUE(plant_motor_angle_mech(&motor) > PLANT_PI / COGGING_ORDER);
}

/* At rest within the dry friction of the slope it stands on, exactly; a little more and it goes. */
TEST(test_stiction_holds_on_a_slope_of_the_cogging)
{
    const double mech_rad = 0.02;
    const double slope_nm = COGGING_NM * sin(COGGING_ORDER * mech_rad);

    take(COGGING);
    cfg.initial_angle_el_rad = cfg.pole_pairs * mech_rad;
    cfg.coulomb_friction_nm = 1.001 * slope_nm;
    start();
    for (int k = 0; k < 1000; k++) {
        run(1.0e-4, 0.0, 0.0);
    }
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    cfg.coulomb_friction_nm = 0.999 * slope_nm;
    start();
    run(1.0e-4, 0.0, 0.0);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s < 0.0);
}

/* In a valley, between two angles of |cogging| = friction. */
TEST(test_swings_end_where_the_friction_holds)
{
    take(COGGING);
    cfg.initial_angle_el_rad = cfg.pole_pairs * 2.0 / COGGING_ORDER;
    cfg.coulomb_friction_nm = 0.1 * COGGING_NM;
    start();
    coast(20000, 1.0e-4);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(fabs(plant_motor_torque(&motor)) <= cfg.coulomb_friction_nm);
    TEST_ASSERT_TRUE(fabs(plant_motor_angle_mech(&motor)) < 1.0 / COGGING_ORDER);
}

/* ---- saturation ---- */

/* Without resistance the flux is the integral of the voltage, and the current is the map's. */
TEST(test_current_of_a_blocked_rotor_is_that_of_its_volt_seconds)
{
    const double v_d = -3.0;
    const double v_q = 10.0;

    take(SATURATION);
    cfg.resistance_ohm = 0.0;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    start();
    for (int k = 1; k <= 200; k++) {
        run(1.0e-4, v_d, v_q);
        const plant_dq_t flux = {v_d * 1.0e-4 * k, v_q * 1.0e-4 * k};
        const plant_dq_t i = plant_iron_current(&motor.iron, flux);
        check_current(ACCURACY * SATURATION_A, i.d, i.q);
    }
    /* Some rated currents, where L_q has fallen by more than a third. */
    const double i_q = plant_motor_i_q(&motor);
    TEST_ASSERT_TRUE(v_q * 0.02 / i_q < 0.67 * cfg.inductance_q_h);
}

/* The work of a small turn at constant flux linkages of the phases is what the field loses. */
TEST(test_torque_is_what_the_field_loses_in_a_turn)
{
    const double h = 1.0e-5; /* electrical rad: h^2 / 6 of a torque that turns over in 1 rad */

    take(SATURATION);
    for (int k = -5; k <= 5; k++) {
        double field_j[2];
        start();
        set_current(1.3 * k, 6.0 - k);
        const double torque_nm = plant_motor_torque(&motor);
        const double d = motor.now.flux_d_wb;
        const double q = motor.now.flux_q_wb;
        for (int side = 0; side < 2; side++) {
            const double turn = (side == 0) ? -h : h;
            motor.now.flux_d_wb = d * cos(turn) + q * sin(turn);
            motor.now.flux_q_wb = q * cos(turn) - d * sin(turn);
            field_j[side] = magnetic_j();
        }
        const double lost_nm = cfg.pole_pairs * (field_j[0] - field_j[1]) / (2.0 * h);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-8 * fabs(torque_nm) + 1.0e-9, lost_nm, torque_nm);
    }
}

TEST(test_a_phase_that_stops_conducting_has_no_current)
{
    const plant_vector_t axis = {-0.5, 0.5 * PLANT_SQRT3};

    take(EVERYTHING);
    start();
    set_current(-9.0, 12.0);
    plant_motor_clear_phase(&motor, axis);
    const plant_vector_t i = plant_motor_current(&motor);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0, i.alpha * axis.alpha + i.beta * axis.beta);
    /* The impulse along the axis leaves the flux linkage across it. */
    TEST_ASSERT_TRUE(hypot(i.alpha, i.beta) > 1.0);
}

/* With that potential at its terminal the phase gets no current, wherever the rotor is. */
TEST(test_the_potential_of_a_floating_phase_holds_its_current)
{
    const plant_vector_t axis = {1.0, 0.0};
    const double h = 1.0e-8;

    take(EVERYTHING);
    cfg.initial_speed_mech_rad_s = 30.0;
    for (int k = 0; k < 30; k++) {
        cfg.initial_angle_el_rad = 0.2 * k;
        start();
        set_current(9.0 * sin(cfg.initial_angle_el_rad), 9.0 * cos(cfg.initial_angle_el_rad));
        const plant_vector_t v = {0.0, 100.0};
        const double p = plant_motor_floating_potential(&motor, v, axis);
        run(h, 2.0 / 3.0 * p, v.beta);
        /* Of the currents of b and c, some 10^4 A/s, all but what the second order leaves. */
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * 1.0e4 * h, 0.0, plant_motor_current(&motor).alpha);
    }
}

/* Of two phases in series the flux along their axis is the volt-seconds, less those of R. */
TEST(test_a_floating_phase_stays_without_current)
{
    const plant_vector_t axis = {1.0, 0.0};
    const plant_vector_t v = {0.0, 310.0 / PLANT_SQRT3};

    take(EVERYTHING);
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_angle_el_rad = 0.4;
    cfg.initial_speed_mech_rad_s = 30.0;
    start();
    double flux = motor.now.flux_d_wb * motor.now.sine + motor.now.flux_q_wb * motor.now.cosine;
    for (int k = 0; k < 300; k++) {
        const double before_a = plant_motor_current(&motor).beta;
        plant_motor_step_tied(&motor, 1.0e-6, v, axis);
        const plant_vector_t i = plant_motor_current(&motor);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0, i.alpha);
        flux += 1.0e-6 * (v.beta - 0.5 * cfg.resistance_ohm * (before_a + i.beta));
    }
    TEST_ASSERT_TRUE(plant_motor_current(&motor).beta > SATURATION_A / 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, flux,
                              motor.now.flux_d_wb * motor.now.sine +
                                  motor.now.flux_q_wb * motor.now.cosine);
}

/* ---- all together ---- */

/* Magnetic energy, kinetic energy of both masses, and what is in cogging and shaft. */
static double stored_j(void)
{
    const double hill =
        COGGING_NM / COGGING_ORDER * (1.0 - cos(COGGING_ORDER * plant_motor_angle_mech(&motor)));
    const double load = motor.now.load_speed_rad_s;
    const double twist = motor.now.twist_rad;

    return magnetic_j() + hill + kinetic_j() + 0.5 * LOAD_KG_M2 * load * load +
           0.5 * STIFFNESS_NM * twist * twist;
}

TEST(test_energy_is_conserved)
{
    take(EVERYTHING);
    check_energy(stored_j);
}

TEST(test_result_does_not_depend_on_the_step)
{
    take(EVERYTHING);
    cfg.initial_speed_mech_rad_s = 150.0;
    check_independence_of_step(1.0e-4, 60.0, ACCURACY);
}

/* Beyond 30 times the stated current the inductances have fallen to hundredths: R/L has risen. */
TEST(test_result_does_not_depend_on_the_step_deep_in_saturation)
{
    take(SATURATION);
    cfg.saturation_q = PLANT_IRON_FALL_Q_MAX;
    cfg.saturation_a = 0.5;
    check_independence_of_step(1.0e-4, 60.0, ACCURACY);
    TEST_ASSERT_TRUE(hypot(plant_motor_i_d(&motor), plant_motor_i_q(&motor)) >
                     30.0 * cfg.saturation_a);
}

TEST(test_result_does_not_depend_on_the_step_for_a_drone_motor)
{
    cfg = DRONE;
    cfg.emf_5th = EMF_5TH;
    cfg.emf_7th = EMF_7TH;
    cfg.cogging_nm = 0.01;
    cfg.cogging_order = 42;
    check_independence_of_step(2.5e-5, 8.0, ACCURACY_DRONE);
    cfg.cogging_order = 420; /* cogs much faster than all else: 13 rad in a period */
    check_independence_of_step(2.5e-5, 8.0, ACCURACY_DRONE);
}

/* Another method of another order; of cogging or saturation there is a rounding. */
TEST(test_a_motor_with_next_to_nothing_is_the_ideal_one)
{
    plant_motor_t runs[3];

    for (int k = 0; k < 3; k++) {
        cfg = SALIENT;
        cfg.viscous_friction_nm_s = 0.01;
        cfg.initial_speed_mech_rad_s = 150.0;
        cfg.cogging_nm = (k == 1) ? 1.0e-15 : 0.0;
        cfg.cogging_order = 1;
        cfg.saturation_d = (k == 2) ? 1.0e-15 : 0.0;
        cfg.saturation_q = cfg.saturation_d;
        cfg.saturation_a = SATURATION_A;
        runs[k] = modulated_run(1.0e-4, 60.0, 1);
        TEST_ASSERT_EQUAL(k > 0, runs[k].is_real);
        check_same(&runs[0], &runs[k], ACCURACY);
    }
}

TEST(test_a_turned_rotor_keeps_its_phase_currents_and_finds_its_cogging)
{
    take(EVERYTHING);
    start();
    set_current(2.0, -5.0);
    const plant_vector_t before = plant_motor_current(&motor);
    plant_motor_turn(&motor, 1.3);
    const plant_vector_t after = plant_motor_current(&motor);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, before.alpha, after.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, before.beta, after.beta);
    set_current(0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -COGGING_NM * sin(COGGING_ORDER * 0.5 * 1.3),
                              plant_motor_torque(&motor));
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    take(EVERYTHING);
    CHECK_REFUSED(emf_5th, -0.6);
    CHECK_REFUSED(emf_7th, (double)NAN);
    CHECK_REFUSED(saturation_d, 0.31);
    CHECK_REFUSED(saturation_q, -0.1);
    CHECK_REFUSED(saturation_a, 0.0);
    CHECK_REFUSED(cogging_nm, -1.0);
    CHECK_REFUSED(cogging_order, 0);
    cfg.saturation_d = 0.3;
    cfg.saturation_q = 0.5;
    cfg.inductance_q_h = 0.5 * cfg.inductance_d_h;
    const double shared = 1.01 * plant_motor_shared_max(&cfg);
    TEST_ASSERT_TRUE(shared < 1.0);
    CHECK_REFUSED(saturation_shared, shared);
}
