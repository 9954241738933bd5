/* SPDX-License-Identifier: MIT */
/* The bus with a capacitor: what the bridge takes and gives back, what the rectifier feeds. */
#include "plant_rig.h"

#define CAPACITANCE_F 470.0e-6
#define BRAKING_A (-5.0)
#define BRAKING_PERIODS 300

/*
 * The trapezoidal rule is within 5e-5 of the leg currents (bridge.h), which are up to 1/0.4 of
 * their share in the bus current at the modulation that this speed asks for.
 */
#define CHARGE_ERROR (5.0e-5 / 0.4)

/* Without losses. */
void setUp(void)
{
    bench(ROUND_ROTOR);
    cfg.motor.resistance_ohm = 0.0;
    cfg.motor.viscous_friction_nm_s = 0.0;
    cfg.motor.initial_speed_mech_rad_s = 150.0;
    cfg.supply.capacitance_f = CAPACITANCE_F;
}

static uint32_t compare_of(double phase_v)
{
    return (uint32_t)((0.5 + phase_v / view.bus_v) * COUNTS + 0.5);
}

/* A period: proportional, with the EMF fed forward, for the middle of the next period. */
static void brake_once(void)
{
    const double omega = cfg.motor.pole_pairs * view.omega_mech_rad_s;
    const double inductance_h = cfg.motor.inductance_d_h;
    const double gain = 0.2 * inductance_h / PERIOD_S;
    const double v_d = -gain * view.i_d_a - omega * inductance_h * view.i_q_a;
    const double v_q = gain * (BRAKING_A - view.i_q_a) +
                       omega * (inductance_h * view.i_d_a + cfg.motor.flux_linkage_wb);
    const double angle = view.theta_el_rad + 1.5 * PERIOD_S * omega;
    const plant_vector_t v = {v_d * cos(angle) - v_q * sin(angle),
                              v_d * sin(angle) + v_q * cos(angle)};
    double phase_v[PLANT_LEGS];

    plant_phases(v, phase_v);
    write_compare(compare_of(phase_v[0]), compare_of(phase_v[1]), compare_of(phase_v[2]));
    run(1);
}

static double capacitor_j(void)
{
    return 0.5 * CAPACITANCE_F * view.bus_v * view.bus_v;
}

static double machine_j(void)
{
    const double square_a2 = view.i_d_a * view.i_d_a + view.i_q_a * view.i_q_a;

    return 0.75 * cfg.motor.inductance_d_h * square_a2 +
           0.5 * cfg.motor.inertia_kg_m2 * view.omega_mech_rad_s * view.omega_mech_rad_s;
}

/* What braking does, in J. */
typedef struct {
    double taken;  /* from rotor and coils */
    double stored; /* in the capacitor */
    double heat;   /* in the resistance, from the currents at the ends of the periods */
    double drops;  /* in switches and diodes of 1 V drop, likewise */
} balance_t;

static balance_t brake(void)
{
    balance_t balance = {0.0, 0.0, 0.0, 0.0};

    start();
    balance.taken = machine_j();
    balance.stored = -capacitor_j();
    for (int k = 0; k < BRAKING_PERIODS; k++) {
        const plant_view_t before = view;
        brake_once();
        for (int leg = 0; leg < PLANT_LEGS; leg++) {
            const double a = before.i_abc_a[leg];
            const double b = view.i_abc_a[leg];
            balance.heat += PERIOD_S * cfg.motor.resistance_ohm * (a * a + a * b + b * b) / 3.0;
            balance.drops += PERIOD_S * 0.5 * (fabs(a) + fabs(b));
        }
    }
    balance.taken -= machine_j();
    balance.stored += capacitor_j();
    return balance;
}

TEST(test_braking_without_losses_lifts_the_capacitor_by_all_the_energy)
{
    const balance_t balance = brake();

    TEST_ASSERT_TRUE(balance.taken > 15.0); /* of 34 J */
    TEST_ASSERT_TRUE(view.bus_v > 390.0);
    TEST_ASSERT_DOUBLE_WITHIN(CHARGE_ERROR * balance.taken, balance.taken, balance.stored);
}

/* Ripple of the current within a period, some 0.3 A at 5 A, is not in the heat as added up here. */
TEST(test_what_the_resistance_heats_does_not_come_back)
{
    cfg.motor.resistance_ohm = 2.125;
    const balance_t balance = brake();
    const double ripple = 0.3 * 0.3 / (5.0 * 5.0);
    TEST_ASSERT_TRUE(balance.heat > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(ripple * balance.heat + CHARGE_ERROR * balance.taken,
                              balance.taken - balance.heat, balance.stored);
}

/*
 * Current flows back through the diodes of the dead time too; a leg's current that passes through
 * zero within a period is not in the loss as added up here.
 */
TEST(test_what_switches_and_diodes_drop_does_not_come_back)
{
    cfg.supply.device_drop_v = 1.0;
    cfg.inverter.dead_time_s = 2.0e-6;
    const balance_t balance = brake();
    TEST_ASSERT_TRUE(balance.drops > 0.25);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * balance.drops + CHARGE_ERROR * balance.taken,
                              balance.taken - balance.drops, balance.stored);
}

