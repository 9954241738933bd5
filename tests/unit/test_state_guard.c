/* SPDX-License-Identifier: MIT */
/*
 * Each bit of drive_t flips by itself, one in a run: at speed under a load, with a weak field, held at rest, in READY and in
 * FAULT. Within 100 ms the drive has found it, or turns as fast as it did without it, and 200 ms later it has the same
 * current. With a weak field a kick that has cost i_d comes back in 200 ms. All bits with NF_MANY_RUNS=1, else one of 37. The tick of the
 * flip goes round the slow period.
 *
 * Left out: the pointer to the configuration, which on a PC leads nowhere, and the padding.
 */
#include "driven_motor.h"
#include "state_guard.h"
#include "transitions.h"

#include <stddef.h>
#include <stdio.h>

#define FEW (37U) /* a prime: the bits of all places in a word come along */
#define TICKS_100_MS (1000U)
#define TICKS_200_MS (2000U)
#define TICKS_300_MS (3000U)
#define MEAN_TICKS (100U)
#define SPREAD (7U) /* of the ticks in which bits flip; 10 are a slow period */
#define SLOW_TICKS (10U)
#define LEAST_SPEED \
    (200.0) /* rpm: 10 % of the rated speed, where 10 % of the present one is less */
#define CURRENT_SHARE (1.0) /* A: 10 % of the largest current */
#define PHASE_LIMIT (18.0)  /* A: the fault's */
/* The bus and the EMF at 2400 rpm, 370 V on 11.6 mH, in the period before the sample that shows it: 3.2 A; 1/2 count 0.01 A. */
#define BEYOND_A_FAULT (3.4)

typedef struct {
    const char *name;
    size_t at;
    size_t bytes;
} row_t;

static uint32_t soon; /* ticks after which a flip is found, or the speed is that without it */

