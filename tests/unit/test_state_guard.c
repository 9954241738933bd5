/* SPDX-License-Identifier: MIT */
/*
 * Each bit of drive_t flips by itself, one in a run: at speed under a load, with a weak field, in
 * position control, held at rest, in READY and in FAULT. 100 ms later the drive has found it, or
 * has the speed, the currents and in position control the angle that it has without it, within 10
 * %. 300 ms later likewise. All bits with NF_MANY_RUNS=1, else one of 37. The tick of the flip goes
 * round the slow period.
 *
 * Left out: the pointer to the configuration, which on a PC leads nowhere, and the padding.
 */
#include "driven_motor.h"

#include <stddef.h>
#include <stdio.h>

#define FEW (37U) /* a prime: the bits of all places in a word come along */
#define TICKS_100_MS (1000U)
#define TICKS_300_MS (3000U)
#define MEAN_TICKS (100U)
#define SPREAD (7U) /* of the ticks in which bits flip; 10 are a slow period */
#define SLOW_TICKS (10U)
/* rpm: 10 % of the rated speed, where 10 % of the present one is less */
#define LEAST_SPEED (200.0)
#define CURRENT_SHARE (1.0) /* A: 10 % of the largest current */
#define TURN_SHARE (0.1)    /* of the shaft */
#define PHASE_LIMIT (18.0)  /* A: the fault's */
/*
 * The bus and the EMF at 2400 rpm, 370 V on 11.6 mH, in the period before the sample that shows it:
 * 3.2 A; 1/2 count 0.01 A.
 */
#define BEYOND_A_FAULT (3.4)
#define TRIP (25.0) /* A: of the comparators of the power stage */

typedef struct {
    const char *name;
    uint8_t *at;
    size_t bytes;
} row_t;

static const char *left_out; /* a row that is not flipped */

static const row_t rows[] = {
#define FIELD(path, lowest, highest, quantity) {#path, (uint8_t *)&drive.path, sizeof drive.path},
#define FREE(path, quantity) FIELD(path, 0, 0, quantity)
#include "state.def"
#undef FIELD
#undef FREE
};

static const row_t settings[] = {
#define CFG(path, when, lo, hi, quantity, meaning) {#path, (uint8_t *)&cfg.path, sizeof cfg.path},
#define CFG_STARTUP CFG
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) CFG(path, when, , , , )
#define CFG_VOLTAGE CFG
#include "cfg.def"
};

/* All that changes while it runs. */
typedef struct {
    drive_cfg_t cfg;
    drive_t drive;
    drive_in_t in;
    drive_out_t out;
    example_motor_t motor;
} moment_t;

/* What a run has come to. */
typedef struct {
    double rpm; /* means of 10 ms */
    double d;   /* A */
    double q;
    double turns; /* of the shaft */
} means_t;

typedef struct {
    means_t soon;   /* before 100 ms */
    means_t late;   /* before 300 ms */
    double peak;    /* A, of a phase */
    uint32_t gates; /* ticks with gates on */
    bool failed;
    bool in_time; /* within 100 ms */
} end_t;

static moment_t now_moment(void)
{
    return (moment_t){cfg, drive, in, out, motor};
}

static void go_back_to(const moment_t *moment)
{
    cfg = moment->cfg;
    drive = moment->drive;
    in = moment->in;
    out = moment->out;
    motor = moment->motor;
}

static double rpm_now(void)
{
    return motor.speed * 30.0 / EXAMPLE_PI / POLE_PAIRS;
}

static double largest_phase(void)
{
    double largest = 0.0;

    for (int32_t k = 0; k < 3; k++) {
        const double angle = motor.angle - (k * 2.0 * EXAMPLE_PI / 3.0);

        largest = fmax(largest, fabs((motor.d * cos(angle)) - (motor.q * sin(angle))));
    }
    return largest;
}

/* Of the ticks before `stop`. */
static void add_tick(means_t *means, uint32_t k, uint32_t stop)
{
    const double share = ((k < stop) && (k >= (stop - MEAN_TICKS))) ? (1.0 / MEAN_TICKS) : 0.0;

    means->rpm += share * rpm_now();
    means->d += share * motor.d;
    means->q += share * motor.q;
    means->turns += share * motor.angle / (2.0 * EXAMPLE_PI * POLE_PAIRS);
}

