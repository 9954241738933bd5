/* SPDX-License-Identifier: MIT */
/* Conduction of the simulated bridge: device drop, diodes, floating legs, rectification. */
#include "bridge.h"
#include "plant_motor_rig.h"

#define BUS_V 310.0
#define DROP_V 1.2
#define DIODES_V (BUS_V + 2.0 * DROP_V) /* against a current through two diodes */

#define LEG_A 1U
#define LEG_B 2U
#define LEG_C 4U
#define NO_LEG 0U
#define ALL_LEGS 7U

static double current[PLANT_LEGS];

void setUp(void)
{
    cfg = ROUND_ROTOR;
    cfg.inertia_kg_m2 = INERTIA_OF_A_WALL;
    start();
}

static void add_harmonics(void)
{
    cfg.emf_5th = 0.05;
    cfg.emf_7th = -0.03;
}

static void start_turning(double speed_mech_rad_s)
{
    cfg.initial_speed_mech_rad_s = speed_mech_rad_s;
    start();
}

/* A standing motor with this current in phase a, half of it back in b and in c. */
static void start_with_current(double i_a)
{
    start();
    motor.now.flux_d_wb += cfg.inductance_d_h * i_a;
}

static void run_with(double duration_s, unsigned high, unsigned low, double drop_v)
{
    const plant_segment_t segment = {duration_s, (uint8_t)high, (uint8_t)low};
    const plant_rails_t rails = {.bus_v = BUS_V, .drop_v = drop_v};

    plant_bridge_run(&motor, &segment, &rails, NULL);
    plant_motor_wrap(&motor);
    plant_phases(plant_motor_current(&motor), current);
}

/* In periods of 100 us, with these low sides closed. */
static void check_no_current(int periods, unsigned low, double drop_v)
{
    for (int k = 0; k < periods; k++) {
        run_with(1.0e-4, NO_LEG, low, drop_v);
        TEST_ASSERT_TRUE(current[0] == 0.0 && current[1] == 0.0 && current[2] == 0.0);
    }
}

/* The current of a phase that has had this voltage for a time. */
static double current_after(double time_s, double from_a, double volt)
{
    const double end_a = volt / cfg.resistance_ohm;

    return end_a + (from_a - end_a) * exp(-time_s * cfg.resistance_ohm / cfg.inductance_d_h);
}

/* Line-to-line EMF peak = sqrt(3) w phi. */
static double speed_for_line_emf(double peak_v)
{
    return peak_v / (sqrt(3.0) * cfg.flux_linkage_wb * cfg.pole_pairs);
}

TEST(test_clarke_and_phases_are_inverse_without_zero_sequence)
{
    double phase[PLANT_LEGS];

    plant_phases(plant_clarke(10.0, -4.0, -6.0), phase);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-14, 10.0, phase[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-14, -4.0, phase[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-14, -6.0, phase[2]);
}

TEST(test_device_drop_takes_its_share_of_the_voltage_each_way)
{
    /* a at bus - drop, b and c at +drop: v_alpha = 2/3 (bus - 2 drop). */
    const double i_end = 2.0 / 3.0 * (BUS_V - 2.0 * DROP_V) / cfg.resistance_ohm;

    run_with(0.2, LEG_A, LEG_B | LEG_C, DROP_V); /* 36 time constants */
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, i_end, current[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, -0.5 * i_end, current[1]);

    start();
    run_with(0.2, LEG_B | LEG_C, LEG_A, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, -i_end, current[0]);
}

TEST(test_a_current_in_an_open_leg_takes_the_diode_that_opposes_it)
{
    const double t = 2.0e-6;

    /* i_a > 0: a at -drop, b (low) at +drop, c (low) at +drop. */
    start_with_current(10.0);
    run_with(t, NO_LEG, LEG_B | LEG_C, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY, current_after(t, 10.0, -4.0 / 3.0 * DROP_V), current[0]);
    /* i_a < 0: a at bus + drop, b and c at -drop. */
    start_with_current(-10.0);
    run_with(t, NO_LEG, LEG_B | LEG_C, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY, current_after(t, -10.0, 2.0 / 3.0 * DIODES_V), current[0]);
}

/* All open and i_a > 0: a at -drop, b and c at bus + drop, until the current has gone. */
TEST(test_open_bridge_drives_the_currents_to_zero_at_the_closed_form_time)
{
    const double v = -2.0 / 3.0 * DIODES_V;
    const double end_a = v / cfg.resistance_ohm;
    const double gone_s = log1p(10.0 / -end_a) * cfg.inductance_d_h / cfg.resistance_ohm;

    start_with_current(10.0);
    run_with(0.5 * gone_s, NO_LEG, NO_LEG, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * -end_a, current_after(0.5 * gone_s, 10.0, v), current[0]);
    run_with(0.499 * gone_s, NO_LEG, NO_LEG, DROP_V);
    TEST_ASSERT_TRUE(current[0] > 0.0);
    run_with(0.002 * gone_s, NO_LEG, NO_LEG, DROP_V);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        TEST_ASSERT_TRUE(fabs(current[leg]) <= PLANT_BRIDGE_TOLERANCE);
    }
}

