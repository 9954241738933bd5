/* SPDX-License-Identifier: MIT */
/* What a real motor has beyond an ideal one: closed forms, its energy balance, and itself with finer steps. */
#include "motor.h"
#include "testing.h"

#include <math.h>
#include <stddef.h>

/* Error of a transient relative to the scale of its currents, as motor.h states it. */
#define ACCURACY 1.0e-6
#define ACCURACY_DRONE 1.0e-5

/* Sums of some 10^5 roundings of 2^-53. */
#define ROUNDING 1.0e-10

#define INERTIA_OF_A_WALL 1.0e9

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

static const plant_motor_cfg_t IDEAL = {
    .pole_pairs = 2,
    .resistance_ohm = 0.405,
    .inductance_d_h = 0.0135,
    .inductance_q_h = 0.0235,
    .flux_linkage_wb = 0.375,
    .inertia_kg_m2 = 0.011,
};

/* 7 pole pairs, time constant 0.4 ms, 12 000 rpm, 42 cogs a turn. */
static const plant_motor_cfg_t DRONE = {
    .pole_pairs = 7,
    .resistance_ohm = 0.05,
    .inductance_d_h = 20.0e-6,
    .inductance_q_h = 26.0e-6,
    .flux_linkage_wb = 0.9e-3,
    .inertia_kg_m2 = 2.0e-6,
    .viscous_friction_nm_s = 1.0e-6,
    .emf_5th = EMF_5TH,
    .emf_7th = EMF_7TH,
    .cogging_nm = 0.01,
    .cogging_order = 42,
    .initial_speed_mech_rad_s = 1256.0,
};

static plant_motor_t motor;

static void start(const plant_motor_cfg_t *cfg)
{
    const char *bad = NULL;

    TEST_ASSERT_TRUE_MESSAGE(plant_motor_init(&motor, cfg, &bad), bad);
}

static plant_motor_cfg_t with_harmonics(void)
{
    plant_motor_cfg_t cfg = IDEAL;

    cfg.emf_5th = EMF_5TH;
    cfg.emf_7th = EMF_7TH;
    return cfg;
}

static plant_motor_cfg_t with_cogging(void)
{
    plant_motor_cfg_t cfg = IDEAL;

    cfg.cogging_nm = COGGING_NM;
    cfg.cogging_order = COGGING_ORDER;
    return cfg;
}

static plant_motor_cfg_t with_saturation(void)
{
    plant_motor_cfg_t cfg = IDEAL;

    cfg.saturation_d = FALL_D;
    cfg.saturation_q = FALL_Q;
    cfg.saturation_shared = SHARED;
    cfg.saturation_a = SATURATION_A;
    return cfg;
}

static plant_motor_cfg_t with_everything(void)
{
    plant_motor_cfg_t cfg = with_saturation();

    cfg.emf_5th = EMF_5TH;
    cfg.emf_7th = EMF_7TH;

    cfg.cogging_nm = COGGING_NM;
    cfg.cogging_order = COGGING_ORDER;
    cfg.load_inertia_kg_m2 = LOAD_KG_M2;
    cfg.shaft_stiffness_nm = STIFFNESS_NM;
    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    return cfg;
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

/* Of a phase whose axis is at an angle; currents and EMF have no zero sequence. */
static double along(plant_vector_t v, double angle)
{
    return v.alpha * cos(angle) + v.beta * sin(angle);
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

/* Magnetic energy by the formula of iron.h; for constant inductances, the usual one. */
static double magnetic_j(void)
{
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);
    if (!motor.iron.saturates) {
        return 0.75 * (motor.inductance_d_h * i_d * i_d + motor.inductance_q_h * i_q * i_q);
    }
    const double g_d = FALL_D / ((1.0 - FALL_D) * (1.0 - FALL_D) * (4.0 - FALL_D));
    const double g_q = FALL_Q / pow(1.0 - FALL_Q, 3.0);
    const double scale_d = motor.inductance_d_h * SATURATION_A;
    const double scale_q = motor.inductance_q_h * SATURATION_A;
    const double common = SHARED * 2.0 * sqrt(g_d * g_q * scale_d * scale_q);
    const plant_dq_t flux = own_flux(i_d, i_q);
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
    plant_motor_cfg_t cfg = with_harmonics();
    const double speed = 100.0;

    for (int k = 0; k < 60; k++) {
        cfg.initial_angle_el_rad = 0.11 * k - 3.0;
        cfg.initial_speed_mech_rad_s = speed;
        start(&cfg);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0, plant_motor_i_d(&motor));
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0, plant_motor_i_q(&motor));
        const double peak = speed * cfg.pole_pairs * cfg.flux_linkage_wb;
        for (int phase = 0; phase < 3; phase++) {
            const double axis = 2.0 * PLANT_PI / 3.0 * phase;
            const double x = cfg.initial_angle_el_rad - axis;
            const double wanted =
                -peak * (sin(x) + EMF_5TH * sin(5.0 * x) + EMF_7TH * sin(7.0 * x));
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING * peak, wanted,
                                      along(plant_motor_emf(&motor), axis));
        }
    }
}

