/* SPDX-License-Identifier: MIT */
/* A load behind an elastic shaft: how the two masses swing and answer, momentum, friction. */
#include "plant_motor_rig.h"

#include <complex.h>

/* Of a frequency: the midpoint method, in steps below 0.0078, is off by x^2/6 = 1e-5. */
#define FREQUENCY 2.0e-5

#define MOTOR_KG_M2 0.002
#define LOAD_KG_M2 0.006
#define STIFFNESS_NM 400.0
#define DAMPING_NM_S 0.2

#define STEP_S 1.0e-5

/* Four times as long as the slowest swings of a test. */
#define STEPS_MAX 1000000L

/* Of a torque that is a sine, in a period. */
#define STAIRS 200

/* Two masses without friction. */
void setUp(void)
{
    cfg = ROUND_ROTOR;
    cfg.viscous_friction_nm_s = 0.0;
    cfg.inertia_kg_m2 = MOTOR_KG_M2;
    cfg.load_inertia_kg_m2 = LOAD_KG_M2;
    cfg.shaft_stiffness_nm = STIFFNESS_NM;
}

/* At different speeds, rad/s. */
static void start_apart(double motor_rad_s, double load_rad_s)
{
    cfg.initial_speed_mech_rad_s = motor_rad_s;
    start();
    motor.now.load_speed_rad_s = load_rad_s;
}

/* rad/s, of free swings, and of those of the load while the motor is held. */
static double resonance(void)
{
    return sqrt(STIFFNESS_NM * (1.0 / MOTOR_KG_M2 + 1.0 / LOAD_KG_M2));
}

static double antiresonance(void)
{
    return sqrt(STIFFNESS_NM / LOAD_KG_M2);
}

/*
 * The shaft swings so: from the first to the last of 101 passes of the twist through zero upwards,
 * each between two steps along a line.
 */
static void check_swings(double wanted_rad_s)
{
    const int passes = 100;
    double first_s = 0.0;
    double last_s = 0.0;
    int seen = 0;
    double before = motor.now.twist_rad;

    for (long k = 1; seen <= passes; k++) {
        TEST_ASSERT_TRUE_MESSAGE(k <= STEPS_MAX, "the shaft does not swing");
        coast(1, STEP_S);
        const double now = motor.now.twist_rad;
        if (before < 0.0 && now >= 0.0) {
            last_s = STEP_S * ((double)k - now / (now - before));
            first_s = (seen == 0) ? last_s : first_s;
            seen++;
        }
        before = now;
    }
    TEST_ASSERT_DOUBLE_WITHIN(FREQUENCY * wanted_rad_s, wanted_rad_s,
                              PLANT_TWO_PI * passes / (last_s - first_s));
}

TEST(test_free_shaft_swings_at_the_resonance)
{
    start_apart(10.0, 0.0);
    check_swings(resonance());
}

TEST(test_blocked_rotor_leaves_the_antiresonance)
{
    start_apart(0.0, 5.0);
    plant_motor_block(&motor, true);
    check_swings(antiresonance());
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(motor.now.theta_el_rad == 0.0);
}

/* A peak follows one of the other sign: e^(-pi D / sqrt(1 - D^2)) of it, D = d/2 w/k. */
TEST(test_swings_fade_by_the_damping)
{
    const double ratio = 0.5 * DAMPING_NM_S * resonance() / STIFFNESS_NM;
    double peak[3] = {0.0, 0.0, 0.0};
    double before = 0.0;

    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    start_apart(10.0, 0.0);
    int count = 0;
    for (long k = 0; count < 3; k++) {
        TEST_ASSERT_TRUE_MESSAGE(k <= STEPS_MAX, "the shaft does not swing");
        peak[count] = fmax(peak[count], fabs(motor.now.twist_rad));
        coast(1, STEP_S);
        count += (before * motor.now.twist_rad < 0.0) ? 1 : 0;
        before = motor.now.twist_rad;
    }
    const double fade = exp(-PLANT_PI * ratio / sqrt(1.0 - ratio * ratio));
    /* A peak lies between two steps: (w h)^2 / 8 below it. */
    const double tolerance = pow(resonance() * STEP_S, 2.0) / 8.0;
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, fade, peak[1] / peak[0]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, fade, peak[2] / peak[1]);
}

static double momentum(void)
{
    return MOTOR_KG_M2 * omega_mech() + LOAD_KG_M2 * motor.now.load_speed_rad_s;
}