TEST(test_open_bridge_at_rest_carries_no_current_at_all)
{
    start_with_current(-10.0);
    motor.now.flux_q_wb = 0.02;
    run_with(0.01, NO_LEG, NO_LEG, 0.0);
    check_no_current(100, NO_LEG, 0.0);
}

TEST(test_open_bridge_stays_without_current_while_the_emf_is_below_the_bus)
{
    start_turning(speed_for_line_emf(0.999 * DIODES_V));
    check_no_current(1000, NO_LEG, DROP_V);
}

TEST(test_open_bridge_rectifies_when_the_emf_exceeds_the_bus)
{
    double least_nm = 0.0;

    start_turning(speed_for_line_emf(1.2 * DIODES_V));
    for (int k = 0; k < 2000; k++) {
        run_with(1.0e-4, NO_LEG, NO_LEG, DROP_V);
        /* A generator in every instant: the shaft is braked. */
        TEST_ASSERT_TRUE(plant_motor_torque(&motor) <= PLANT_BRIDGE_TOLERANCE);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, 0.0, current[0] + current[1] + current[2]);
        least_nm = fmin(least_nm, plant_motor_torque(&motor));
    }
    TEST_ASSERT_TRUE(least_nm < -0.5);
}

/* What the shaft gives = copper loss + what the diodes and the bus take; trapezoidal rule. */
static void check_rectified_energy(void)
{
    const double h = 2.0e-6;
    double shaft_j = 0.0;
    double sink_j = 0.0;
    double shaft_before = 0.0;
    double sink_before = 0.0;

    start_turning(speed_for_line_emf(1.3 * DIODES_V));
    for (int k = 0; k < 100000; k++) {
        run_with(h, NO_LEG, NO_LEG, DROP_V);
        const double shaft_w = -plant_motor_torque(&motor) * omega_mech();
        double sink_w = 0.0;
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            sink_w += fmax(-current[leg], 0.0) * DIODES_V;
            sink_w += cfg.resistance_ohm * current[leg] * current[leg];
        }
        shaft_j += 0.5 * h * (shaft_w + shaft_before);
        sink_j += 0.5 * h * (sink_w + sink_before);
        shaft_before = shaft_w;
        sink_before = sink_w;
    }
    /*
     * (w h)^2 / 12 = 1e-7 of the smooth part; a kink of slope at each of 6 commutations a turn, at
     * worst h^2/8 of 10^5 W/s each: 600 * 5e-8 J of 100 J.
     */
    TEST_ASSERT_TRUE(shaft_j > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2.0e-6 * shaft_j, shaft_j, sink_j + linear_j());
}

TEST(test_rectified_energy_is_conserved)
{
    check_rectified_energy();
    add_harmonics();
    check_rectified_energy();
}

TEST(test_current_that_reaches_zero_in_an_open_leg_stays_zero)
{
    /* i_a falls at about 2/3 310 V / 11.6 mH = 18 A/ms: 10 mA are gone in 0.6 us. */
    start_with_current(0.01);
    run_with(2.0e-6, LEG_B | LEG_C, NO_LEG, 0.0);
    TEST_ASSERT_TRUE(fabs(current[0]) <= PLANT_BRIDGE_TOLERANCE);
    run_with(50.0e-6, LEG_B | LEG_C, NO_LEG, 0.0);
    TEST_ASSERT_TRUE(fabs(current[0]) <= PLANT_BRIDGE_TOLERANCE);
}

TEST(test_floating_leg_leaves_the_other_two_as_a_single_loop)
{
    /* b high, c low, a floats: bus over two phases in series, as the axis across a sees it. */
    const double t = 3.0e-3;
    const double tolerance_a = ACCURACY * 0.5 * BUS_V / cfg.resistance_ohm;

    run_with(t, LEG_B, LEG_C, 0.0);
    TEST_ASSERT_TRUE(fabs(current[0]) <= PLANT_BRIDGE_TOLERANCE);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, current_after(t, 0.0, 0.5 * BUS_V), current[1]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, -current[1], current[2]);
}