TEST(test_without_a_capacitor_the_bus_takes_current_back_and_stays)
{
    cfg.supply.capacitance_f = 0.0;
    (void)brake();
    TEST_ASSERT_TRUE(view.bus_v == BUS_V);
}

/* EMF above the bus behind open gates: the diodes rectify into the capacitor. */
TEST(test_an_open_bridge_charges_the_capacitor_until_it_meets_the_emf)
{
    cfg.motor.initial_speed_mech_rad_s = 300.0; /* line to line 402 V peak */
    start();
    plant_set_gates(&plant, false);
    const double before_j = capacitor_j() + machine_j();
    run(2000);
    TEST_ASSERT_TRUE(view.bus_v > 370.0);
    TEST_ASSERT_DOUBLE_WITHIN(CHARGE_ERROR * before_j, before_j, capacitor_j() + machine_j());
}

/* A settled coil: i_a = (2/3) d v / R, the bus gives d i_a, so v = s - R_s (2/3) d^2 v / R. */
TEST(test_the_source_resistance_drops_its_voltage_under_load)
{
    const double ohm = 10.0;
    const double source_ohm = 4.0;
    const double share = 2125.0 / COUNTS;

    cfg.motor = coil(0.1);
    cfg.motor.resistance_ohm = ohm;
    cfg.supply.resistance_ohm = source_ohm;
    start();
    write_compare(3187U, 1062U, 1062U); /* d = 1/2 */
    run(5000);                          /* 50 L/R, 266 R_s C */
    const double expected = BUS_V / (1.0 + source_ohm * 2.0 / 3.0 * share * share / ohm);
    /*
     * Ripple of the coil: T R / L of the current, squared. The energy of a period is given while
     * the bus sags within it, by a charge that is larger by sag / 2 v; the source makes up for it.
     */
    const double ripple = PERIOD_S * ohm / 0.1 * PERIOD_S * ohm / 0.1;
    const double sag_v = PERIOD_S * (BUS_V - expected) / source_ohm / CAPACITANCE_F;
    const double tolerance_v = ripple * BUS_V + 0.5 * sag_v / expected * (BUS_V - expected);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_v, expected, view.bus_v);
}

/* Nothing loads the bus. */
static void start_idle(void)
{
    cfg.motor.initial_speed_mech_rad_s = 0.0;
    start();
    plant_set_gates(&plant, false);
}

/* The capacitor keeps the highest voltage that the supply had at the start of a period. */
TEST(test_the_rectifier_holds_the_peak_of_the_ripple)
{
    const double nearest = 1.0 - cos(PLANT_PI * 300.0 * PERIOD_S);

    cfg.supply.ripple_fraction = 0.05;
    cfg.supply.ripple_hz = 300.0;
    start_idle();
    double last_v = view.bus_v;
    for (int k = 0; k < 100; k++) {
        run(1);
        TEST_ASSERT_TRUE(view.bus_v >= last_v);
        last_v = view.bus_v;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * BUS_V * nearest, 1.05 * BUS_V, view.bus_v);
}

TEST(test_a_supply_that_falls_leaves_the_capacitor_charged_and_one_that_rises_fills_it)
{
    start_idle();
    plant_set_supply(&plant, 200.0);
    run(1);
    TEST_ASSERT_TRUE(view.bus_v == BUS_V);
    plant_set_supply(&plant, 350.0);
    look();
    TEST_ASSERT_TRUE(view.bus_v == 350.0);
    cfg.supply.capacitance_f = 0.0;
    start();
    plant_set_supply(&plant, 200.0);
    look();
    TEST_ASSERT_TRUE(view.bus_v == 200.0);
}

/* A capacitor far too small for a period: its energy is gone, and no more than that. */
TEST(test_a_bus_that_is_drained_stays_at_zero_or_above)
{
    cfg.supply.capacitance_f = 1.0e-9;
    cfg.supply.resistance_ohm = 1000.0;
    cfg.motor.initial_speed_mech_rad_s = 0.0;
    start();
    write_compare(COUNTS, 0U, 0U);
    for (int k = 0; k < 1000; k++) {
        run(1);
        TEST_ASSERT_TRUE(view.bus_v >= 0.0 && view.bus_v < 2.0 * BUS_V);
    }
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    CHECK_REFUSED(supply.capacitance_f, -1.0);
    CHECK_REFUSED(supply.resistance_ohm, HUGE_VAL);
}