TEST(test_momentum_of_both_masses_is_kept_and_their_load_brakes_them)
{
    const double load_nm = 0.5;
    const double first = MOTOR_KG_M2 * 10.0 - LOAD_KG_M2 * 20.0;

    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    start_apart(10.0, -20.0);
    coast(10000, STEP_S);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, first, momentum());
    motor.load_torque_nm = load_nm;
    coast(10000, STEP_S);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, first - load_nm * 10000 * STEP_S, momentum());
    /* The shaft brakes the motor's share of the inertia. */
    const double shaft_nm = STIFFNESS_NM * motor.now.twist_rad +
                            DAMPING_NM_S * (omega_mech() - motor.now.load_speed_rad_s);
    const double share = MOTOR_KG_M2 / (MOTOR_KG_M2 + LOAD_KG_M2);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-3 * load_nm, share * load_nm, shaft_nm);
}

/* Motor speed for a torque of the motor at s = j w. */
static double complex wanted_response(double w)
{
    const double complex s = (double complex)I * w;
    const double complex shaft = DAMPING_NM_S * s + STIFFNESS_NM;

    return (LOAD_KG_M2 * s * s + shaft) /
           (s * (MOTOR_KG_M2 * LOAD_KG_M2 * s * s + (MOTOR_KG_M2 + LOAD_KG_M2) * shaft));
}

/*
 * A torque amplitude * sin(w t) of the q current, which is set before each step; Fourier's integral
 * over the last quarter of whole periods.
 */
static double complex measured_response(double w, double amplitude_nm)
{
    const double h = 2.0 * PLANT_PI / w / STAIRS;
    const int periods = 400;
    double complex sum = 0.0;

    cfg.resistance_ohm = 0.0;
    cfg.inductance_d_h = 100.0; /* no voltage here changes the current of a step */
    cfg.inductance_q_h = 100.0;
    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    start();
    for (int k = 0; k < periods * STAIRS; k++) {
        const double here = 2.0 * PLANT_PI * k / STAIRS;
        const double middle = here + PLANT_PI / STAIRS;
        const double i_q = amplitude_nm * sin(middle) / (1.5 * 2.0 * cfg.flux_linkage_wb);
        if (4 * k >= 3 * periods * STAIRS) {
            sum += omega_mech() * (sin(here) + (double complex)I * cos(here));
        }
        motor.now.flux_d_wb = cfg.flux_linkage_wb;
        motor.now.flux_q_wb = cfg.inductance_q_h * i_q;
        plant_motor_step_driven(&motor, h, plant_motor_emf(&motor));
        plant_motor_wrap(&motor);
    }
    return 2.0 / (0.25 * periods * STAIRS) / amplitude_nm * sum;
}

TEST(test_motor_answers_torque_as_two_masses_do)
{
    const double middle = 0.5 * (antiresonance() + resonance());
    const double frequencies[] = {0.3 * antiresonance(), antiresonance(), middle, resonance(),
                                  3.0 * resonance()};
    const double x = PLANT_TWO_PI / STAIRS;

    for (size_t k = 0; k < sizeof frequencies / sizeof frequencies[0]; k++) {
        const double w = frequencies[k];
        const double complex wanted = wanted_response(w);
        const double complex measured = measured_response(w, 0.1);
        /*
         * Stairs of x are smaller than their sine by x^2/24. Those of their harmonics that speed
         * samples at the stairs cannot tell from it add x^2/12 of what the motor's own mass does.
         */
        const double tolerance =
            1.1 * x * x * (1.0 / (12.0 * MOTOR_KG_M2 * w) + cabs(wanted) / 24.0);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, creal(wanted), creal(measured));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, cimag(wanted), cimag(measured));
    }
    /* At the antiresonance the load holds the motor: little is left of what it does far below. */
    TEST_ASSERT_TRUE(cabs(measured_response(antiresonance(), 0.1)) <
                     0.2 / ((MOTOR_KG_M2 + LOAD_KG_M2) * antiresonance()));
}

TEST(test_stiction_of_the_motor_holds_what_the_shaft_brings)
{
    cfg.coulomb_friction_nm = 0.5;
    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    start();
    /* At once, the load swings to twice the twist of its torque. */
    motor.load_torque_nm = 0.24;
    coast(20000, STEP_S);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0 && motor.now.theta_el_rad == 0.0);
    motor.load_torque_nm = 0.0;
    coast(40000, STEP_S);
    motor.load_torque_nm = 0.6;
    coast(20000, STEP_S);
    TEST_ASSERT_TRUE(omega_mech() < 0.0);
}

