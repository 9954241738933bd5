/* SPDX-License-Identifier: MIT */
/* Soft commutation: the charge of the output capacitance, the energy, and the limits. */
#include "knee.h"
#include "plant_rig.h"

#define DEAD_S 2.0e-6
#define DROP_V 1.2
#define KNEE_A 0.3

/* So large that no voltage here changes the current of a period by more than RIPPLE_A. */
#define CHOKE_H 10.0
#define RIPPLE_A (BUS_V * PERIOD_S / CHOKE_H)

void setUp(void)
{
    bench(coil(CHOKE_H));
    cfg.inverter.dead_time_s = DEAD_S;
    cfg.supply.commutation_knee_a = KNEE_A;
}

static double i_a(const plant_motor_t *motor)
{
    return plant_motor_current(motor).alpha;
}

/*
 * Volt-seconds that a leg loses against a current i > 0 in the dead times of one period: the
 * current takes the charge of the output capacitance, C = i_k t_d / U, from one rail to the other.
 */
static double lost_vs(double current_a)
{
    const double capacitance_f = KNEE_A * DEAD_S / BUS_V;
    const double swing_s = capacitance_f * BUS_V / current_a;
    /* Before it goes high the leg stays low for the whole dead time, where the current keeps it. */
    const double rising = BUS_V * DEAD_S;
    /* Before it goes low it falls by i/C from the bus to zero, or until the switch closes. */
    const double ramp_s = fmin(swing_s, DEAD_S);
    const double kept = BUS_V * ramp_s - 0.5 * current_a / capacitance_f * ramp_s * ramp_s;

    return rising - kept;
}

/* Mean voltage of phase a over a period at equal duty, with i_a and half of it back in b and c. */
static double mean_voltage(double current_a)
{
    start();
    write_compare(COUNTS / 2U, COUNTS / 2U, COUNTS / 2U);
    run(2);
    plant.motor.now.flux_d_wb = CHOKE_H * current_a;
    plant_step(&plant);
    return CHOKE_H * (i_a(&plant.motor) - current_a) / PERIOD_S;
}

TEST(test_a_leg_loses_what_the_charge_of_its_output_takes)
{
    static const double CURRENTS_A[] = {0.01, 0.1, 0.3, 0.45, 0.6, 1.0, 3.0, 20.0};
    /* The slope of BUS_V DEAD_S / PERIOD_S f(i / knee) is at most half of that over the knee. */
    const double tolerance_v = BUS_V * DEAD_S / PERIOD_S / (2.0 * KNEE_A) * RIPPLE_A;

    for (size_t k = 0; k < sizeof CURRENTS_A / sizeof CURRENTS_A[0]; k++) {
        const double i = CURRENTS_A[k];
        const double whole = lost_vs(i) / PERIOD_S;
        const double half = lost_vs(0.5 * i) / PERIOD_S;
        /* a loses against i, b and c gain: against the star point two thirds of the sum. */
        const double wanted = -2.0 / 3.0 * (whole + half);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, wanted, mean_voltage(i));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, -wanted, mean_voltage(-i));
    }
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, 0.0, mean_voltage(0.0));
}

TEST(test_at_the_knee_dead_time_and_drop_take_half)
{
    const double tolerance_v = (BUS_V * DEAD_S / PERIOD_S + DROP_V) / (2.0 * KNEE_A) * RIPPLE_A;

    cfg.supply.device_drop_v = DROP_V;
    const double all_v = BUS_V * DEAD_S / PERIOD_S + DROP_V;
    /* a is at its knee, b and c at half of theirs. */
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, -2.0 / 3.0 * (0.5 + 0.25) * all_v, mean_voltage(KNEE_A));
    /* Far beyond, f = 1 - knee / (2 i): of a, and of b and c at half the current. */
    const double far_a = 200.0 * KNEE_A;
    const double shares = (1.0 - 0.5 / 200.0) + (1.0 - 0.5 / 100.0);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, -2.0 / 3.0 * shares * all_v, mean_voltage(far_a));
}

/* A switching history of 100 us with every kind of segment. */
static const plant_segment_t HISTORY[] = {
    {20.0e-6, 0, 7}, {2.0e-6, 0, 6}, {9.0e-6, 1, 6}, {2.0e-6, 1, 4},
    {14.0e-6, 3, 4}, {2.0e-6, 0, 0}, {9.0e-6, 4, 3}, {42.0e-6, 0, 7},
};
#define SEGMENTS (sizeof HISTORY / sizeof HISTORY[0])

