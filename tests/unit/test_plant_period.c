/* SPDX-License-Identifier: MIT */
/* The coupled plant, period by period: timing, voltages, bus, snapshots. */
#include "plant_rig.h"
#include "seeded.h"

#include <string.h>

#define DEAD_S 2.0e-6
#define DROP_V 1.2
#define INDUCTANCE_H 0.01

/* Volts: flux linkages of 1 V s with roundings of 2^-53, over a period, some ten operations. */
#define ROUNDING_V 1.0e-10

void setUp(void)
{
    bench(coil(INDUCTANCE_H));
    start();
}

/* A turning motor with all that its drive can have. */
static void bench_drive(void)
{
    bench(ROUND_ROTOR);
    cfg.motor.coulomb_friction_nm = 0.05;
    cfg.motor.initial_speed_mech_rad_s = 40.0;
    cfg.inverter.dead_time_s = DEAD_S;
    cfg.supply.device_drop_v = DROP_V;
    cfg.supply.ripple_fraction = 0.05;
    cfg.supply.ripple_hz = 300.0;
    cfg.sensor.noise_lsb_rms = 1.0;
}

/* Mean phase voltages over the last period that run_coil() ran, from the coil's currents. */
static double mean_v[PLANT_LEGS];

static void run_coil(int periods)
{
    run(periods - 1);
    const plant_view_t before = view;
    run(1);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        mean_v[leg] = INDUCTANCE_H * (view.i_abc_a[leg] - before.i_abc_a[leg]) / PERIOD_S;
    }
}

TEST(test_mean_voltage_of_a_period_is_duty_times_bus)
{
    static const uint32_t compares[][PLANT_LEGS] = {
        {2125, 2125, 2125}, {2126, 2125, 2125}, {4250, 0, 0}, {0, 4250, 4250}, {1234, 3456, 2345},
    };

    for (size_t k = 0; k < sizeof compares / sizeof compares[0]; k++) {
        const uint32_t *const of = compares[k];
        const double star = (double)(of[0] + of[1] + of[2]) / 3.0;
        start();
        plant_write_compare(&plant, of);
        run_coil(2);
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, BUS_V * (of[leg] - star) / COUNTS, mean_v[leg]);
        }
    }
}

TEST(test_compare_acts_one_period_after_it_is_written)
{
    const double up_v = BUS_V * 2000.0 / COUNTS * 2.0 / 3.0;

    write_compare(3000, 1000, 1000);
    run_coil(1);
    TEST_ASSERT_TRUE(mean_v[0] == 0.0);
    write_compare(1000, 3000, 1000);
    run_coil(1);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, up_v, mean_v[0]);
    run_coil(1);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, up_v, mean_v[1]);
    run_coil(1);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, up_v, mean_v[1]);
}

/* With currents i_a > 0, i_b < 0, i_c < 0 that stay so. */
static void run_under_current(void)
{
    start();
    write_compare(3000, 1500, 1500);
    run(11); /* to about 7 A */
    write_compare(2200, 2000, 2100);
    run_coil(2);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > 1.0);
    TEST_ASSERT_TRUE(view.i_abc_a[1] < -1.0);
    TEST_ASSERT_TRUE(view.i_abc_a[2] < -1.0);
}

static void check_leg_shift(double dead_time_s, double drop_v, double shift_v)
{
    /* Legs shift by -x, +x, +x; the star point follows with a third of the sum, x/3. */
    const double shares[PLANT_LEGS] = {-4.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0};
    double ideal_v[PLANT_LEGS];

    bench(coil(INDUCTANCE_H));
    run_under_current();
    memcpy(ideal_v, mean_v, sizeof ideal_v);
    cfg.inverter.dead_time_s = dead_time_s;
    cfg.supply.device_drop_v = drop_v;
    run_under_current();
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, shares[leg] * shift_v, mean_v[leg] - ideal_v[leg]);
    }
}