/* The electrical power that the EMF takes is the mechanical one, at any angle and current; reluctance has its own. */
TEST(test_torque_has_the_power_of_emf_and_current)
{
    plant_motor_cfg_t cfg = with_harmonics();
    const double i_d = -3.0;
    const double i_q = 7.0;

    cfg.initial_speed_mech_rad_s = 50.0;
    for (int k = 0; k < 60; k++) {
        cfg.initial_angle_el_rad = 0.11 * k - 3.0;
        start(&cfg);
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

/* Without current the terminals show the EMF: the voltage that holds the current at zero in the next moment. */
TEST(test_the_emf_as_voltage_keeps_the_current_away)
{
    plant_motor_cfg_t cfg = with_harmonics();
    const double h = 1.0e-7;

    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = 100.0;
    start(&cfg);
    for (int k = 0; k < 200000; k++) {
        const plant_vector_t before = plant_motor_emf(&motor);
        const plant_motor_t here = motor;
        plant_motor_step_open(&motor, h);
        TEST_ASSERT_TRUE(fabs(plant_motor_i_d(&motor)) + fabs(plant_motor_i_q(&motor)) <= ROUNDING);
        const plant_vector_t after = plant_motor_emf(&motor);
        motor = here;
        run(h, 0.5 * (before.alpha + after.alpha), 0.5 * (before.beta + after.beta));
    }
    /* Of the volts of the 7th, 7 w h each trapezoid, squared and / 12, some remain over a turn; and roundings. */
    const double tolerance_a = 1.0e-6;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, 0.0, plant_motor_i_d(&motor));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, 0.0, plant_motor_i_q(&motor));
}

/* Shorted windings of a magnet that turns: the wave of order 6 in the rotor frame is a motor of its own. With L_d = L_q
 * the current is the sum of three: I_n = -E_n / (R + j n w L) of orders 1, -5 and 7. */
TEST(test_short_circuit_current_is_the_sum_of_its_harmonics)
{
    plant_motor_cfg_t cfg = with_harmonics();
    const double orders[] = {1.0, -5.0, 7.0};
    const double shares[] = {1.0, EMF_5TH, EMF_7TH};
    double alpha = 0.0;
    double beta = 0.0;

    cfg.inductance_q_h = cfg.inductance_d_h;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_speed_mech_rad_s = 40.0;
    start(&cfg);
    for (int k = 0; k < 10000; k++) {
        run(1.0e-4, 0.0, 0.0); /* 30 time constants */
    }
    const double w = motor.now.omega_el_rad_s;
    for (int n = 0; n < 3; n++) {
        /* E_n = j w phi h_n (sign of n) e^(j n theta): phases a of all rise together. */
        const double x = orders[n] * w * cfg.inductance_d_h;
        const double z2 = cfg.resistance_ohm * cfg.resistance_ohm + x * x;
        const double e = copysign(w * cfg.flux_linkage_wb * shares[n], orders[n]);
        const double a = orders[n] * motor.now.theta_el_rad;
        /* -j e (R - j x) / |Z|^2 = e (-x - j R) / |Z|^2. */
        alpha += e / z2 * (-x * cos(a) + cfg.resistance_ohm * sin(a));
        beta += e / z2 * (-x * sin(a) - cfg.resistance_ohm * cos(a));
    }
    const plant_vector_t i = plant_motor_current(&motor);
    const double scale_a = cfg.flux_linkage_wb / cfg.inductance_d_h;
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale_a, alpha, i.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * scale_a, beta, i.beta);
}