/* What counts is the twist, which is not yet there or still is. */
TEST(test_a_shaft_sticks_by_its_twist_and_not_by_the_load)
{
    cfg.coulomb_friction_nm = 0.5;
    start();
    motor.load_torque_nm = 5.0;
    coast(1, STEP_S);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s == 0.0);
    TEST_ASSERT_TRUE(motor.now.load_speed_rad_s < 0.0);
    start();
    motor.now.twist_rad = 0.51 / STIFFNESS_NM;
    coast(1, STEP_S);
    TEST_ASSERT_TRUE(motor.now.omega_el_rad_s < 0.0);
}

static double stored_j(void)
{
    const double own = omega_mech();
    const double load = motor.now.load_speed_rad_s;
    const double twist = motor.now.twist_rad;

    return 0.5 *
           (MOTOR_KG_M2 * own * own + LOAD_KG_M2 * load * load + STIFFNESS_NM * twist * twist);
}

/* Swings with dry friction on one side lose what the friction takes of the motor's way. */
TEST(test_energy_goes_into_friction_and_damping)
{
    double lost_j = 0.0;
    double before_w = 0.0;

    cfg.coulomb_friction_nm = 0.05;
    cfg.viscous_friction_nm_s = 0.002;
    cfg.shaft_damping_nm_s = DAMPING_NM_S;
    start_apart(30.0, 10.0);
    motor.load_torque_nm = 0.2;
    const double first_j = stored_j();
    for (int k = 0; k < 20000; k++) {
        coast(1, STEP_S);
        const double own = omega_mech();
        const double load = motor.now.load_speed_rad_s;
        const double w = own * (0.002 * own + copysign(0.05, own)) +
                         DAMPING_NM_S * (own - load) * (own - load) + 0.2 * load;
        lost_j += 0.5 * STEP_S * (w + ((k > 0) ? before_w : w));
        before_w = w;
    }
    TEST_ASSERT_TRUE(lost_j > 0.1);
    /* Trapezoidal rule: (w h)^2 / 12 = 2e-6 of a swing, and the first step. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-4 * lost_j, first_j, stored_j() + lost_j);
}

/* The swing that friction starts at first has faded to e^-33. */
TEST(test_a_stiff_shaft_is_a_rigid_one)
{
    cfg.shaft_stiffness_nm = STIFFNESS_NM * 1.0e4;
    cfg.shaft_damping_nm_s = 50.0;
    cfg.viscous_friction_nm_s = 0.01;
    cfg.initial_speed_mech_rad_s = 100.0;
    start();
    coast(2000, 1.0e-6);
    const double elastic_rad_s = omega_mech();
    cfg.inertia_kg_m2 = MOTOR_KG_M2 + LOAD_KG_M2;
    cfg.load_inertia_kg_m2 = 0.0;
    start();
    TEST_ASSERT_FALSE(motor.is_real);
    coast(200, STEP_S);
    /* What braking twists the shaft by, 2e-7 rad, came as speed at first. */
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6, omega_mech(), elastic_rad_s);
}

/* 5 ms of swings after a blow, in intervals of 100 us of so many parts, without magnet. */
static plant_motor_state_t struck(double stiffness_nm, double damping_nm_s, int parts)
{
    const plant_interval_t interval = {1.0e-4 / parts, {0.0, 0.0}};

    cfg.flux_linkage_wb = 0.0;
    cfg.shaft_stiffness_nm = stiffness_nm;
    cfg.shaft_damping_nm_s = damping_nm_s;
    start_apart(10.0, 0.0);
    for (int k = 0; k < 50 * parts; k++) {
        plant_motor_run_driven(&motor, 1, &interval);
    }
    return motor.now;
}

static void check_steps(double stiffness_nm, double damping_nm_s)
{
    const plant_motor_state_t coarse = struck(stiffness_nm, damping_nm_s, 1);
    const plant_motor_state_t fine = struck(stiffness_nm, damping_nm_s, 500);
    /* A step of x <= 0.1 is off by x^5/120, a radian by x^4/120; there are 258 at most. */
    const double tolerance = 258.0 * 1.0e-4 / 120.0 * 10.0;

    TEST_ASSERT_DOUBLE_WITHIN(tolerance, fine.load_speed_rad_s, coarse.load_speed_rad_s);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, fine.omega_el_rad_s / 2.0, coarse.omega_el_rad_s / 2.0);
}

TEST(test_steps_are_as_short_as_the_shaft_is_stiff_or_damped)
{
    check_steps(1.0e4 * STIFFNESS_NM, 0.1);
    check_steps(STIFFNESS_NM, 200.0);
}

TEST(test_init_names_the_field_that_is_out_of_range)
{
    CHECK_REFUSED(load_inertia_kg_m2, -1.0);
    CHECK_REFUSED(shaft_stiffness_nm, 0.0);
    CHECK_REFUSED(shaft_damping_nm_s, -0.1);
}