static void watch_tick(end_t *end, uint32_t k)
{
    tick();
    end->peak = fmax(end->peak, largest_phase());
    end->gates += out.gate_enable ? 1U : 0U;
    add_tick(&end->soon, k, TICKS_100_MS);
    add_tick(&end->late, k, TICKS_300_MS);
}

/* Ends with a fault. */
static end_t go_on(void)
{
    const bool had_failed = drive.state == DRIVE_STATE_FAULT;
    end_t end = {0};

    for (uint32_t k = 0U; (k < TICKS_300_MS) && !end.failed; k++) {
        watch_tick(&end, k);
        end.failed = !had_failed && (drive.state == DRIVE_STATE_FAULT);
        end.in_time = end.failed && (k < TICKS_100_MS);
    }
    return end;
}

static bool differs(const means_t *means, const means_t *sound)
{
    const double rpm = fmax(LEAST_SPEED, 0.1 * fabs(sound->rpm));
    const bool elsewhere = (drive.motion.mode == (uint8_t)DRIVE_MODE_POSITION) &&
                           (fabs(means->turns - sound->turns) > TURN_SHARE);

    return elsewhere || (fabs(means->rpm - sound->rpm) > rpm) ||
           (hypot(means->d - sound->d, means->q - sound->q) > CURRENT_SHARE);
}

static bool is_other(const end_t *end, const end_t *sound)
{
    return (!end->in_time && differs(&end->soon, &sound->soon)) ||
           (!end->failed && differs(&end->late, &sound->late));
}

static const char *wrong_with(const end_t *end, const end_t *sound)
{
    const char *wrong = NULL;

    if (end->peak > fmax(sound->peak, PHASE_LIMIT + BEYOND_A_FAULT)) {
        wrong = "passes the limit of the current";
    } else if ((sound->gates == 0U) && (end->gates > 0U)) {
        wrong = "opens a way for current that nobody has asked for";
    } else if (is_other(end, sound)) {
        wrong = "is not found and does something else";
    } else {
        /* as it has to be */
    }
    return wrong;
}

static void flip_bit(const row_t *row, uint32_t bit)
{
    row->at[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
}

static uint32_t flip_of(const moment_t *moment, const row_t *row, uint32_t bit, uint32_t number,
                        const end_t *sound)
{
    char text[160];
    const char *wrong;
    end_t end;

    go_back_to(moment);
    ticks((number * SPREAD) % SLOW_TICKS);
    flip_bit(row, bit);
    end = go_on();
    wrong = wrong_with(&end, sound);
    (void)snprintf(text, sizeof text, "bit %u of %s: %s; %.0f rpm, %.2f A, %.3f turns, peak %.2f A",
                   (unsigned)bit, row->name, (wrong == NULL) ? "" : wrong, end.soon.rpm,
                   hypot(end.soon.d, end.soon.q), end.soon.turns, end.peak);
    TEST_ASSERT_NULL_MESSAGE(wrong, text);
    return end.failed ? 1U : 0U;
}

/* Returns how many flips were found. */
static uint32_t flip_each(const row_t *table, size_t count)
{
    const uint32_t every = testing_runs(FEW, 1U);
    const moment_t moment = now_moment();
    const end_t sound = go_on();
    uint32_t number = 0U;
    uint32_t found = 0U;

    for (size_t k = 0U; k < count; k++) {
        for (uint32_t bit = 0U; bit < (8U * table[k].bytes); bit++) {
            if (((number % every) == 0U) && (strcmp(table[k].name, left_out) != 0)) {
                found += flip_of(&moment, &table[k], bit, number, &sound);
            }
            number++;
        }
    }
    return found;
}

static uint32_t flip_all(void)
{
    return flip_each(rows, COUNT(rows));
}

static void run_at_with(double rpm, double load, uint32_t count)
{
    in.command = (drive_command_t){.target = (int32_t)lround(rpm * STEPS_PER_RPM),
                                   .mode = (uint8_t)DRIVE_MODE_SPEED,
                                   .request = DRIVE_REQUEST_RUN};
    ticks(count);
    load_nm = load;
    ticks(6000U);
}

/*
 * The gains that this motor gets by rule. Those of the example are the published ones: a speed loop
 * of 20 Hz on a slower estimate, which swings for 55 ms after any kick.
 */
static void set_gains_by_rule(void)
{
    cfg.speed_loop.pi = (pi_cfg_t){.kp = 22933, .ki = 32394, .kp_shift = 11U, .ki_shift = 5U};
    cfg.speed_loop.soft = cfg.speed_loop.pi; /* 14 Hz */
    cfg.observer.eta = 11126;                /* κ = 0.0231886 */
    cfg.observer.eta_shift = 5U;
    cfg.observer.kappa_p = 12996; /* 0.43339 */
    cfg.observer.kappa_p_shift = 1U;
    cfg.observer.frame_share_q13 = 8192;
    cfg.observer.rho_max_q13 = 9418;
}

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter is ideal */
    set_gains_by_rule();
    left_out = "";
}