/* ---- cogging ---- */

TEST(test_cogging_is_a_sine_of_the_shaft_whatever_the_turn)
{
    plant_motor_cfg_t cfg = with_cogging();

    cfg.cogging_order = 7; /* no multiple of the pole pairs: another one in each electrical turn */
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_angle_el_rad = 1.0;
    cfg.initial_speed_mech_rad_s = -110.0;
    start(&cfg);
    for (int k = 0; k < 100000; k++) {
        if ((k % 97) == 0) {
            const double wanted = -COGGING_NM * sin(7.0 * plant_motor_angle_mech(&motor));
            TEST_ASSERT_DOUBLE_WITHIN(1000.0 * ROUNDING, wanted, plant_motor_torque(&motor));
        }
        plant_motor_step_open(&motor, 1.0e-4);
        plant_motor_wrap(&motor);
    }
}

/* A free shaft: what the cogging takes from the kinetic energy it gives back, nothing is left after a turn. */
TEST(test_cogging_is_conservative)
{
    plant_motor_cfg_t cfg = with_cogging();
    const double kinetic_j = 0.5 * cfg.inertia_kg_m2 * 2.0 * 2.0;
    const double hill_j = COGGING_NM / COGGING_ORDER;
    double least_j = kinetic_j;

    cfg.initial_speed_mech_rad_s = 2.0;
    start(&cfg);
    while (plant_motor_angle_mech(&motor) < 2.0 * PLANT_PI) {
        plant_motor_step_open(&motor, 1.0e-4);
        plant_motor_wrap(&motor);
        const double now_j = 0.5 * cfg.inertia_kg_m2 * omega_mech() * omega_mech();
        const double hill = hill_j * (1.0 - cos(COGGING_ORDER * plant_motor_angle_mech(&motor)));
        TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * hill_j, kinetic_j, now_j + hill);
        least_j = fmin(least_j, now_j);
    }
    /* The tops have been there. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * hill_j, kinetic_j - 2.0 * hill_j, least_j);
}

TEST(test_cogging_holds_a_load_where_its_torque_is_the_load)
{
    plant_motor_cfg_t cfg = with_cogging();
    const double load_nm = -0.7 * COGGING_NM;

    cfg.viscous_friction_nm_s = 0.1; /* a tenth of a second */
    start(&cfg);
    motor.load_torque_nm = load_nm;
    for (int k = 0; k < 100000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
    }
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, asin(-load_nm / COGGING_NM) / COGGING_ORDER,
                              plant_motor_angle_mech(&motor));
    motor.load_torque_nm = -1.01 * COGGING_NM;
    for (int k = 0; k < 100000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
        plant_motor_wrap(&motor);
    }
    TEST_ASSERT_TRUE(plant_motor_angle_mech(&motor) > PLANT_PI / COGGING_ORDER);
}

/* At rest within the dry friction of the slope it stands on, exactly; a little more and it goes. */
TEST(test_stiction_holds_on_a_slope_of_the_cogging)
{
    plant_motor_cfg_t cfg = with_cogging();
    const double mech_rad = 0.02;
    const double slope_nm = COGGING_NM * sin(COGGING_ORDER * mech_rad);

    cfg.initial_angle_el_rad = cfg.pole_pairs * mech_rad;
    cfg.coulomb_friction_nm = 1.001 * slope_nm;
    start(&cfg);
    for (int k = 0; k < 1000; k++) {
        run(1.0e-4, 0.0, 0.0);
    }
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    cfg.coulomb_friction_nm = 0.999 * slope_nm;
    start(&cfg);
    run(1.0e-4, 0.0, 0.0);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s < 0.0);
}

