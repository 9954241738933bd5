/* SPDX-License-Identifier: MIT */
/* What goes wrong at run time: wires, shaft, the rotor's place, temperature; and comparators. */
#include "plant_rig.h"

#include <string.h>

/* A: currents of some amperes with roundings of 2^-53 in each of some hundred steps. */
#define ROUNDING_A 1.0e-11

static void drive_with(int periods, uint32_t a, uint32_t b, uint32_t c)
{
    write_compare(a, b, c);
    run(periods);
}

/* With a voltage that drives a current in all phases. */
static void drive(int periods)
{
    drive_with(periods, 2400, 2125, 2000);
}

static void check_no_current(int leg)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[leg]);
}

/* Standing for good. */
static void start_standing(void)
{
    cfg.motor.initial_speed_mech_rad_s = 0.0;
    cfg.motor.inertia_kg_m2 = INERTIA_OF_A_WALL;
    start();
}

void setUp(void)
{
    bench(ROUND_ROTOR);
    cfg.motor.inductance_q_h = 0.02;
    cfg.motor.initial_speed_mech_rad_s = 40.0;
    start();
}

TEST(test_an_open_wire_carries_no_current_and_the_other_two_are_a_loop)
{
    for (int phase = 0; phase < PLANT_LEGS; phase++) {
        start();
        drive(20);
        TEST_ASSERT_TRUE(fabs(view.i_abc_a[phase]) > 0.5);
        plant_break_phases(&plant, 1U << (unsigned)phase);
        look();
        check_no_current(phase);
        for (int k = 0; k < 50; k++) {
            drive(1);
            check_no_current(phase);
        }
        TEST_ASSERT_TRUE(fabs(view.i_abc_a[(phase + 1) % PLANT_LEGS]) > 0.1);
    }
}

/* Two phases in series take (d_a - d_b) * bus over 2 R. */
TEST(test_the_loop_of_two_phases_has_both_resistances)
{
    start_standing();
    plant_break_phases(&plant, 4U);
    drive_with(3000, 2225, 2125, 0); /* 20 L/R and more */
    const double expected = 100.0 / COUNTS * BUS_V / (2.0 * ROUND_ROTOR.resistance_ohm);
    /* The sample in the middle of the low sides sees the mean of the ripple. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * expected, expected, view.i_abc_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, -view.i_abc_a[0], view.i_abc_a[1]);
}

TEST(test_two_open_wires_leave_no_current_at_all)
{
    drive(20);
    plant_break_phases(&plant, 5U);
    for (int k = 0; k < 50; k++) {
        drive(1);
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            check_no_current(leg);
        }
    }
}

TEST(test_a_wire_that_is_closed_again_carries_current_again)
{
    plant_break_phases(&plant, 1U);
    drive(20);
    plant_break_phases(&plant, 0U);
    drive(20);
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) > 0.5);
}

TEST(test_an_open_wire_holds_with_dead_time_drop_and_open_gates)
{
    cfg.inverter.dead_time_s = 2.0e-6;
    cfg.supply.device_drop_v = 1.2;
    cfg.motor.initial_speed_mech_rad_s = 300.0;
    start();
    plant_break_phases(&plant, 2U);
    for (int k = 0; k < 400; k++) {
        plant_set_gates(&plant, (k % 100) < 50);
        drive(1);
        check_no_current(1);
    }
}

TEST(test_a_blocked_shaft_stands_whatever_pulls_and_a_released_one_turns)
{
    drive(20);
    plant_block_rotor(&plant, true);
    plant_set_load_torque(&plant, -50.0);
    look();
    const double held_rad = view.theta_mech_rad;
    drive(100);
    TEST_ASSERT_TRUE(view.omega_mech_rad_s == 0.0);
    TEST_ASSERT_TRUE(view.theta_mech_rad == held_rad);
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) > 1.0);
    plant_block_rotor(&plant, false);
    plant_set_gates(&plant, false);
    run(200);
    /* 50 N m on 0.003 kg m2 for 20 ms; the currents' torque, some N m, decays within the first. */
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 333.0, 333.0, view.omega_mech_rad_s);
}

