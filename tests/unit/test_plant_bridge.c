/* SPDX-License-Identifier: MIT */
/* Conduction of the simulated bridge: device drop, diodes, floating legs, rectification. */
#include "bridge.h"
#include "plant_motor_rig.h"

#define BUS_V 310.0
#define DROP_V 1.2

#define LEG_A 1U
#define LEG_B 2U
#define LEG_C 4U
#define NO_LEG 0U

static const plant_motor_cfg_t ROUND_ROTOR = {
    .pole_pairs = 2,
    .resistance_ohm = 2.125,
    .inductance_d_h = 0.0116,
    .inductance_q_h = 0.0116,
    .flux_linkage_wb = 0.387,
    .inertia_kg_m2 = INERTIA_OF_A_WALL,
};

static plant_motor_cfg_t with_saturation(void)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.saturation_d = 0.2;
    cfg.saturation_q = 0.3;
    cfg.saturation_shared = 0.8;
    cfg.saturation_a = 7.0;
    return cfg;
}

static plant_motor_cfg_t with_harmonics(void)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.emf_5th = 0.05;
    cfg.emf_7th = -0.03;
    return cfg;
}

static double current[PLANT_LEGS];

static void start_turning(double speed_mech_rad_s)
{
    plant_motor_cfg_t cfg = ROUND_ROTOR;

    cfg.initial_speed_mech_rad_s = speed_mech_rad_s;
    start(&cfg);
}

/* A standing motor with this current in phase a, half of it back in b and in c. */
static void start_with_current(double i_a)
{
    start(&ROUND_ROTOR);
    motor.now.flux_d_wb += ROUND_ROTOR.inductance_d_h * i_a;
}

static void run_with(double duration_s, unsigned high, unsigned low, double drop_v)
{
    const plant_segment_t segment = {duration_s, (uint8_t)high, (uint8_t)low};
    const plant_rails_t rails = {.bus_v = BUS_V, .drop_v = drop_v};

    plant_bridge_run(&motor, &segment, &rails, NULL);
    plant_motor_wrap(&motor);
    plant_phases(plant_motor_current(&motor), current);
}

static double largest_current(void)
{
    return fmax(fabs(current[0]), fmax(fabs(current[1]), fabs(current[2])));
}

void setUp(void)
{
    start(&ROUND_ROTOR);
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
    const double i_end = 2.0 / 3.0 * (BUS_V - 2.0 * DROP_V) / ROUND_ROTOR.resistance_ohm;

    run_with(0.2, LEG_A, LEG_B | LEG_C, DROP_V); /* 36 time constants */
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, i_end, current[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, -0.5 * i_end, current[1]);

    start(&ROUND_ROTOR);
    run_with(0.2, LEG_B | LEG_C, LEG_A, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, -i_end, current[0]);
}

TEST(test_a_current_in_an_open_leg_takes_the_diode_that_opposes_it)
{
    /* The first 2 us of i_a > 0: a at -drop, b (low) at +drop, c (low) at +drop. */
    const double i_0 = 10.0;
    const double t = 2.0e-6;
    const double v = -4.0 / 3.0 * DROP_V;

    start_with_current(i_0);
    run_with(t, NO_LEG, LEG_B | LEG_C, DROP_V);
    const double rate = ROUND_ROTOR.resistance_ohm / ROUND_ROTOR.inductance_d_h;
    const double i_end = v / ROUND_ROTOR.resistance_ohm;
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY, i_end + (i_0 - i_end) * exp(-rate * t), current[0]);

    /* i_a < 0: a at bus + drop, b and c at -drop. */
    start_with_current(-i_0);
    run_with(t, NO_LEG, LEG_B | LEG_C, DROP_V);
    const double i_up = 2.0 / 3.0 * (BUS_V + 2.0 * DROP_V) / ROUND_ROTOR.resistance_ohm;
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY, i_up + (-i_0 - i_up) * exp(-rate * t), current[0]);
}

/* All open and i_a > 0: a at -drop, b and c at bus + drop, until the current has gone. */
TEST(test_open_bridge_drives_the_currents_to_zero_at_the_closed_form_time)
{
    const double i_0 = 10.0;
    const double v = 2.0 / 3.0 * (BUS_V + 2.0 * DROP_V);
    const double rate = ROUND_ROTOR.resistance_ohm / ROUND_ROTOR.inductance_d_h;
    const double i_end = v / ROUND_ROTOR.resistance_ohm;
    const double gone_s = log1p(i_0 / i_end) / rate;

    start_with_current(i_0);
    run_with(0.5 * gone_s, NO_LEG, NO_LEG, DROP_V);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, (i_0 + i_end) * exp(-0.5 * rate * gone_s) - i_end,
                              current[0]);
    run_with(0.499 * gone_s, NO_LEG, NO_LEG, DROP_V);
    TEST_ASSERT_TRUE(current[0] > 0.0);
    run_with(0.002 * gone_s, NO_LEG, NO_LEG, DROP_V);
    TEST_ASSERT_TRUE(largest_current() <= PLANT_BRIDGE_TOLERANCE);
}