TEST(test_closed_switches_with_drop_pass_no_current_for_an_emf_below_the_drops)
{
    start_turning(speed_for_line_emf(0.99 * 2.0 * DROP_V));
    check_no_current(1000, ALL_LEGS, DROP_V);
    start_turning(speed_for_line_emf(1.5 * 2.0 * DROP_V));
    double seen = 0.0;
    for (int k = 0; k < 5000; k++) {
        run_with(1.0e-4, NO_LEG, ALL_LEGS, DROP_V);
        seen = fmax(seen, fabs(current[0]));
    }
    TEST_ASSERT_TRUE(seen > 0.01);
}

TEST(test_without_drop_closed_switches_short_the_motor)
{
    start_turning(100.0);
    for (int k = 0; k < 2000; k++) {
        run_with(1.0e-4, NO_LEG, ALL_LEGS, 0.0);
    }
    const double w = motor.now.omega_el_rad_s;
    const double r = cfg.resistance_ohm;
    const double l = cfg.inductance_d_h;
    const double i_q = -w * r * cfg.flux_linkage_wb / (r * r + w * w * l * l);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * 100.0, i_q, plant_motor_i_q(&motor));
}

/* The same switching history in whole and in eighths of its segments. */
static plant_motor_t switched_run(int parts)
{
    static const plant_segment_t history[] = {
        {20.0e-6, 0, 7}, {2.0e-6, 0, 6}, {9.0e-6, 1, 6}, {2.0e-6, 1, 4},
        {14.0e-6, 3, 4}, {2.0e-6, 1, 4}, {9.0e-6, 1, 6}, {2.0e-6, 0, 6},
    };

    start();
    for (int k = 0; k < 800; k++) {
        const plant_segment_t *whole = &history[k % 8];
        const unsigned turn = ((unsigned)k / 160U) % 3U; /* other legs take the part of a */
        const unsigned high = ((unsigned)whole->high << turn) | (whole->high >> (3U - turn));
        const unsigned low = ((unsigned)whole->low << turn) | (whole->low >> (3U - turn));
        for (int p = 0; p < parts; p++) {
            run_with(whole->duration_s / parts, high & ALL_LEGS, low & ALL_LEGS, DROP_V);
        }
    }
    return motor;
}

static void check_independence_of_cuts(void)
{
    const plant_motor_t whole = switched_run(1);
    const plant_motor_t cut = switched_run(8);
    /* Steps differ by ACCURACY of phi/L_d = 33 A; each event, some hundred, by its tolerance. */
    const double tolerance_a = ACCURACY * 33.0 + 100.0 * PLANT_BRIDGE_TOLERANCE;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_d(&cut), plant_motor_i_d(&whole));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_q(&cut), plant_motor_i_q(&whole));
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * 300.0, cut.now.omega_el_rad_s, whole.now.omega_el_rad_s);
}

TEST(test_result_does_not_depend_on_how_segments_are_cut)
{
    cfg = ROUND_ROTOR;
    cfg.inductance_q_h = 0.02;
    cfg.initial_speed_mech_rad_s = 120.0;
    const plant_motor_cfg_t ideal = cfg;
    check_independence_of_cuts();
    add_harmonics();
    check_independence_of_cuts();
    cfg = ideal;
    cfg.saturation_d = 0.2;
    cfg.saturation_q = 0.3;
    cfg.saturation_shared = 0.8;
    cfg.saturation_a = 7.0;
    check_independence_of_cuts();
}

/* Beside a floating leg the star point follows the EMF, orders 5 and 7 included. */
TEST(test_floating_terminal_shows_the_emf_of_its_phase)
{
    const plant_vector_t none = {0.0, 0.0};

    add_harmonics();
    for (int k = 0; k < 30; k++) {
        cfg.initial_angle_el_rad = 0.2 * k;
        start_turning(50.0);
        const double x = cfg.initial_angle_el_rad;
        const double emf_v =
            -100.0 * cfg.flux_linkage_wb * (sin(x) + 0.05 * sin(5.0 * x) - 0.03 * sin(7.0 * x));
        /* b and c at zero volts: the star point is at minus the mean of their EMF, e_a / 2. */
        TEST_ASSERT_DOUBLE_WITHIN(
            1.0e-10, 1.5 * emf_v,
            plant_motor_floating_potential(&motor, none, plant_bridge_axis[0]));
    }
}
