/* SPDX-License-Identifier: MIT */
/* The simulated motor against closed forms, its energy balance and itself with finer steps. */
#include "plant_motor_rig.h"

void setUp(void)
{
    cfg = ROUND_ROTOR;
}

static double stored_j(void)
{
    return linear_j() + kinetic_j();
}

/* The salient motor at a speed that nothing changes. */
static void start_salient(double speed_mech_rad_s)
{
    cfg = SALIENT;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = speed_mech_rad_s;
    start();
}

TEST(test_locked_rotor_current_rises_along_the_exponential_of_its_axis)
{
    const double v = 10.0;
    const double t = 0.02;
    const double i_end = v / SALIENT.resistance_ohm;
    const double i_d = i_end * -expm1(-t * SALIENT.resistance_ohm / SALIENT.inductance_d_h);
    const double i_q = i_end * -expm1(-t * SALIENT.resistance_ohm / SALIENT.inductance_q_h);

    start_salient(0.0);
    run(t, v, 0.0);
    check_current(ACCURACY * i_end, i_d, 0.0);
    start();
    run(t, 0.0, v);
    check_current(ACCURACY * i_end, 0.0, i_q);
}

TEST(test_voltage_fed_currents_settle_on_the_algebraic_solution)
{
    const double v_d = -20.0;
    const double v_q = 95.0;
    const double h = 2.0e-6; /* a stair of vectors: its mean is short by (w h)^2 / 24 = 1e-8 */

    start_salient(125.6);
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
    cfg = SALIENT;
    start();
    motor.now.flux_d_wb = SALIENT.inductance_d_h * -3.0 + SALIENT.flux_linkage_wb;
    motor.now.flux_q_wb = SALIENT.inductance_q_h * 7.0;
    check_current(ROUNDING, -3.0, 7.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 3.0 * (0.375 * 7.0 + (0.0135 - 0.0235) * -3.0 * 7.0),
                              plant_motor_torque(&motor));
}

TEST(test_energy_is_conserved)
{
    cfg = SALIENT;
    check_energy(stored_j);
}

TEST(test_viscous_friction_slows_along_the_exponential)
{
    const double t = 1.5;

    cfg.initial_speed_mech_rad_s = 150.0;
    start();
    coast(15000, 1.0e-4);
    const double rate = cfg.viscous_friction_nm_s / cfg.inertia_kg_m2;
    TEST_ASSERT_DOUBLE_WITHIN(150.0 * ROUNDING, 150.0 * exp(-rate * t), omega_mech());
    TEST_ASSERT_DOUBLE_WITHIN(150.0 * ROUNDING, 150.0 / rate * -expm1(-rate * t),
                              plant_motor_angle_mech(&motor));
}

/* w(t) = (w0 + T_C/B) e^(-B t/J) - T_C/B down to zero. */
TEST(test_coulomb_friction_stops_the_shaft_at_the_closed_form_time)
{
    const double step_s = 1.0e-4;

    cfg.coulomb_friction_nm = 0.05;
    cfg.initial_speed_mech_rad_s = -100.0;
    start();
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

TEST(test_stiction_holds_exactly_up_to_the_coulomb_torque_and_the_rest_accelerates)
{
    cfg.coulomb_friction_nm = 0.05;
    cfg.viscous_friction_nm_s = 0.0;
    start();
    motor.load_torque_nm = 0.0499;
    coast(1000, 1.0e-4);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(motor.now.theta_el_rad == 0.0);
    motor.load_torque_nm = -0.0499;
    coast(1, 1.0e-4);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    motor.load_torque_nm = 0.06;
    coast(1000, 1.0e-4);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, -0.1 * 0.01 / cfg.inertia_kg_m2, omega_mech());
}

TEST(test_stiction_holds_against_the_torque_of_a_current)
{
    const double torque_per_amp = 1.5 * 2.0 * 0.387;

    cfg.coulomb_friction_nm = 0.5;
    start();
    const double v = 0.9 * 0.5 / torque_per_amp * cfg.resistance_ohm;
    run(0.2, 0.0, v);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    run(0.2, 0.0, 1.2 * v);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s > 0.0);
}

TEST(test_reversal_under_load_passes_zero_without_sticking)
{
    cfg.coulomb_friction_nm = 0.05;
    cfg.viscous_friction_nm_s = 0.0;
    cfg.initial_speed_mech_rad_s = 10.0;
    start();
    motor.load_torque_nm = 0.2;
    coast(3000, 1.0e-4);
    /* Down with 0.25 N m in 0.12 s, away with 0.15 N m for the other 0.18 s. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-8, -0.15 / cfg.inertia_kg_m2 * 0.18, omega_mech());
}

TEST(test_result_does_not_depend_on_the_step)
{
    check_independence_of_step(1.0e-4, 100.0, ACCURACY);
    cfg = SALIENT;
    check_independence_of_step(1.0e-4, 60.0, ACCURACY);
    cfg = DRONE;
    check_independence_of_step(2.5e-5, 8.0, ACCURACY_DRONE);
}

TEST(test_angle_counts_turns_both_ways_and_its_cosine_stays_true)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        cfg.initial_speed_mech_rad_s = sign * 100.0;
        cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
        cfg.initial_angle_el_rad = 1.0;
        start();
        coast(100000, 1.0e-4);
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

TEST(test_init_names_the_field_that_is_out_of_range)
{
    CHECK_REFUSED(pole_pairs, 0);
    CHECK_REFUSED(resistance_ohm, -1.0);
    CHECK_REFUSED(inductance_q_h, 0.0);
    CHECK_REFUSED(inertia_kg_m2, (double)NAN);
    CHECK_REFUSED(initial_angle_el_rad, 1.0e7);
}
