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

/*
 * A coil: no resistance, no magnet, too heavy to turn. Its current is the integral of the voltage.
 */
static const plant_cfg_t COIL = {
    .motor = {.pole_pairs = 1,
              .inductance_d_h = INDUCTANCE_H,
              .inductance_q_h = INDUCTANCE_H,
              .inertia_kg_m2 = 1.0e9},
    .inverter = {.pwm_frequency_hz = 1.0 / PERIOD_S, .timer_counts = COUNTS},
    .supply = {.voltage_v = BUS_V},
    .sensor = {.adc_bits = 12, .current_full_scale_a = 20.0, .bus_full_scale_v = 400.0, .seed = 1},
};

static plant_cfg_t drive_cfg(void)
{
    plant_cfg_t cfg = COIL;

    cfg.motor = (plant_motor_cfg_t){
        .pole_pairs = 2,
        .resistance_ohm = 2.125,
        .inductance_d_h = 0.0116,
        .inductance_q_h = 0.0116,
        .flux_linkage_wb = 0.387,
        .inertia_kg_m2 = 0.003,
        .viscous_friction_nm_s = 0.001,
        .coulomb_friction_nm = 0.05,
        .initial_speed_mech_rad_s = 40.0,
    };
    cfg.inverter.dead_time_s = DEAD_S;
    cfg.supply.device_drop_v = DROP_V;
    cfg.supply.ripple_fraction = 0.05;
    cfg.supply.ripple_hz = 300.0;
    cfg.sensor.noise_lsb_rms = 1.0;
    return cfg;
}

/* Mean phase voltages over the next period, from the coil's currents. */
static void mean_phase_voltages(double v[PLANT_LEGS])
{
    plant_view_t before;

    plant_view(&plant, &before);
    run(1);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        v[leg] = INDUCTANCE_H * (view.i_abc_a[leg] - before.i_abc_a[leg]) / PERIOD_S;
    }
}

void setUp(void)
{
    start(&COIL);
}

TEST(test_mean_voltage_of_a_period_is_duty_times_bus)
{
    static const uint32_t compares[][PLANT_LEGS] = {
        {2125, 2125, 2125}, {2126, 2125, 2125}, {4250, 0, 0}, {0, 4250, 4250}, {1234, 3456, 2345},
    };
    double v[PLANT_LEGS];

    for (size_t k = 0; k < sizeof compares / sizeof compares[0]; k++) {
        start(&COIL);
        plant_write_compare(&plant, compares[k]);
        plant_step(&plant);
        mean_phase_voltages(v);
        const double star =
            (double)(compares[k][0] + compares[k][1] + compares[k][2]) / (3.0 * COUNTS);
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            const double duty = (double)compares[k][leg] / COUNTS;
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, BUS_V * (duty - star), v[leg]);
        }
    }
}

TEST(test_compare_acts_one_period_after_it_is_written)
{
    double v[PLANT_LEGS];

    write_compare(3000, 1000, 1000);
    mean_phase_voltages(v);
    TEST_ASSERT_TRUE(v[0] == 0.0);
    write_compare(1000, 3000, 1000);
    mean_phase_voltages(v);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, BUS_V * 2000.0 / COUNTS * 2.0 / 3.0, v[0]);
    mean_phase_voltages(v);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, BUS_V * 2000.0 / COUNTS * 2.0 / 3.0, v[1]);
    mean_phase_voltages(v);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, BUS_V * 2000.0 / COUNTS * 2.0 / 3.0, v[1]);
}

/* Mean voltages with currents i_a > 0, i_b < 0, i_c < 0 that stay so. */
static void voltages_under_current(const plant_cfg_t *cfg, double v[PLANT_LEGS])
{
    start(cfg);
    write_compare(3000, 1500, 1500);
    run(11); /* to about 7 A */
    write_compare(2200, 2000, 2100);
    plant_step(&plant);
    mean_phase_voltages(v);
    TEST_ASSERT_TRUE(view.i_abc_a[0] > 1.0);
    TEST_ASSERT_TRUE(view.i_abc_a[1] < -1.0);
    TEST_ASSERT_TRUE(view.i_abc_a[2] < -1.0);
}