/* The diode of a dead time drops as the switch before it: the two effects add. */
TEST(test_dead_time_costs_its_share_of_the_bus_and_drop_its_voltage_against_the_current)
{
    check_leg_shift(DEAD_S, 0.0, DEAD_S / PERIOD_S * BUS_V);
    check_leg_shift(0.0, DROP_V, DROP_V);
    check_leg_shift(DEAD_S, DROP_V, DEAD_S / PERIOD_S * BUS_V + DROP_V);
}

TEST(test_equal_legs_leave_a_standing_motor_without_current)
{
    bench_drive();
    cfg.motor.initial_speed_mech_rad_s = 0.0;
    start();
    write_compare(2125, 2125, 2125);
    for (int k = 0; k < 100; k++) {
        run(1);
        TEST_ASSERT_TRUE(view.i_abc_a[0] == 0.0 && view.i_abc_a[1] == 0.0);
        TEST_ASSERT_TRUE(view.omega_mech_rad_s == 0.0);
    }
}

/* A voltage below what dead time and drop take away leaves no mean current behind. */
TEST(test_dead_time_swallows_a_small_voltage)
{
    cfg.motor.resistance_ohm = 1.0;
    cfg.inverter.dead_time_s = DEAD_S;
    start();
    write_compare(2125 + 20, 2125, 2125); /* 40 ticks = 0.47 us < dead time */
    run(2000);
    const double without_dead_time_a = 2.0 / 3.0 * BUS_V * 20.0 / COUNTS; /* 0.97 A */
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) < 0.05 * without_dead_time_a);
}

TEST(test_gates_act_at_once_and_off_lets_the_current_die)
{
    bench_drive();
    cfg.motor.inertia_kg_m2 = 1.0;
    start();
    write_compare(2300, 2000, 2000);
    run(50);
    const double before = view.i_abc_a[0];
    TEST_ASSERT_TRUE(fabs(before) > 1.0);
    plant_set_gates(&plant, false);
    run(1);
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) < 0.9 * fabs(before));
    run(50);
    for (int k = 0; k < 50; k++) {
        run(1);
        TEST_ASSERT_TRUE(view.i_abc_a[0] == 0.0 && view.i_abc_a[1] == 0.0);
    }
}

TEST(test_load_torque_opposes_positive_rotation)
{
    bench_drive();
    start();
    plant_set_gates(&plant, false);
    plant_set_load_torque(&plant, 0.3);
    run(1);
    const double friction = 0.05 + 0.001 * 40.0;
    /* Viscous friction hardly changes in a period: 4e-5 of it. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6, 40.0 - (0.3 + friction) / 0.003 * PERIOD_S,
                              view.omega_mech_rad_s);
}

/* Of the bus with a ripple of 300 Hz. */
static double rippling_v(double time_s)
{
    return BUS_V * (1.0 + 0.05 * sin(2.0 * PLANT_PI * 300.0 * time_s));
}

/* That in the middle of a period makes its voltage. */
TEST(test_bus_ripples_as_a_sine_of_time)
{
    cfg.supply.ripple_fraction = 0.05;
    cfg.supply.ripple_hz = 300.0;
    start();
    for (int k = 0; k < 1000; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(PERIOD_S * 1.0e-6, PERIOD_S * k, view.time_s);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, rippling_v(PERIOD_S * k), view.bus_v);
        run(1);
    }
    start();
    write_compare(COUNTS, 0, 0);
    run(1);
    for (int k = 1; k <= 50; k++) {
        run_coil(1);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, 2.0 / 3.0 * rippling_v(PERIOD_S * (k + 0.5)),
                                  mean_v[0]);
    }
}