TEST(test_open_bridge_at_rest_carries_no_current_at_all)
{
    start_with_current(-10.0);
    motor.now.flux_q_wb = 0.02;
    run_with(0.01, NO_LEG, NO_LEG, 0.0);
    for (int k = 0; k < 100; k++) {
        run_with(1.0e-4, NO_LEG, NO_LEG, 0.0);
        TEST_ASSERT_TRUE(largest_current() == 0.0);
    }
}

/* Line-to-line EMF peak = sqrt(3) w phi. */
static double speed_for_line_emf(double peak_v)
{
    return peak_v / (sqrt(3.0) * ROUND_ROTOR.flux_linkage_wb * ROUND_ROTOR.pole_pairs);
}

TEST(test_open_bridge_stays_without_current_while_the_emf_is_below_the_bus)
{
    start_turning(speed_for_line_emf(0.999 * (BUS_V + 2.0 * DROP_V)));
    for (int k = 0; k < 1000; k++) {
        run_with(1.0e-4, NO_LEG, NO_LEG, DROP_V);
        TEST_ASSERT_TRUE(largest_current() == 0.0);
    }
}

TEST(test_open_bridge_rectifies_when_the_emf_exceeds_the_bus)
{
    double least_power = 0.0;

    start_turning(speed_for_line_emf(1.2 * (BUS_V + 2.0 * DROP_V)));
    for (int k = 0; k < 2000; k++) {
        run_with(1.0e-4, NO_LEG, NO_LEG, DROP_V);
        /* A generator in every instant: the shaft is braked. */
        TEST_ASSERT_TRUE(plant_motor_torque(&motor) <= PLANT_BRIDGE_TOLERANCE);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, 0.0, current[0] + current[1] + current[2]);
        least_power = fmin(least_power, plant_motor_torque(&motor));
    }
    TEST_ASSERT_TRUE(least_power < -0.5);
}

/*
 * Rectified energy: what the shaft gives = copper loss + what the diodes and the bus take. Small
 * segments, trapezoidal rule.
 */
static void check_rectified_energy(plant_motor_cfg_t cfg)
{
    const double h = 2.0e-6;
    double shaft_j = 0.0;
    double sink_j = 0.0;
    double shaft_before = 0.0;
    double sink_before = 0.0;

    cfg.initial_speed_mech_rad_s = speed_for_line_emf(1.3 * (BUS_V + 2.0 * DROP_V));
    start(&cfg);
    for (int k = 0; k < 100000; k++) {
        run_with(h, NO_LEG, NO_LEG, DROP_V);
        const double speed = motor.now.omega_el_rad_s / motor.pole_pairs;
        const double shaft_w = -plant_motor_torque(&motor) * speed;
        double into_bus_a = 0.0;
        double copper_w = 0.0;
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            into_bus_a += fmax(-current[leg], 0.0);
            copper_w += ROUND_ROTOR.resistance_ohm * current[leg] * current[leg];
        }
        const double sink_w = copper_w + into_bus_a * (BUS_V + 2.0 * DROP_V);
        shaft_j += 0.5 * h * (shaft_w + shaft_before);
        sink_j += 0.5 * h * (sink_w + sink_before);
        shaft_before = shaft_w;
        sink_before = sink_w;
    }
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);
    const double magnetic_j = 0.75 * ROUND_ROTOR.inductance_d_h * (i_d * i_d + i_q * i_q);
    /*
     * (w h)^2 / 12 = 1e-7 of the smooth part; a kink of slope at each of 6 commutations a turn, at
     * worst h^2/8 of 10^5 W/s each: 600 * 5e-8 J of 100 J.
     */
    TEST_ASSERT_TRUE(shaft_j > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2.0e-6 * shaft_j, shaft_j, sink_j + magnetic_j);
}

TEST(test_rectified_energy_is_conserved)
{
    check_rectified_energy(ROUND_ROTOR);
    check_rectified_energy(with_harmonics());
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
    const double i_end = BUS_V / (2.0 * ROUND_ROTOR.resistance_ohm);
    const double rate = ROUND_ROTOR.resistance_ohm / ROUND_ROTOR.inductance_d_h;
    const double t = 3.0e-3;

    run_with(t, LEG_B, LEG_C, 0.0);
    TEST_ASSERT_TRUE(fabs(current[0]) <= PLANT_BRIDGE_TOLERANCE);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, i_end * -expm1(-rate * t), current[1]);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * i_end, -current[1], current[2]);
}