static void check_leg_shift(double dead_time_s, double drop_v, double shift_v)
{
    plant_cfg_t cfg = COIL;
    double ideal[PLANT_LEGS];
    double real[PLANT_LEGS];

    cfg.inverter.dead_time_s = dead_time_s;
    cfg.supply.device_drop_v = drop_v;
    voltages_under_current(&COIL, ideal);
    voltages_under_current(&cfg, real);
    /* Legs shift by -x, +x, +x; the star point follows with a third of the sum, x/3. */
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, -4.0 / 3.0 * shift_v, real[0] - ideal[0]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, 2.0 / 3.0 * shift_v, real[1] - ideal[1]);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, 2.0 / 3.0 * shift_v, real[2] - ideal[2]);
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
    plant_cfg_t cfg = drive_cfg();

    cfg.motor.initial_speed_mech_rad_s = 0.0;
    start(&cfg);
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
    plant_cfg_t cfg = COIL;

    cfg.motor.resistance_ohm = 1.0;
    cfg.inverter.dead_time_s = DEAD_S;
    start(&cfg);
    write_compare(2125 + 20, 2125, 2125); /* 40 ticks = 0.47 us < dead time */
    run(2000);
    const double without_dead_time_a = 2.0 / 3.0 * BUS_V * 20.0 / COUNTS; /* 0.97 A */
    TEST_ASSERT_TRUE(fabs(view.i_abc_a[0]) < 0.05 * without_dead_time_a);
}

TEST(test_gates_act_at_once_and_off_lets_the_current_die)
{
    plant_cfg_t cfg = drive_cfg();

    cfg.motor.inertia_kg_m2 = 1.0;
    start(&cfg);
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
    plant_cfg_t cfg = drive_cfg();

    start(&cfg);
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
    plant_cfg_t cfg = COIL;
    double v[PLANT_LEGS];

    cfg.supply.ripple_fraction = 0.05;
    cfg.supply.ripple_hz = 300.0;
    start(&cfg);
    for (int k = 0; k < 1000; k++) {
        look();
        TEST_ASSERT_DOUBLE_WITHIN(PERIOD_S * 1.0e-6, PERIOD_S * k, view.time_s);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, rippling_v(PERIOD_S * k), view.bus_v);
        plant_step(&plant);
    }
    start(&cfg);
    write_compare(COUNTS, 0, 0);
    plant_step(&plant);
    for (int k = 1; k <= 50; k++) {
        mean_phase_voltages(v);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_V, 2.0 / 3.0 * rippling_v(PERIOD_S * (k + 0.5)), v[0]);
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

/*
 * A magnet that turns in shorted windings at the corner of the sensors: what they show is behind by
 * 45 degrees and smaller by 1/sqrt(2).
 */