TEST(test_sample_reads_the_present_currents_and_bus)
{
    plant_adc_t adc;

    write_compare(2400, 2125, 1900);
    run(10);
    plant_sample(&plant, &adc);
    TEST_ASSERT_EQUAL_UINT16(2048.0 + floor(view.i_abc_a[0] * 102.4 + 0.5), adc.ia);
    TEST_ASSERT_EQUAL_UINT16(2048.0 + floor(view.i_abc_a[1] * 102.4 + 0.5), adc.ib);
    TEST_ASSERT_EQUAL_UINT16(floor(BUS_V * 4096.0 / 400.0 + 0.5), adc.bus);
}

/* At the corner of the sensors they show a current 45 degrees late and smaller by 1/sqrt(2). */
TEST(test_sensors_lag_behind_the_current_of_the_plant)
{
    const double corner_hz = 60.0;

    bench(ROUND_ROTOR); /* that turns in shorted windings */
    cfg.motor.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.motor.initial_speed_mech_rad_s = 2.0 * PLANT_PI * corner_hz / 2.0;
    cfg.sensor.current_bandwidth_hz = corner_hz;
    start();
    write_compare(0, 0, 0);
    run(2000); /* 75 time constants of the sensors, 36 of the winding */
    const double beta = (view.i_abc_a[1] - view.i_abc_a[2]) / sqrt(3.0);
    const double length = hypot(view.i_abc_a[0], beta);
    const double angle = atan2(beta, view.i_abc_a[0]) - 0.25 * PLANT_PI;
    const double seen = sqrt(0.5) * length;
    /* A straight line over a part whose turn is below FOLLOWED_STEP: its square / 12. */
    const double tolerance = 0.05 * 0.05 / 12.0 * length;
    TEST_ASSERT_TRUE(length > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, seen * cos(angle), plant.sensors.seen_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, seen * cos(angle - 2.0 * PLANT_PI / 3.0),
                              plant.sensors.seen_a[1]);
}

/* What a low pass of time constant tau shows at the end of a ramp. */
static double after_ramp(double shown, double from, double slope, double time_s, double tau_s)
{
    const double kept = exp(-time_s / tau_s);

    return from + slope * time_s - slope * tau_s + (shown - from + slope * tau_s) * kept;
}

/* The coil's current rises straight to the comparators' level and falls as fast. */
TEST(test_sensors_lag_across_a_trip_of_the_comparators)
{
    const double slope = 2.0 / 3.0 * BUS_V / INDUCTANCE_H;
    const double tau_s = 30.0e-6;

    cfg.trip_a = 1.5;
    cfg.sensor.current_bandwidth_hz = 1.0 / (2.0 * PLANT_PI * tau_s);
    start();
    write_compare(COUNTS, 0, 0);
    run(2);
    TEST_ASSERT_TRUE(plant_take_trip(&plant));
    const double rise_s = 1.5 / slope;
    const double at_trip = after_ramp(0.0, 0.0, slope, rise_s, tau_s);
    const double at_end = after_ramp(at_trip, 1.5, -slope, PERIOD_S - rise_s, tau_s);
    /* The trip is found within 2^-20 of the period. */
    const double tolerance = 2.0 * 0x1p-20 * PERIOD_S * slope;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, at_end, plant.sensors.seen_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, -0.5 * at_end, plant.sensors.seen_a[1]);
}

TEST(test_view_is_consistent)
{
    bench_drive();
    start();
    write_compare(2300, 2125, 2000);
    run(777);
    const double c = cos(view.theta_el_rad);
    const double s = sin(view.theta_el_rad);
    const double tolerance = 1.0e-12;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, view.i_d_a * c - view.i_q_a * s, view.i_abc_a[0]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, 0.0, view.i_abc_a[0] + view.i_abc_a[1] + view.i_abc_a[2]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, 1.5 * 2.0 * 0.387 * view.i_q_a, view.torque_nm);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, c, cos(2.0 * view.theta_mech_rad));
}