static plant_motor_t motor_with(double inductance_h, double speed_mech_rad_s)
{
    cfg.motor = ROUND_ROTOR;
    cfg.motor.inductance_d_h = inductance_h;
    cfg.motor.inductance_q_h = inductance_h;
    cfg.motor.inertia_kg_m2 = INERTIA_OF_A_WALL;
    cfg.motor.initial_speed_mech_rad_s = speed_mech_rad_s;
    start();
    return plant.motor;
}

/*
 * What the bus gives is what the shaft, the windings' heat and field, and the drops take; with h
 * for the trapezoidal rule, the drops' heat is drop f i of each leg.
 */
TEST(test_energy_from_the_bus_is_conserved)
{
    const double h = 0.25e-6;
    const plant_rails_t rails = {.bus_v = BUS_V, .drop_v = DROP_V, .knee_a = KNEE_A};
    plant_motor_t motor = motor_with(ROUND_ROTOR.inductance_d_h, 60.0);
    double charge_c = 0.0;
    double out_j = 0.0;
    double before_w = 0.0;

    for (size_t k = 0; k < 40U * SEGMENTS; k++) {
        const int parts = (int)(HISTORY[k % SEGMENTS].duration_s / h + 0.5);
        plant_segment_t part = HISTORY[k % SEGMENTS];
        part.duration_s = h;
        for (int p = 0; p < parts; p++) {
            plant_knee_run(&motor, &part, &rails, &charge_c);
            double i[PLANT_LEGS];
            plant_phases(plant_motor_current(&motor), i);
            double w =
                plant_motor_torque(&motor) * motor.now.omega_el_rad_s / ROUND_ROTOR.pole_pairs;
            for (int leg = 0; leg < PLANT_LEGS; leg++) {
                const double z = fabs(i[leg]) / KNEE_A;
                const double f = (z <= 1.0) ? 0.5 * z : 1.0 - 0.5 / z;
                w += ROUND_ROTOR.resistance_ohm * i[leg] * i[leg] + DROP_V * f * fabs(i[leg]);
            }
            out_j += 0.5 * h * (w + before_w);
            before_w = w;
        }
        plant_motor_wrap(&motor);
    }
    const double i_d = plant_motor_i_d(&motor);
    const double i_q = plant_motor_i_q(&motor);
    const double field_j = 0.75 * ROUND_ROTOR.inductance_d_h * (i_d * i_d + i_q * i_q);
    const double in_j = charge_c * BUS_V;
    /*
     * Trapezoidal rule: of the power, which turns in 2 pi / w, (w h)^2 / 12 = 1e-10; of the charge
     * of an open leg, whose current changes by 310 V / L h in a part, (that / knee)^2 / 12 = 4e-5
     * of what flows in dead times.
     */
    TEST_ASSERT_TRUE(fabs(in_j) > 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(4.0e-5 * fabs(in_j), in_j, out_j + field_j);
}

/* By that history, each segment in so many parts; without a knee of ideal diodes. */
static plant_motor_t switched(double knee_a, int parts)
{
    void (*const run_one)(plant_motor_t *, const plant_segment_t *, const plant_rails_t *,
                          double *) = (knee_a > 0.0) ? plant_knee_run : plant_bridge_run;
    const plant_rails_t rails = {.bus_v = BUS_V, .drop_v = DROP_V, .knee_a = knee_a};
    plant_motor_t motor = motor_with(ROUND_ROTOR.inductance_d_h, 60.0);

    for (size_t k = 0; k < 100U * SEGMENTS; k++) {
        plant_segment_t part = HISTORY[k % SEGMENTS];
        part.duration_s /= parts;
        for (int p = 0; p < parts; p++) {
            run_one(&motor, &part, &rails, NULL);
        }
        plant_motor_wrap(&motor);
    }
    return motor;
}

TEST(test_result_does_not_depend_on_how_segments_are_cut)
{
    const plant_motor_t whole = switched(KNEE_A, 1);
    const plant_motor_t cut = switched(KNEE_A, 16);
    /* One step a dead time, x = 0.05: what the kink of f at the knee leaves. */
    const double tolerance_a = 1.0e-4 * KNEE_A;

    TEST_ASSERT_TRUE(fabs(i_a(&whole)) > KNEE_A);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_d(&cut), plant_motor_i_d(&whole));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_q(&cut), plant_motor_i_q(&whole));
}

/*
 * One leg is open beside two at the same rail. In the first part of a dead time its current passes
 * zero, then it approaches the value at which the leg is at their rail as well.
 */