TEST(test_sensors_lag_behind_the_current_of_the_plant)
{
    plant_cfg_t cfg = drive_cfg();
    const double corner_hz = 60.0;

    cfg.motor.coulomb_friction_nm = 0.0;
    cfg.motor.inertia_kg_m2 = 1.0e9;
    cfg.motor.initial_speed_mech_rad_s = 2.0 * PLANT_PI * corner_hz / 2.0;
    cfg.inverter.dead_time_s = 0.0;
    cfg.supply.device_drop_v = 0.0;
    cfg.sensor.current_bandwidth_hz = corner_hz;
    start(&cfg);
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

/*
 * The coil's current rises straight to the level of the comparators and falls as fast through the
 * diodes.
 */
TEST(test_sensors_lag_across_a_trip_of_the_comparators)
{
    plant_cfg_t cfg = COIL;
    const double slope = 2.0 / 3.0 * BUS_V / INDUCTANCE_H;
    const double tau_s = 30.0e-6;

    cfg.trip_a = 1.5;
    cfg.sensor.current_bandwidth_hz = 1.0 / (2.0 * PLANT_PI * tau_s);
    start(&cfg);
    write_compare(COUNTS, 0, 0);
    plant_step(&plant);
    plant_step(&plant);
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
    const plant_cfg_t cfg = drive_cfg();

    start(&cfg);
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
static uint64_t eventful_run(plant_t *p, int periods)
{
    uint64_t sum = 0;

    for (int k = 0; k < periods; k++) {
        plant_adc_t adc;
        plant_sample(p, &adc);
        sum = sum * 31U + adc.ia;
        sum = sum * 31U + adc.ib;
        sum = sum * 31U + adc.bus;
        const double angle = 0.02 * (double)p->periods;
        const uint32_t compare[PLANT_LEGS] = {
            (uint32_t)(2125.0 + 600.0 * cos(angle)),
            (uint32_t)(2125.0 + 600.0 * cos(angle - 2.0)),
            (uint32_t)(2125.0 + 600.0 * cos(angle + 2.0)),
        };
        plant_write_compare(p, compare);
        plant_set_gates(p, (p->periods % 500U) > 50U);
        plant_set_load_torque(p, (p->periods > 700U) ? 0.5 : 0.0);
        plant_step(p);
    }
    return sum;
}

/* Of an eventful run from the start. */
static uint64_t sum_of_run(const plant_cfg_t *cfg, int periods)
{
    start(cfg);
    return eventful_run(&plant, periods);
}

TEST(test_two_runs_give_the_same_bytes_and_another_seed_gives_another_run)
{
    plant_cfg_t cfg = drive_cfg();
    const uint64_t sum = sum_of_run(&cfg, 2000);
    const plant_t first = plant;

    TEST_ASSERT_TRUE(sum == sum_of_run(&cfg, 2000));
    TEST_ASSERT_EQUAL_MEMORY(&first, &plant, sizeof plant);
    const uint64_t short_sum = sum_of_run(&cfg, 100);
    cfg.sensor.seed = 2;
    TEST_ASSERT_FALSE(short_sum == sum_of_run(&cfg, 100));
}

TEST(test_a_copy_goes_on_as_the_original)
{
    const plant_cfg_t cfg = drive_cfg();

    (void)sum_of_run(&cfg, 612);
    plant_t copy = plant;
    const uint64_t sum = eventful_run(&plant, 612);
    TEST_ASSERT_TRUE(sum == eventful_run(&copy, 612));
    TEST_ASSERT_EQUAL_MEMORY(&copy, &plant, sizeof plant);
}

/*
 * Any compare values, gates on and off, at any speed: currents sum to zero and stay below what the
 * bus and the EMF together could drive through the resistance.
 */
TEST(test_random_operation_stays_within_physical_bounds)
{
    plant_cfg_t cfg = drive_cfg();
    seeded_t seeded = {2463534242U};

    for (int pass = 0; pass < 20; pass++) {
        cfg.motor.inductance_q_h = 0.0116 * (0.5 + 0.1 * pass);
        cfg.motor.initial_speed_mech_rad_s = seeded_in(&seeded, -300, 300);
        start(&cfg);
        bool on = true;
        for (int k = 0; k < 1000; k++) {
            const uint32_t top = COUNTS;
            write_compare(seeded_u32(&seeded) % (top + 1U), seeded_u32(&seeded) % (top + 1U),
                          seeded_u32(&seeded) % (top + 1U));
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
    copy_of(&COIL)->motor.inductance_d_h = 0.0;
    check_rejected("motor.inductance_d_h");
    copy_of(&COIL)->inverter.timer_counts = 0;
    check_rejected("inverter.timer_counts");
    copy_of(&COIL)->sensor.adc_bits = 4;
    check_rejected("sensor.adc_bits");
    copy_of(&COIL)->supply.voltage_v = 0.0;
    check_rejected("supply.voltage_v");
    copy_of(&COIL)->supply.ripple_fraction = 1.0;
    check_rejected("supply.ripple_fraction");
    copy_of(&COIL)->supply.device_drop_v = 155.0;
    check_rejected("supply.device_drop_v");
}