/* Swings of a shaft with dry friction end in a valley between two angles of |cogging| = friction. */
TEST(test_swings_end_where_the_friction_holds)
{
    plant_motor_cfg_t cfg = with_cogging();

    cfg.initial_angle_el_rad = cfg.pole_pairs * 2.0 / COGGING_ORDER;
    cfg.coulomb_friction_nm = 0.1 * COGGING_NM;
    start(&cfg);
    for (int k = 0; k < 20000; k++) {
        plant_motor_step_open(&motor, 1.0e-4);
    }
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(fabs(plant_motor_torque(&motor)) <= cfg.coulomb_friction_nm);
    TEST_ASSERT_TRUE(fabs(plant_motor_angle_mech(&motor)) < 1.0 / COGGING_ORDER);
}

/* ---- saturation ---- */

/* Without resistance the flux is the integral of the voltage, and the current is the map's. */
TEST(test_current_of_a_blocked_rotor_is_that_of_its_volt_seconds)
{
    plant_motor_cfg_t cfg = with_saturation();
    const double v_d = -3.0;
    const double v_q = 10.0;

    cfg.resistance_ohm = 0.0;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    start(&cfg);
    for (int k = 1; k <= 200; k++) {
        run(1.0e-4, v_d, v_q);
        const plant_dq_t flux = {v_d * 1.0e-4 * k, v_q * 1.0e-4 * k};
        const plant_dq_t i = plant_iron_current(&motor.iron, flux);
        TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * SATURATION_A, i.d, plant_motor_i_d(&motor));
        TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * SATURATION_A, i.q, plant_motor_i_q(&motor));
    }
    /* Some rated currents, where L_q has fallen by more than a third. */
    const double i_q = plant_motor_i_q(&motor);
    TEST_ASSERT_TRUE(v_q * 0.02 / i_q < 0.67 * cfg.inductance_q_h);
}

/* The work of a small turn at constant flux linkages of the phases is what the field loses. */
TEST(test_torque_is_what_the_field_loses_in_a_turn)
{
    const plant_motor_cfg_t cfg = with_saturation();
    const double h = 1.0e-5; /* electrical rad: h^2 / 6 of a torque that turns over in 1 rad */

    for (int k = -5; k <= 5; k++) {
        double field_j[2];
        start(&cfg);
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

/* By cross-saturation the magnet's flux falls with i_q, and torque per ampere with it. */
TEST(test_torque_per_ampere_falls_with_the_current)
{
    const plant_motor_cfg_t cfg = with_saturation();

    start(&cfg);
    const double flux_d = cfg.flux_linkage_wb + own_flux(0.0, SATURATION_A).d;
    set_current(0.0, SATURATION_A);
    TEST_ASSERT_TRUE(flux_d < 0.99 * cfg.flux_linkage_wb);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 1.5 * cfg.pole_pairs * flux_d * SATURATION_A,
                              plant_motor_torque(&motor));
}

TEST(test_a_phase_that_stops_conducting_has_no_current)
{
    const plant_motor_cfg_t cfg = with_everything();
    const plant_vector_t axis = {-0.5, 0.5 * PLANT_SQRT3};

    start(&cfg);
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
    plant_motor_cfg_t cfg = with_everything();
    const plant_vector_t axis = {1.0, 0.0};
    const double h = 1.0e-8;

    cfg.initial_speed_mech_rad_s = 30.0;
    for (int k = 0; k < 30; k++) {
        cfg.initial_angle_el_rad = 0.2 * k;
        start(&cfg);
        set_current(9.0 * sin(cfg.initial_angle_el_rad), 9.0 * cos(cfg.initial_angle_el_rad));
        const plant_vector_t v = {0.0, 100.0};
        const double p = plant_motor_floating_potential(&motor, v, axis);
        run(h, 2.0 / 3.0 * p, v.beta);
        /* Of the currents of b and c, some 10^4 A/s, all but what the second order leaves. */
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * 1.0e4 * h, 0.0, plant_motor_current(&motor).alpha);
    }
}

