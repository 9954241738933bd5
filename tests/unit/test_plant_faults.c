/* SPDX-License-Identifier: MIT */
/*
 * What can go wrong at run time: wires, shaft, the rotor's place, the temperature; and what
 * comparators do about it.
 */
#include "plant_rig.h"

#define RESISTANCE_OHM 2.125
#define ALL_PHASES 3

/* A: currents of some amperes with roundings of 2^-53 in each of some hundred steps. */
#define ROUNDING_A 1.0e-11

static const plant_cfg_t DRIVE = {
    .motor = {.pole_pairs = 2,
              .resistance_ohm = RESISTANCE_OHM,
              .inductance_d_h = 0.0116,
              .inductance_q_h = 0.02,
              .flux_linkage_wb = 0.387,
              .inertia_kg_m2 = 0.003,
              .viscous_friction_nm_s = 0.001,
              .initial_speed_mech_rad_s = 40.0},
    .inverter = {.pwm_frequency_hz = 1.0 / PERIOD_S, .timer_counts = COUNTS},
    .supply = {.voltage_v = BUS_V},
    .sensor = {.adc_bits = 12,
               .current_full_scale_a = 20.0,
               .bus_full_scale_v = 400.0,
               .temperature = {{-50.0, 0.0}, {154.8, 1.0}},
               .temperature_points = 2,
               .seed = 1},
};

static void drive(int periods, uint32_t a, uint32_t b, uint32_t c)
{
    write_compare(a, b, c);
    run(periods);
}

void setUp(void)
{
    start(&DRIVE);
}

TEST(test_an_open_wire_carries_no_current_and_the_other_two_are_a_loop)
{
    for (int phase = 0; phase < ALL_PHASES; phase++) {
        start(&DRIVE);
        drive(20, 2400, 2125, 2000);
        TEST_ASSERT_TRUE(fabs(view.i_abc_a[phase]) > 0.5);
        plant_break_phases(&plant, 1U << (unsigned)phase);
        look();
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[phase]);
        for (int k = 0; k < 50; k++) {
            drive(1, 2400, 2125, 2000);
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[phase]);
        }
        TEST_ASSERT_TRUE(fabs(view.i_abc_a[(phase + 1) % ALL_PHASES]) > 0.1);
    }
}

/* Standing: two phases in series take (d_a - d_b) * bus over 2 R. */
TEST(test_the_loop_of_two_phases_has_both_resistances)
{
    plant_cfg_t cfg = DRIVE;

    cfg.motor.initial_speed_mech_rad_s = 0.0;
    cfg.motor.inertia_kg_m2 = 1.0e9;
    start(&cfg);
    plant_break_phases(&plant, 4U);
    drive(3000, 2225, 2125, 0); /* 20 L/R and more */
    const double expected = 100.0 / COUNTS * BUS_V / (2.0 * RESISTANCE_OHM);
    /* The sample in the middle of the low sides sees the mean of the ripple. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * expected, expected, view.i_abc_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, -view.i_abc_a[0], view.i_abc_a[1]);
}

TEST(test_two_open_wires_leave_no_current_at_all)
{
    drive(20, 2400, 2125, 2000);
    plant_break_phases(&plant, 5U);
    for (int k = 0; k < 50; k++) {
        drive(1, 2400, 2125, 2000);
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[leg]);
        }
    }
}

TEST(test_a_wire_that_is_closed_again_carries_current_again)
{
    plant_break_phases(&plant, 1U);
    drive(20, 2400, 2125, 2000);
    plant_break_phases(&plant, 0U);
    drive(20, 2400, 2125, 2000);
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) > 0.5);
}

TEST(test_an_open_wire_holds_with_dead_time_drop_and_open_gates)
{
    plant_cfg_t cfg = DRIVE;

    cfg.inverter.dead_time_s = 2.0e-6;
    cfg.supply.device_drop_v = 1.2;
    cfg.motor.initial_speed_mech_rad_s = 300.0;
    start(&cfg);
    plant_break_phases(&plant, 2U);
    for (int k = 0; k < 400; k++) {
        plant_set_gates(&plant, (k % 100) < 50);
        drive(1, 2400, 2125, 2000);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[1]);
    }
}

TEST(test_a_blocked_shaft_stands_whatever_pulls_and_a_released_one_turns)
{
    drive(20, 2400, 2125, 2000);
    plant_block_rotor(&plant, true);
    plant_set_load_torque(&plant, -50.0);
    look();
    const double held_rad = view.theta_mech_rad;
    drive(100, 2400, 2125, 2000);
    TEST_ASSERT_TRUE(view.omega_mech_rad_s == 0.0);
    TEST_ASSERT_TRUE(view.theta_mech_rad == held_rad);
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) > 1.0);
    plant_block_rotor(&plant, false);
    plant_set_gates(&plant, false);
    drive(200, 2125, 2125, 2125);
    /* 50 N m on 0.003 kg m2 for 20 ms; the currents' torque, some N m, decays within the first. */
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 333.0, 333.0, view.omega_mech_rad_s);
}