TEST(test_closed_switches_with_drop_pass_no_current_for_an_emf_below_the_drops)
{
    start_turning(speed_for_line_emf(0.99 * 2.0 * DROP_V));
    for (int k = 0; k < 1000; k++) {
        run_with(1.0e-4, NO_LEG, LEG_A | LEG_B | LEG_C, DROP_V);
        TEST_ASSERT_TRUE(largest_current() == 0.0);
    }
    start_turning(speed_for_line_emf(1.5 * 2.0 * DROP_V));
    double seen = 0.0;
    for (int k = 0; k < 5000; k++) {
        run_with(1.0e-4, NO_LEG, LEG_A | LEG_B | LEG_C, DROP_V);
        seen = fmax(seen, largest_current());
    }
    TEST_ASSERT_TRUE(seen > 0.01);
}

TEST(test_without_drop_closed_switches_short_the_motor)
{
    start_turning(100.0);
    for (int k = 0; k < 2000; k++) {
        run_with(1.0e-4, NO_LEG, LEG_A | LEG_B | LEG_C, 0.0);
    }
    const double w = motor.now.omega_el_rad_s;
    const double r = ROUND_ROTOR.resistance_ohm;
    const double l = ROUND_ROTOR.inductance_d_h;
    const double i_q = -w * r * ROUND_ROTOR.flux_linkage_wb / (r * r + w * w * l * l);
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * 100.0, i_q, plant_motor_i_q(&motor));
}

/* The same switching history in whole and in eighths of its segments. */
static plant_motor_t switched_run(const plant_motor_cfg_t *cfg, int parts)
{
    static const plant_segment_t history[] = {
        {20.0e-6, 0, 7}, {2.0e-6, 0, 6}, {9.0e-6, 1, 6}, {2.0e-6, 1, 4},
        {14.0e-6, 3, 4}, {2.0e-6, 1, 4}, {9.0e-6, 1, 6}, {2.0e-6, 0, 6},
    };

    start(cfg);
    for (int k = 0; k < 800; k++) {
        const plant_segment_t *whole = &history[k % 8];
        for (int p = 0; p < parts; p++) {
            const unsigned turn = ((unsigned)k / 160U) % 3U; /* other legs take the part of a */
            const unsigned high = (((unsigned)whole->high << turn) | (whole->high >> (3U - turn)));
            const unsigned low = (((unsigned)whole->low << turn) | (whole->low >> (3U - turn)));
            run_with(whole->duration_s / parts, high & 7U, low & 7U, DROP_V);
        }
    }
    return motor;
}

static void check_independence_of_cuts(plant_motor_cfg_t cfg)
{
    cfg.inertia_kg_m2 = 0.003;
    cfg.inductance_q_h = 0.02;
    cfg.initial_speed_mech_rad_s = 120.0;
    const plant_motor_t whole = switched_run(&cfg, 1);
    const plant_motor_t cut = switched_run(&cfg, 8);
    /* Steps differ by ACCURACY of phi/L_d = 33 A; each event, some hundred, by its tolerance. */
    const double tolerance_a = ACCURACY * 33.0 + 100.0 * PLANT_BRIDGE_TOLERANCE;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_d(&cut), plant_motor_i_d(&whole));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_q(&cut), plant_motor_i_q(&whole));
    TEST_ASSERT_DOUBLE_WITHIN(ACCURACY * 300.0, cut.now.omega_el_rad_s, whole.now.omega_el_rad_s);
}

TEST(test_result_does_not_depend_on_how_segments_are_cut)
{
    check_independence_of_cuts(ROUND_ROTOR);
    check_independence_of_cuts(with_harmonics());
    check_independence_of_cuts(with_saturation());
}

/*
 * Beside a floating leg the star point follows the EMF: what a magnet of order 5 and 7 adds to the
 * terminal.
 */
TEST(test_floating_terminal_shows_the_emf_of_its_phase)
{
    plant_motor_cfg_t cfg = with_harmonics();

    cfg.initial_speed_mech_rad_s = 50.0;
    for (int k = 0; k < 30; k++) {
        cfg.initial_angle_el_rad = 0.2 * k;
        start(&cfg);
        const plant_vector_t none = {0.0, 0.0};
        const double x = cfg.initial_angle_el_rad;
        const double emf_v =
            -100.0 * cfg.flux_linkage_wb * (sin(x) + 0.05 * sin(5.0 * x) - 0.03 * sin(7.0 * x));
        /*
         * b and c at zero volts without current: the star point is at minus the mean of their EMF,
         * e_a / 2.
         */
        TEST_ASSERT_DOUBLE_WITHIN(
            1.0e-10, 1.5 * emf_v,
            plant_motor_floating_potential(&motor, none, plant_bridge_axis[0]));
    }
}