void tearDown(void)
{
}

TEST(test_at_speed_under_load_no_flip_is_left_to_act)
{
    power_on_at(0.3, 0.0);
    run_at_with(1500.0, 3.0, 25000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(5.0, 1500.0, rpm_now());
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

/*
 * A flip of timer_counts is not judged here: the compare values of the very next tick follow from
 * it.
 */
TEST(test_no_flip_of_a_setting_is_left_to_act)
{
    power_on_at(0.3, 0.0);
    run_at_with(1500.0, 3.0, 25000U);
    left_out = "modulator.timer_counts";
    TEST_ASSERT_TRUE(flip_each(settings, COUNT(settings)) > testing_runs(20U, 500U));
}

TEST(test_each_flip_of_the_timers_counts_is_found_before_the_hardwares_limit_of_the_current)
{
    moment_t moment;

    power_on_at(0.3, 0.0);
    run_at_with(1500.0, 3.0, 25000U);
    moment = now_moment();
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        end_t end;

        go_back_to(&moment);
        cfg.modulator.timer_counts ^= (int32_t)(1U << bit);
        end = go_on();
        TEST_ASSERT_TRUE(end.in_time);
        TEST_ASSERT_TRUE(end.peak < TRIP);
    }
}

TEST(test_with_a_weakened_field_no_flip_is_left_to_act)
{
    cfg.speed_loop.speed_max = 51539607; /* 3600 rpm */
    cfg.observer.speed_limit = 62992853;
    cfg.supervision.overspeed = 60129541;
    cfg.torque_loop.speed_forward = cfg.speed_loop.speed_max;
    cfg.torque_loop.speed_backward = cfg.speed_loop.speed_max;
    power_on_at(0.3, 0.0);
    run_at_with(1500.0, 1.0, 25000U);
    run_at_with(2400.0, 1.0, 9000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_TRUE(motor.d < -4.0);
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

/* The angle is that of a sensor. */
static void hold_position_against(double load)
{
    cfg = example_drive_cfg();
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.observer.eta = 0;
    cfg.observer.kappa_p = 0;
    power_on_at(0.3, 0.0);
    in.command = (drive_command_t){
        .target = 0, .mode = (uint8_t)DRIVE_MODE_POSITION, .request = DRIVE_REQUEST_RUN};
    ticks(25000U);
    load_nm = load;
    ticks(6000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
}

TEST(test_at_a_position_under_load_no_flip_is_left_to_act)
{
    hold_position_against(1.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, motor.angle / (2.0 * EXAMPLE_PI));
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

/*
 * A flip of slow_count is not judged: a long period makes the motion late by 25 ms at most, and it
 * ends where it has to.
 */
TEST(test_on_the_way_to_a_position_no_flip_is_left_to_act)
{
    hold_position_against(1.0);
    in.command.target = 200 * 65536;
    ticks(6000U);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 900.0, rpm_now());
    left_out = "slow_count";
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

TEST(test_held_at_rest_no_flip_is_left_to_act)
{
    power_on_at(0.3, 0.0);
    run_at_with(0.0, 0.0, 9000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

TEST(test_in_ready_no_flip_lets_a_current_flow)
{
    power_on();
    TEST_ASSERT_TRUE(flip_all() > testing_runs(20U, 1000U));
}

TEST(test_in_fault_no_flip_lets_a_current_flow)
{
    power_on();
    in.flags = DRIVE_FLAG_BREAK;
    tick();
    in.flags = 0U;
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    (void)flip_all();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    assert_gates_open();
}