TEST(test_a_blocked_shaft_holds_with_coulomb_friction_and_open_wires_too)
{
    plant_cfg_t cfg = DRIVE;

    cfg.motor.coulomb_friction_nm = 0.05;
    start(&cfg);
    plant_block_rotor(&plant, true);
    plant_break_phases(&plant, 1U);
    drive(100, 2400, 2125, 2000);
    plant_set_gates(&plant, false);
    drive(100, 2400, 2125, 2000);
    TEST_ASSERT_TRUE(view.omega_mech_rad_s == 0.0);
}

/*
 * w' = -c/J w^2 from w_0 on: w = w_0/(1 + w_0 c t/J). A weak magnet, whose EMF stays below the bus,
 * takes no part.
 */
TEST(test_a_fan_alone_slows_the_shaft_hyperbolically_either_way)
{
    const double fan = 1.0e-4;
    const double seconds = 0.2;
    const double rad_s[] = {400.0, -400.0, 5.0e4};

    for (int k = 0; k < 3; k++) {
        plant_cfg_t cfg = DRIVE;
        cfg.motor.flux_linkage_wb = 1.0e-4;
        cfg.motor.viscous_friction_nm_s = 0.0;
        cfg.motor.initial_speed_mech_rad_s = rad_s[k];
        cfg.fan_nm_s2 = fan;
        start(&cfg);
        plant_set_gates(&plant, false);
        run((int)(seconds / PERIOD_S));
        const double wanted =
            rad_s[k] / (1.0 + fabs(rad_s[k]) * fan * seconds / cfg.motor.inertia_kg_m2);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9 * fabs(wanted), wanted, view.omega_mech_rad_s);
    }
}

TEST(test_a_fan_comes_on_top_of_the_load)
{
    plant_cfg_t cfg = DRIVE;

    const double slowing = 1.0e-3 * 40.0;
    const double fan_nm = slowing * 40.0 / (1.0 + slowing * PERIOD_S / cfg.motor.inertia_kg_m2);

    cfg.fan_nm_s2 = 1.0e-3;
    start(&cfg);
    plant_set_load_torque(&plant, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 2.0 + fan_nm, plant.motor.load_torque_nm);
    plant_set_load_torque(&plant, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, fan_nm, plant.motor.load_torque_nm);
}

/*
 * A voltage along leg a drives the current of the phase that hangs there, and the sensors and the
 * wire are the leg's.
 */
TEST(test_a_phase_is_driven_seen_and_opened_at_the_leg_where_it_hangs)
{
    static const unsigned WIRES[][PLANT_LEGS] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2},
                                                 {1, 2, 0}, {0, 1, 2}, {2, 0, 1}};

    for (int k = 0; k < 6; k++) {
        plant_cfg_t cfg = DRIVE;
        plant_adc_t adc;
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            cfg.wire[leg] = WIRES[k][leg];
        }
        cfg.motor.inductance_q_h = cfg.motor.inductance_d_h;
        cfg.motor.initial_speed_mech_rad_s = 0.0;
        start(&cfg);
        plant_block_rotor(&plant, true);
        drive(400, 2225, 2125, 2125);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, -2.0 * view.i_abc_a[1], view.i_abc_a[0]);
        TEST_ASSERT_TRUE(view.i_abc_a[0] > 1.0);
        plant_sample(&plant, &adc);
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 2048.0 + view.i_abc_a[0] * 102.4, (double)adc.ia);
        TEST_ASSERT_DOUBLE_WITHIN(0.51, 2048.0 + view.i_abc_a[1] * 102.4, (double)adc.ib);
        plant_break_phases(&plant, 1U);
        drive(10, 2225, 2125, 2125);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[0]);
    }
}