/* Everything an input can do, for so many periods; returns a sum of all conversions. */
static uint64_t eventful_run(int periods)
{
    uint64_t sum = 0;

    for (int k = 0; k < periods; k++) {
        plant_adc_t adc;
        plant_sample(&plant, &adc);
        sum = ((sum * 31U + adc.ia) * 31U + adc.ib) * 31U + adc.bus;
        const double angle = 0.02 * (double)plant.periods;
        write_compare((uint32_t)(2125.0 + 600.0 * cos(angle)),
                      (uint32_t)(2125.0 + 600.0 * cos(angle - 2.0)),
                      (uint32_t)(2125.0 + 600.0 * cos(angle + 2.0)));
        plant_set_gates(&plant, (plant.periods % 500U) > 50U);
        plant_set_load_torque(&plant, (plant.periods > 700U) ? 0.5 : 0.0);
        plant_step(&plant);
    }
    return sum;
}

/* Of an eventful run from the start. */
static uint64_t sum_of_run(int periods)
{
    start();
    return eventful_run(periods);
}

TEST(test_two_runs_give_the_same_bytes_and_another_seed_gives_another_run)
{
    bench_drive();
    const uint64_t sum = sum_of_run(2000);
    const plant_t first = plant;

    TEST_ASSERT_TRUE(sum == sum_of_run(2000));
    TEST_ASSERT_EQUAL_MEMORY(&first, &plant, sizeof plant);
    const uint64_t short_sum = sum_of_run(100);
    cfg.sensor.seed = 2;
    TEST_ASSERT_FALSE(short_sum == sum_of_run(100));
}

TEST(test_a_copy_goes_on_as_the_original)
{
    bench_drive();
    cfg.supply.capacitance_f = 470.0e-6;
    (void)sum_of_run(612);
    const plant_t copy = plant;
    const uint64_t sum = eventful_run(612);
    const plant_t end = plant;

    plant = copy;
    TEST_ASSERT_TRUE(sum == eventful_run(612));
    TEST_ASSERT_EQUAL_MEMORY(&end, &plant, sizeof plant);
}

/*
 * Any compare values, gates on and off, at any speed: currents sum to zero and stay below what the
 * bus and the EMF together could drive through the resistance.
 */
TEST(test_random_operation_stays_within_physical_bounds)
{
    seeded_t seeded = {2463534242U};

    bench_drive();
    for (int pass = 0; pass < 20; pass++) {
        cfg.motor.inductance_q_h = 0.0116 * (0.5 + 0.1 * pass);
        cfg.motor.initial_speed_mech_rad_s = seeded_in(&seeded, -300, 300);
        start();
        bool on = true;
        for (int k = 0; k < 1000; k++) {
            const uint32_t a =
                seeded_u32(&seeded) % (COUNTS + 1U); /* one after the other, in order */
            const uint32_t b = seeded_u32(&seeded) % (COUNTS + 1U);
            const uint32_t c = seeded_u32(&seeded) % (COUNTS + 1U);

            write_compare(a, b, c);
            on = ((seeded_u32(&seeded) % 50U) == 0U) ? !on : on;
            plant_set_gates(&plant, on);
            run(1);
            const double emf_v = fabs(view.omega_mech_rad_s) * 2.0 * 0.387;
            const double limit_a = (1.05 * BUS_V + 2.0 * DROP_V + 2.0 * emf_v) / 2.125;
            for (int leg = 0; leg < PLANT_LEGS; leg++) {
                TEST_ASSERT_TRUE(fabs(view.i_abc_a[leg]) <= limit_a);
            }
            TEST_ASSERT_DOUBLE_WITHIN(1.0e-12, 0.0,
                                      view.i_abc_a[0] + view.i_abc_a[1] + view.i_abc_a[2]);
        }
    }
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    CHECK_REFUSED(motor.inductance_d_h, 0.0);
    CHECK_REFUSED(inverter.timer_counts, 0);
    CHECK_REFUSED(sensor.adc_bits, 4);
    CHECK_REFUSED(supply.voltage_v, 0.0);
    CHECK_REFUSED(supply.ripple_fraction, 1.0);
    CHECK_REFUSED(supply.device_drop_v, 155.0);
}