TEST(test_a_small_inductance_is_followed_through_zero)
{
    const plant_segment_t to_low = {2.0e-6, 0, 6};
    const plant_segment_t to_high = {2.0e-6, 6, 0};
    const plant_rails_t rails = {.bus_v = BUS_V, .knee_a = KNEE_A};
    plant_motor_t whole = motor_with(0.1e-3, 0.0);
    plant_motor_t cut = whole;

    for (int k = 0; k < 100; k++) {
        plant_segment_t part = ((k % 2) == 0) ? to_low : to_high;
        plant_knee_run(&whole, &part, &rails, NULL);
        part.duration_s /= 64.0;
        for (int p = 0; p < 64; p++) {
            plant_knee_run(&cut, &part, &rails, NULL);
        }
        /* Steps of x <= 0.5 against some of x <= 0.1, in a current of a few knees. */
        TEST_ASSERT_TRUE(fabs(i_a(&whole)) > KNEE_A);
        TEST_ASSERT_DOUBLE_WITHIN(10.0 * 2.6e-4 * KNEE_A, i_a(&cut), i_a(&whole));
    }
}

/* Of a small knee only knee / (2 i) is left, and that of what a leg loses. */
TEST(test_a_small_knee_is_an_ideal_diode)
{
    const double knee_a = 1.0e-3;
    const plant_motor_t soft = switched(knee_a, 1);
    const plant_motor_t hard = switched(0.0, 1);
    const double lost_v = BUS_V * 4.0e-6 / 100.0e-6 + DROP_V;
    const double tolerance_a = lost_v / ROUND_ROTOR.resistance_ohm * knee_a;

    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_d(&hard), plant_motor_i_d(&soft));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_a, plant_motor_i_q(&hard), plant_motor_i_q(&soft));
}

/* Phase a is broken, b open, c low: what b has left of the bus drives two phases. */
TEST(test_a_broken_phase_floats_beside_soft_legs)
{
    const plant_segment_t segment = {0.5e-3, 0, 4};
    const plant_rails_t rails = {.bus_v = BUS_V, .knee_a = KNEE_A, .broken = 1};
    plant_motor_t motor = motor_with(ROUND_ROTOR.inductance_d_h, 0.0);
    double i[PLANT_LEGS];

    for (int k = 0; k < 100; k++) {
        plant_knee_run(&motor, &segment, &rails, NULL);
        plant_phases(plant_motor_current(&motor), i);
        TEST_ASSERT_TRUE(fabs(i[0]) <= PLANT_BRIDGE_TOLERANCE);
    }
    /* Beyond the knee the potential of b is bus knee / (4 i): all of it is at 2 R. */
    const double wanted_a = sqrt(BUS_V * KNEE_A / (8.0 * ROUND_ROTOR.resistance_ohm));
    TEST_ASSERT_TRUE(wanted_a > KNEE_A);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6 * wanted_a, wanted_a, i[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6 * wanted_a, -wanted_a, i[2]);
}

TEST(test_without_gates_the_diodes_let_the_current_die)
{
    cfg.motor = ROUND_ROTOR;
    start();
    plant.motor.now.flux_d_wb += ROUND_ROTOR.inductance_d_h * 0.5;
    plant_set_gates(&plant, false);
    run(2);
    TEST_ASSERT_TRUE(i_a(&plant.motor) == 0.0);
}

/* The level is reached in the first period; then the bus takes the current to zero. */
TEST(test_after_a_trip_the_diodes_let_the_current_die)
{
    cfg.motor = ROUND_ROTOR;
    cfg.motor.resistance_ohm = 0.0;
    cfg.trip_a = 0.5;
    start();
    write_compare(COUNTS, 0, 0);
    run(2);
    TEST_ASSERT_TRUE(plant_take_trip(&plant));
    TEST_ASSERT_TRUE(i_a(&plant.motor) == 0.0);
}

TEST(test_a_knee_that_takes_too_many_steps_is_refused)
{
    cfg.motor = ROUND_ROTOR;
    const double least_a = plant_least_knee(&cfg);
    /* Six dead times of half the bus on the inductance, 1000 steps of a half. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-12, 0.5 * 155.0 * 6.0 * DEAD_S / 0.0116 / 500.0, least_a);
    cfg.supply.commutation_knee_a = 1.01 * least_a;
    start();
    CHECK_REFUSED(supply.commutation_knee_a, 0.99 * least_a);
    CHECK_REFUSED(supply.commutation_knee_a, -1.0);
}