/* Two phases in series, the third floats: the flux along their axis is the volt-seconds, less those of R. */
TEST(test_a_floating_phase_stays_without_current)
{
    plant_motor_cfg_t cfg = with_everything();
    const plant_vector_t axis = {1.0, 0.0};
    const plant_vector_t v = {0.0, 310.0 / PLANT_SQRT3};

    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.initial_angle_el_rad = 0.4;
    cfg.initial_speed_mech_rad_s = 30.0;
    start(&cfg);
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

    return magnetic_j() + hill +
           0.5 * (motor.pole_pairs / motor.acceleration) * omega_mech() * omega_mech() +
           0.5 * LOAD_KG_M2 * load * load + 0.5 * STIFFNESS_NM * twist * twist;
}

/* Electrical energy in = stored + copper + friction + load, all but the first integrated here by the trapezoidal rule
 * over h. */
TEST(test_energy_is_conserved)
{
    plant_motor_cfg_t cfg = with_everything();
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
    const double at_first_j = stored_j();
    for (long k = 0; k < 300000; k++) {
        /* A slowly turning vector, switched on and off as by a pulse width modulator. */
        const double on = ((k % 100) < 35) ? 100.0 : 0.0;
        const double angle = 60.0 * (double)k * h;
        const plant_vector_t v = {on * cos(angle), on * sin(angle)};
        run(h, v.alpha, v.beta);
        const plant_vector_t i = plant_motor_current(&motor);
        const double speed = omega_mech();
        const double load = motor.now.load_speed_rad_s;
        const double loss = 1.5 * cfg.resistance_ohm * (i.alpha * i.alpha + i.beta * i.beta) +
                            speed * (cfg.viscous_friction_nm_s * speed + copysign(0.05, speed)) +
                            DAMPING_NM_S * (speed - load) * (speed - load) + 0.4 * load;
        in_j += 0.75 * h * (v.alpha * (i.alpha + before.alpha) + v.beta * (i.beta + before.beta));
        out_j += 0.5 * h * (loss + loss_before);
        before = i;
        loss_before = loss;
    }
    /* As of the ideal motor: half a step of the friction power at each of some ten reversals. */
    const double tolerance = 1.0e-6;
    TEST_ASSERT_TRUE(in_j > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance * in_j, in_j + at_first_j, out_j + stored_j());
}

/* One run with modulated voltage, each interval in so many parts. */
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

static void check_same(const plant_motor_t *a, const plant_motor_t *b, double accuracy)
{
    const double scale_a = a->flux_linkage_wb / a->inductance_d_h;
    const double speed = fmax(fabs(a->now.omega_el_rad_s), 1.0);

    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_d(a), plant_motor_i_d(b));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * scale_a, plant_motor_i_q(a), plant_motor_i_q(b));
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * speed, a->now.omega_el_rad_s, b->now.omega_el_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(accuracy, a->now.theta_el_rad, b->now.theta_el_rad);
    TEST_ASSERT_DOUBLE_WITHIN(accuracy * speed, a->now.load_speed_rad_s, b->now.load_speed_rad_s);
}

TEST(test_result_does_not_depend_on_the_step)
{
    plant_motor_cfg_t cfg = with_everything();

    cfg.initial_speed_mech_rad_s = 150.0;
    const plant_motor_t coarse = modulated_run(&cfg, 1.0e-4, 60.0, 1);
    const plant_motor_t fine = modulated_run(&cfg, 1.0e-4, 60.0, 16);
    check_same(&fine, &coarse, ACCURACY);
}

/* At more than 30 times the stated current the inductances have fallen to hundredths, so R/L has risen. */
TEST(test_result_does_not_depend_on_the_step_deep_in_saturation)
{
    plant_motor_cfg_t cfg = with_saturation();

    cfg.saturation_q = PLANT_IRON_FALL_Q_MAX;
    cfg.saturation_a = 0.5;
    const plant_motor_t coarse = modulated_run(&cfg, 1.0e-4, 60.0, 1);
    const plant_motor_t fine = modulated_run(&cfg, 1.0e-4, 60.0, 16);
    TEST_ASSERT_TRUE(hypot(plant_motor_i_d(&fine), plant_motor_i_q(&fine)) >
                     30.0 * cfg.saturation_a);
    check_same(&fine, &coarse, ACCURACY);
}

