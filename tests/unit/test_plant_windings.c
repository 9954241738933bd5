/* SPDX-License-Identifier: MIT */
/* Windings that differ: against the circuit of three windings with a common star point. */
#include "plant_motor_rig.h"

#define STEP_S 1.0e-6

/* Of a sum of some 10^5 roundings, and of 1 µs steps of the second order: (R/L · step)²/24. */
#define ERROR 1.0e-7

static const double AXES_RAD[PLANT_LEGS] = {0.0, PLANT_TWO_PI / 3.0, -PLANT_TWO_PI / 3.0};

void setUp(void)
{
    cfg = (plant_motor_cfg_t){
        .pole_pairs = 2,
        .resistance_ohm = 2.0,
        .inductance_d_h = 0.01,
        .inductance_q_h = 0.01,
        .flux_linkage_wb = 0.4,
        .inertia_kg_m2 = 0.003,
        .shorted = {0.3, 0.0, 0.0},
        .contact_ohm = {0.0, 1.0, 0.0},
    };
    start();
}

static void currents(double phase[PLANT_LEGS])
{
    plant_phases(plant_motor_current(&motor), phase);
}

static void drive(const double v[PLANT_LEGS], double duration_s)
{
    const plant_interval_t interval = {duration_s, plant_clarke(v[0], v[1], v[2])};

    plant_motor_run_driven(&motor, 1, &interval);
    plant_motor_wrap(&motor);
}

static double turns_of(int phase)
{
    return 1.0 - cfg.shorted[phase];
}

static double ohm_of(int phase)
{
    return cfg.resistance_ohm * turns_of(phase) + cfg.contact_ohm[phase];
}

/* Flux linkage of a winding: L times what the turns of all three make along its axis. */
static double linkage_of(int phase, const double i[PLANT_LEGS])
{
    double sum = 0.0;

    for (int k = 0; k < PLANT_LEGS; k++) {
        sum += turns_of(k) * i[k] * cos(AXES_RAD[phase] - AXES_RAD[k]);
    }
    return 2.0 / 3.0 * cfg.inductance_d_h * turns_of(phase) * sum;
}

TEST(test_windings_that_are_alike_are_those_of_an_ideal_motor)
{
    cfg = ROUND_ROTOR;
    start();
    TEST_ASSERT_FALSE(motor.is_real);
    TEST_ASSERT_TRUE(motor.windings.are_alike);
}

TEST(test_a_steady_current_is_that_of_the_three_resistances)
{
    const double v[PLANT_LEGS] = {10.0, -3.0, 4.0};
    double i[PLANT_LEGS];

    plant_motor_block(&motor, true);
    for (int k = 0; k < 100; k++) {
        drive(v, 0.001);
    }
    currents(i);
    const double star_v = v[0] - ohm_of(0) * i[0];
    for (int k = 1; k < PLANT_LEGS; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(10.0 * ERROR, star_v, v[k] - ohm_of(k) * i[k]);
    }
}

/* The voltage of a winding, less the star point's, is that of its resistance and flux linkage. */
TEST(test_a_change_is_that_of_the_three_coupled_inductances)
{
    const double v[PLANT_LEGS] = {100.0, -30.0, 40.0};
    /* So short that the mean current is half of its ends: (R/L · step)²/12. */
    const double step_s = 1.0e-7;
    double before[PLANT_LEGS];
    double after[PLANT_LEGS];
    double star_v[PLANT_LEGS];

    plant_motor_block(&motor, true);
    drive(v, 0.002);
    currents(before);
    drive(v, step_s);
    currents(after);
    for (int k = 0; k < PLANT_LEGS; k++) {
        const double change = linkage_of(k, after) - linkage_of(k, before);

        star_v[k] = v[k] - 0.5 * ohm_of(k) * (before[k] + after[k]) - change / step_s;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-5, star_v[0], star_v[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-5, star_v[0], star_v[2]);
}

TEST(test_the_emf_of_a_winding_is_that_of_its_turns)
{
    double emf[PLANT_LEGS];
    double whole[PLANT_LEGS];
    double mean = 0.0;

    motor.now.omega_el_rad_s = 300.0;
    plant_phases(plant_motor_emf(&motor), emf);
    for (int k = 0; k < PLANT_LEGS; k++) {
        whole[k] = -turns_of(k) * 300.0 * cfg.flux_linkage_wb * sin(-AXES_RAD[k]);
        mean += whole[k] / 3.0;
    }
    for (int k = 0; k < PLANT_LEGS; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(ERROR, whole[k] - mean, emf[k]);
    }
}

/* Energy of the field: ½·m·L·m·3/2, of the rotor, and in the resistances. */
TEST(test_what_the_terminals_give_is_torque_field_and_heat)
{
    double given_j = 0.0;
    double heat_j = 0.0;
    double after[PLANT_LEGS];

    for (int k = 0; k < 20000; k++) {
        const double angle = 0.002 * k;
        const double v[PLANT_LEGS] = {20.0 * cos(angle), 20.0 * cos(angle - 2.1),
                                      20.0 * cos(angle + 2.1)};
        double before[PLANT_LEGS];

        currents(before);
        drive(v, STEP_S);
        currents(after);
        for (int phase = 0; phase < PLANT_LEGS; phase++) {
            const double mean = 0.5 * (before[phase] + after[phase]);

            given_j += v[phase] * mean * STEP_S;
            heat_j += ohm_of(phase) * mean * mean * STEP_S;
        }
    }
    double stored_j = 0.5 * cfg.inertia_kg_m2 * omega_mech() * omega_mech();
    for (int phase = 0; phase < PLANT_LEGS; phase++) {
        stored_j += 0.5 * after[phase] * linkage_of(phase, after);
    }
    TEST_ASSERT_TRUE(fabs(given_j) > 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-5 * fabs(given_j), given_j, heat_j + stored_j);
}

TEST(test_an_open_phase_carries_no_current)
{
    const plant_vector_t axis = {-0.5, 0.5 * PLANT_SQRT3};
    const plant_vector_t v = plant_clarke(30.0, 0.0, -30.0);
    double i[PLANT_LEGS];

    for (int k = 0; k < 1000; k++) {
        plant_motor_step_tied(&motor, STEP_S, v, axis);
    }
    currents(i);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, 0.0, i[1]);
    TEST_ASSERT_TRUE(i[0] > 1.0);
    plant_motor_clear_phase(&motor, (plant_vector_t){1.0, 0.0});
    currents(i);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, 0.0, i[0]);
}

TEST(test_what_is_out_of_range_is_named)
{
    cfg.shorted[2] = 0.95;
    check_refused(&cfg, "motor.shorted");
    cfg.shorted[2] = 0.0;
    cfg.contact_ohm[1] = -1.0;
    check_refused(&cfg, "motor.contact_ohm");
}