/* Along leg a the rotor comes to rest at the angle 0 of the terminals. */
TEST(test_the_angle_is_counted_from_leg_a_where_the_wires_are_in_order)
{
    for (unsigned shift = 0; shift < PLANT_LEGS; shift++) {
        plant_cfg_t cfg = DRIVE;
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            cfg.wire[leg] = shift;
        }
        cfg.motor.viscous_friction_nm_s = 0.3;
        cfg.motor.initial_speed_mech_rad_s = 0.0;
        cfg.motor.initial_angle_el_rad = 1.0;
        start(&cfg);
        drive(20000, 2325, 2125, 2125);
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-3, 0.0, view.theta_el_rad);
    }
}

TEST(test_a_turned_rotor_keeps_currents_and_speed_and_is_elsewhere)
{
    const double turn_rad = 1.25;
    plant_view_t before;

    drive(20, 2400, 2125, 2000);
    before = view;
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
#define INDUCTANCE_H 0.0116          /* along phase a of a rotor at angle 0 */

/* A: what motor.h states for the currents of a transient, 1e-6 of phi/L_d. */
#define TRANSIENT_A 3.4e-5

static void start_standing(double trip_a, double drop_v)
{
    plant_cfg_t cfg = DRIVE;

    cfg.motor.initial_speed_mech_rad_s = 0.0;
    cfg.motor.inertia_kg_m2 = 1.0e9;
    cfg.supply.device_drop_v = drop_v;
    cfg.trip_a = trip_a;
    start(&cfg);
}

/* R-L circuit, from a current at a voltage after a time. */
static double settled(double from_a, double volt, double time_s)
{
    const double end_a = volt / RESISTANCE_OHM;

    return end_a + (from_a - end_a) * exp(-time_s * RESISTANCE_OHM / INDUCTANCE_H);
}

/*
 * The whole bus into phase a from the second period on, 1.8 A a period: 5 A flow in the fourth.
 * Then the diodes put the bus against it.
 */
static void check_trip(double sign)
{
    const uint32_t into = (sign > 0.0) ? COUNTS : 0U;
    const double trip_s =
        -log(1.0 - TRIP_A * RESISTANCE_OHM / VECTOR_V) * INDUCTANCE_H / RESISTANCE_OHM;

    start_standing(TRIP_A, 0.0);
    drive(3, into, COUNTS - into, COUNTS - into);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    drive(1, into, COUNTS - into, COUNTS - into);
    TEST_ASSERT_DOUBLE_WITHIN(
        TRANSIENT_A, sign * settled(TRIP_A, -VECTOR_V, (3.0 * PERIOD_S) - trip_s), view.i_abc_a[0]);
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
    start_standing(TRIP_A, 1.2);
    drive(6, COUNTS, 0, 0);
    TEST_ASSERT_TRUE(plant_take_trip(&plant));
    drive(20, COUNTS, 0, 0);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_A, 0.0, view.i_abc_a[0]);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    plant_set_gates(&plant, true);
    drive(2, COUNTS, 0, 0);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > 2.0);
}

TEST(test_without_comparators_and_below_their_current_nothing_opens)
{
    start_standing(0.0, 0.0);
    drive(6, COUNTS, 0, 0);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > TRIP_A);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
    start_standing(view.i_abc_a[0] + TRANSIENT_A, 0.0);
    drive(6, COUNTS, 0, 0);
    TEST_ASSERT_FALSE(plant_take_trip(&plant));
}

TEST(test_a_comparator_current_out_of_range_is_named)
{
    copy_of(&DRIVE)->trip_a = -1.0;
    check_rejected("trip_a");
    copy_of(&DRIVE)->fan_nm_s2 = -1.0;
    check_rejected("fan_nm_s2");
    copy_of(&DRIVE)->wire[0] = 1U;
    check_rejected("wire");
    copy_of(&DRIVE)->trip_a = nan("");
    check_rejected("trip_a");
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