TEST(test_a_blocked_shaft_holds_with_coulomb_friction_and_open_wires_too)
{
    cfg.motor.coulomb_friction_nm = 0.05;
    start();
    plant_block_rotor(&plant, true);
    plant_break_phases(&plant, 1U);
    drive(100);
    plant_set_gates(&plant, false);
    drive(100);
    TEST_ASSERT_TRUE(view.omega_mech_rad_s == 0.0);
}

/* w' = -c/J w^2: w = w_0/(1 + w_0 c t/J). A weak magnet's EMF below the bus takes no part. */
TEST(test_a_fan_alone_slows_the_shaft_hyperbolically_either_way)
{
    const double seconds = 0.2;
    const double rad_s[] = {400.0, -400.0, 5.0e4};

    cfg.motor.flux_linkage_wb = 1.0e-4;
    cfg.motor.viscous_friction_nm_s = 0.0;
    cfg.fan_nm_s2 = 1.0e-4;
    for (int k = 0; k < 3; k++) {
        cfg.motor.initial_speed_mech_rad_s = rad_s[k];
        start();
        plant_set_gates(&plant, false);
        run((int)(seconds / PERIOD_S));
        const double wanted =
            rad_s[k] / (1.0 + fabs(rad_s[k]) * cfg.fan_nm_s2 * seconds / cfg.motor.inertia_kg_m2);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9 * fabs(wanted), wanted, view.omega_mech_rad_s);
    }
}

TEST(test_a_fan_comes_on_top_of_the_load)
{
    const double slowing = 1.0e-3 * 40.0;
    const double fan_nm = slowing * 40.0 / (1.0 + slowing * PERIOD_S / cfg.motor.inertia_kg_m2);

    cfg.fan_nm_s2 = 1.0e-3;
    start();
    plant_set_load_torque(&plant, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 2.0 + fan_nm, plant.motor.load_torque_nm);
    plant_set_load_torque(&plant, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, fan_nm, plant.motor.load_torque_nm);
}

/* A voltage along leg a drives the phase that hangs there; sensors and wire are the leg's. */
TEST(test_a_phase_is_driven_seen_and_opened_at_the_leg_where_it_hangs)
{
    static const unsigned WIRES[][PLANT_LEGS] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2},
                                                 {1, 2, 0}, {0, 1, 2}, {2, 0, 1}};

    cfg.motor = ROUND_ROTOR;
    for (int k = 0; k < 6; k++) {
        plant_adc_t adc;
        memcpy(cfg.wire, WIRES[k], sizeof cfg.wire);
        start();
        plant_block_rotor(&plant, true);
        drive_with(400, 2225, 2125, 2125);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, -2.0 * view.i_abc_a[1], view.i_abc_a[0]);
        TEST_ASSERT_TRUE(view.i_abc_a[0] > 1.0);
        plant_sample(&plant, &adc);
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 2048.0 + view.i_abc_a[0] * 102.4, (double)adc.ia);
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 2048.0 + view.i_abc_a[1] * 102.4, (double)adc.ib);
        plant_break_phases(&plant, 1U);
        run(10);
        check_no_current(0);
    }
}

/* Along leg a the rotor comes to rest at the angle 0 of the terminals. */
TEST(test_the_angle_is_counted_from_leg_a_where_the_wires_are_in_order)
{
    cfg.motor.viscous_friction_nm_s = 0.3;
    cfg.motor.initial_speed_mech_rad_s = 0.0;
    cfg.motor.initial_angle_el_rad = 1.0;
    for (unsigned shift = 0; shift < PLANT_LEGS; shift++) {
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            cfg.wire[leg] = shift;
        }
        start();
        drive_with(20000, 2325, 2125, 2125);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-3, 0.0, view.theta_el_rad);
    }
}