static const row_t rows[] = {
#define FIELD(path, lowest, highest, quantity) \
    {#path, offsetof(drive_t, path), sizeof(((drive_t *)0)->path)},
#define FREE(path, quantity) FIELD(path, 0, 0, quantity)
#include "state.def"
#undef FIELD
#undef FREE
};

/* All that changes while it runs. */
typedef struct {
    drive_t drive;
    drive_in_t in;
    drive_out_t out;
    example_motor_t motor;
} moment_t;

/* What a run has come to. */
typedef struct {
    double speed_soon; /* rpm, mean of the last 10 ms of `soon`, … */
    double speed_300;  /* … of 300 ms */
    double d;          /* A, likewise at 300 ms */
    double q;
    double peak;    /* A, of a phase */
    uint32_t gates; /* ticks with gates on */
    bool failed;
    bool in_time; /* within `soon` */
} end_t;

static moment_t now_moment(void)
{
    return (moment_t){drive, in, out, motor};
}

static void go_back_to(const moment_t *moment)
{
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

static void watch_tick(end_t *end, uint32_t k)
{
    const double share = 1.0 / MEAN_TICKS;

    tick();
    end->peak = fmax(end->peak, largest_phase());
    end->gates += out.gate_enable ? 1U : 0U;
    if ((k < soon) && (k >= (soon - MEAN_TICKS))) {
        end->speed_soon += share * rpm_now();
    } else if (k >= (TICKS_300_MS - MEAN_TICKS)) {
        end->speed_300 += share * rpm_now();
        end->d += share * motor.d;
        end->q += share * motor.q;
    } else {
        /* in between */
    }
}

/* Ends with a fault. */
static end_t go_on(void)
{
    const bool had_failed = drive.state == DRIVE_STATE_FAULT;
    end_t end = {0};

    for (uint32_t k = 0U; (k < TICKS_300_MS) && !end.failed; k++) {
        watch_tick(&end, k);
        end.failed = !had_failed && (drive.state == DRIVE_STATE_FAULT);
        end.in_time = end.failed && (k < soon);
    }
    return end;
}

/* Soon the speed, later what lasts. */
static bool is_other(const end_t *end, const end_t *sound)
{
    const double speed = fmax(LEAST_SPEED, 0.1 * fabs(sound->speed_300));
    const bool early = fabs(end->speed_soon - sound->speed_soon) > speed;
    const bool late = (fabs(end->speed_300 - sound->speed_300) > speed) ||
                      (hypot(end->d - sound->d, end->q - sound->q) > CURRENT_SHARE);

    return (early && !end->in_time) || (late && !end->failed);
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
    uint8_t *const bytes = (uint8_t *)&drive;

    bytes[row->at + (bit / 8U)] ^= (uint8_t)(1U << (bit % 8U));
}

static uint32_t flip_of(const moment_t *moment, const row_t *row, uint32_t bit, const end_t *sound)
{
    const uint32_t number = (uint32_t)(8U * row->at) + bit;
    char text[160];
    const char *wrong;
    end_t end;

    go_back_to(moment);
    ticks((number * SPREAD) % SLOW_TICKS);
    flip_bit(row, bit);
    end = go_on();
    wrong = wrong_with(&end, sound);
    (void)snprintf(text, sizeof text, "bit %u of %s: %s; %.0f rpm, %.2f A, peak %.2f A",
                   (unsigned)bit, row->name, (wrong == NULL) ? "" : wrong, end.speed_soon,
                   hypot(end.d, end.q), end.peak);
    TEST_ASSERT_NULL_MESSAGE(wrong, text);
    return end.failed ? 1U : 0U;
}

/* Returns how many flips were found. */
static uint32_t flip_all(void)
{
    const uint32_t every = testing_runs(FEW, 1U);
    const moment_t moment = now_moment();
    const end_t sound = go_on();
    uint32_t number = 0U;
    uint32_t found = 0U;

    for (size_t k = 0U; k < COUNT(rows); k++) {
        for (uint32_t bit = 0U; bit < (8U * rows[k].bytes); bit++) {
            if ((number % every) == 0U) {
                found += flip_of(&moment, &rows[k], bit, &sound);
            }
            number++;
        }
    }
    return found;
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

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter is ideal */
    soon = TICKS_100_MS;
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
    soon = TICKS_200_MS;
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

/* The schedule goes on by itself after a count that is too long: a byte of ticks, and no more. */
TEST(test_no_flip_of_its_count_stops_the_slow_schedule)
{
    moment_t moment;

    power_on();
    moment = now_moment();
    for (uint32_t bit = 0U; bit < 8U; bit++) {
        uint32_t waited = 0U;

        go_back_to(&moment);
        drive.slow_count = (uint8_t)(drive.slow_count ^ (1U << bit));
        do {
            tick();
            waited++;
        } while ((drive.slow_count != cfg.slow_ticks) && (waited < TICKS_100_MS));
        TEST_ASSERT_TRUE(waited <= 256U);
        ticks(1U);
        TEST_ASSERT_EQUAL_UINT8(cfg.slow_ticks - 1U, drive.slow_count);
    }
}

TEST(test_a_code_that_is_no_state_is_a_fault_in_its_tick_whatever_is_asked_for)
{
    for (uint32_t number = 0U; number < DRIVE_STATES; number++) {
        for (uint32_t bit = 0U; bit < 32U; bit++) {
            power_on();
            drive.state = (drive_state_t)((uint32_t)transitions_state(number) ^ (1UL << bit));
            in.command.request = DRIVE_REQUEST_RUN;
            tick();
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, drive.fault.id);
            assert_gates_open();
        }
    }
}

/* Also one that leaves no room for the slot that looks at it. */
TEST(test_each_flip_of_the_slow_period_itself_is_found)
{
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        cfg = example_drive_cfg_with_startup();
        power_on();
        cfg.slow_ticks ^= 1UL << bit;
        ticks(TICKS_300_MS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, drive.fault.id);
    }
}