TEST(test_result_does_not_depend_on_the_step_for_a_drone_motor)
{
    const plant_motor_t coarse = modulated_run(&DRONE, 2.5e-5, 8.0, 1);
    const plant_motor_t fine = modulated_run(&DRONE, 2.5e-5, 8.0, 16);
    check_same(&fine, &coarse, ACCURACY_DRONE);

    /* Cogs much faster than all else: 13 rad in a period. */
    plant_motor_cfg_t cfg = DRONE;
    cfg.cogging_order = 420;
    const plant_motor_t coarse_cogs = modulated_run(&cfg, 2.5e-5, 8.0, 1);
    const plant_motor_t fine_cogs = modulated_run(&cfg, 2.5e-5, 8.0, 16);
    check_same(&fine_cogs, &coarse_cogs, ACCURACY_DRONE);
}

/* Another method of another order; of cogging or saturation there is a rounding. */
TEST(test_a_motor_with_next_to_nothing_is_the_ideal_one)
{
    plant_motor_cfg_t cfg = IDEAL;

    cfg.viscous_friction_nm_s = 0.01;
    cfg.initial_speed_mech_rad_s = 150.0;
    const plant_motor_t ideal = modulated_run(&cfg, 1.0e-4, 60.0, 1);
    cfg.cogging_nm = 1.0e-15;
    cfg.cogging_order = 1;
    const plant_motor_t cogging = modulated_run(&cfg, 1.0e-4, 60.0, 1);
    TEST_ASSERT_TRUE(cogging.is_real && !ideal.is_real);
    check_same(&ideal, &cogging, ACCURACY);
    cfg.cogging_nm = 0.0;
    cfg.saturation_d = 1.0e-15;
    cfg.saturation_q = 1.0e-15;
    cfg.saturation_a = SATURATION_A;
    const plant_motor_t saturated = modulated_run(&cfg, 1.0e-4, 60.0, 1);
    TEST_ASSERT_TRUE(saturated.is_real);
    check_same(&ideal, &saturated, ACCURACY);
}

TEST(test_a_turned_rotor_keeps_its_phase_currents_and_finds_its_cogging)
{
    plant_motor_cfg_t cfg = with_everything();

    start(&cfg);
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

static void check_rejected(const plant_motor_cfg_t *cfg, const char *field)
{
    const char *bad = NULL;

    TEST_ASSERT_FALSE(plant_motor_init(&motor, cfg, &bad));
    TEST_ASSERT_EQUAL_STRING(field, bad);
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    plant_motor_cfg_t cfg = with_everything();
    cfg.emf_5th = -0.6;
    check_rejected(&cfg, "motor.emf_5th");
    cfg = with_everything();
    cfg.emf_7th = (double)NAN;
    check_rejected(&cfg, "motor.emf_7th");
    cfg = with_everything();
    cfg.saturation_d = 0.31;
    check_rejected(&cfg, "motor.saturation_d");
    cfg = with_everything();
    cfg.saturation_q = -0.1;
    check_rejected(&cfg, "motor.saturation_q");
    cfg = with_everything();
    cfg.saturation_a = 0.0;
    check_rejected(&cfg, "motor.saturation_a");
    cfg = with_everything();
    cfg.saturation_d = 0.3;
    cfg.saturation_q = 0.5;
    cfg.inductance_q_h = 0.5 * cfg.inductance_d_h;
    cfg.saturation_shared = 1.01 * plant_motor_shared_max(&cfg);
    TEST_ASSERT_TRUE(cfg.saturation_shared < 1.0);
    check_rejected(&cfg, "motor.saturation_shared");
    cfg = with_everything();
    cfg.cogging_nm = -1.0;
    check_rejected(&cfg, "motor.cogging_nm");
    cfg = with_everything();
    cfg.cogging_order = 0;
    check_rejected(&cfg, "motor.cogging_order");
}