TEST(test_a_turned_rotor_keeps_currents_and_speed_and_is_elsewhere)
{
    const double turn_rad = 1.25;

    drive(20);
    const plant_view_t before = view;
    plant_turn_rotor(&plant, turn_rad);
    look();
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, before.i_abc_a[leg], view.i_abc_a[leg]);
    }
    TEST_ASSERT_TRUE(view.omega_mech_rad_s == before.omega_mech_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-12, turn_rad / 2.0, view.theta_mech_rad - before.theta_mech_rad);
    TEST_ASSERT_DOUBLE_WITHIN(
        ROUNDING_A, before.i_d_a * cos(turn_rad) + before.i_q_a * sin(turn_rad), view.i_d_a);
}

#define TRIP_A 5.0
#define VECTOR_V (2.0 / 3.0 * BUS_V) /* one leg against the two others */

/* A: what motor.h states for the currents of a transient, 1e-6 of phi/L_d. */
#define TRANSIENT_A 3.4e-5

/* A standing motor with comparators for that current: six periods of the bus into phase a. */
static void push(double trip_a)
{
    cfg.trip_a = trip_a;
    start_standing();
    drive_with(6, COUNTS, 0, 0);
}

/*
 * The bus acts from the second period on, 1.8 A a period: 5 A flow in the fourth. Then the diodes
 * put the bus against it. An R-L circuit, along phase a of a rotor at angle 0.
 */
static void check_trip(double sign)
{
    const uint32_t into = (sign > 0.0) ? COUNTS : 0U;
    const double rate = ROUND_ROTOR.resistance_ohm / ROUND_ROTOR.inductance_d_h;
    const double end_a = VECTOR_V / ROUND_ROTOR.resistance_ohm;
    const double falling_s = 3.0 * PERIOD_S + log(1.0 - TRIP_A / end_a) / rate;

    cfg.trip_a = TRIP_A;
    start_standing();
    drive_with(3, into, COUNTS - into, COUNTS - into);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    run(1);
    TEST_ASSERT_DOUBLE_WITHIN(
        TRANSIENT_A, sign * ((TRIP_A + end_a) * exp(-rate * falling_s) - end_a), view.i_abc_a[0]);
    TEST_ASSERT_TRUE(plant_take_trip(&plant));
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
}

TEST(test_comparators_open_the_switches_at_the_instant_of_their_current_in_each_direction)
{
    check_trip(1.0);
    check_trip(-1.0);
}

TEST(test_switches_that_comparators_opened_stay_open_until_they_are_enabled_again)
{
    cfg.supply.device_drop_v = 1.2;
    push(TRIP_A);
    TEST_ASSERT_TRUE(plant_take_trip(&plant));
    run(20);
    check_no_current(0);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    plant_set_gates(&plant, true);
    run(2);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > 2.0);
}

TEST(test_without_comparators_and_below_their_current_nothing_opens)
{
    push(0.0);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > TRIP_A);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    push(view.i_abc_a[0] + TRANSIENT_A);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
}

TEST(test_a_field_out_of_range_is_named)
{
    CHECK_REFUSED(trip_a, -1.0);
    CHECK_REFUSED(trip_a, nan(""));
    CHECK_REFUSED(fan_nm_s2, -1.0);
    cfg.wire[0] = 1U;
    check_refused(&cfg, "wire");
}

TEST(test_temperature_is_that_of_the_room_until_it_is_set)
{
    plant_adc_t adc;

    plant_sample(&plant, &adc);
    TEST_ASSERT_EQUAL_UINT16(1500, adc.temperature); /* 75 degrees above -50, 0.05 a count */
    plant_set_temperature(&plant, 100.0);
    plant_sample(&plant, &adc);
    TEST_ASSERT_EQUAL_UINT16(3000, adc.temperature);
}
