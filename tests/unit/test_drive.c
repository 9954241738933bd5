/* SPDX-License-Identifier: MIT */
/* Drive: states and faults, calibration, purity, ranges for any frame, and a closed loop. */
#include "drive.h"
#include "estimate.h"
#include "example_cfg.h"
#include "example_motor.h"
#include "fault_frames.h"
#include "instant.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"
#include "trig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MID_COUNTS (2048U) /* zero current */
#define BUS_COUNTS (2822U) /* 310 V */
#define CALIBRATION_TICKS (256U)
#define STEPS_PER_RPM (14316.56) /* 2 pole pairs, 10 kHz */

#define TURN_Q32 ((int64_t)1 << 32)

static drive_cfg_t cfg;
static drive_t drive;
static drive_in_t in;
static drive_out_t out;
static example_motor_t motor;

/* The configuration was changed on purpose. */
static void seal(void)
{
    cfg.crc = config_guard_crc(&cfg);
    state_guard_keep_config(&drive.state_guard, drive.cfg);
}

static void supervise_nothing(void)
{
    example_supervise_nothing(&cfg);
    state_guard_keep_config(&drive.state_guard, drive.cfg);
}

static void quiet_frame(void)
{
    in = (drive_in_t){.adc_ia = MID_COUNTS, .adc_ib = MID_COUNTS, .adc_bus = BUS_COUNTS};
}

void setUp(void)
{
    cfg = example_drive_cfg();
    memset(&drive, 0, sizeof drive);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    quiet_frame();
    memset(&out, 0xA5, sizeof out);
    motor = example_motor_at(0.0, 0.0);
}

static drive_t was; /* the drive before the tick */

static void tick(void)
{
    was = drive;
    drive_step(&drive, &in, &out);
}

/* What the observer was given in this tick. */
static ab_t applied_voltage(void)
{
    return estimate_applied_voltage(was.control.ratio_acting, was.bus, drive.bus);
}

static void ticks(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick();
    }
}

/* From INIT, with the sensors as they are in the frame. */
static void go_to(drive_state_t state)
{
    if (state != DRIVE_STATE_INIT) {
        tick();
    }
    if ((state == DRIVE_STATE_READY) || (state == DRIVE_STATE_RUN)) {
        ticks(CALIBRATION_TICKS);
    }
    if (state == DRIVE_STATE_RUN) {
        in.command.request = DRIVE_REQUEST_RUN;
        ticks(25U);
    }
    TEST_ASSERT_EQUAL_INT(state, drive.state);
}

/* The slow periods go on in every state: what counts ticks of a run begins with one. */
static void await_slow_period(void)
{
    while (drive.slow_count != cfg.slow_ticks) {
        tick();
    }
}

static void ask_to_run(int32_t target)
{
    go_to(DRIVE_STATE_READY);
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.target = target;
}

static void assert_phases(uint16_t counts)
{
    for (int32_t p = 0; p < 3; p++) {
        TEST_ASSERT_EQUAL_UINT16(counts, out.compare.phase[p]);
    }
}

static void assert_gates_open(void)
{
    TEST_ASSERT_FALSE(out.gate_enable);
    assert_phases(4250U); /* half of 8500 */
}

static void assert_ab(ab_t expected, ab_t value)
{
    TEST_ASSERT_EQUAL_INT32(expected.alpha, value.alpha);
    TEST_ASSERT_EQUAL_INT32(expected.beta, value.beta);
}

/* ---- configuration and states ---- */

TEST(test_init_starts_in_init_whatever_was_there_before)
{
    fault_t fault;

    memset(&drive, 0x77, sizeof drive);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_INIT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, drive.fault.id);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.tick);
    TEST_ASSERT_EQUAL_INT32(4096, drive.modulator.inverse_bus_q12);
    TEST_ASSERT_EQUAL_INT32(131072, drive.motion.speed_loop.inertia_q17); /* that of the file */
    TEST_ASSERT_EQUAL_INT32(cfg.derating.current_max, drive.derating.motoring);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, state_guard_check_vector(&drive, &fault));
}

TEST(test_init_names_a_refused_field)
{
    cfg.position_loop.gain ^= 1; /* not what was built */
    TEST_ASSERT_EQUAL_STRING("crc", drive_init(&drive, &cfg));
    cfg.observer.eta = -1;
    TEST_ASSERT_EQUAL_STRING("observer.eta", drive_init(&drive, &cfg));
}

TEST(test_calibration_takes_exactly_its_samples_and_keeps_the_gates_open)
{
    for (uint32_t k = 1U; k <= CALIBRATION_TICKS; k++) {
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
        TEST_ASSERT_EQUAL_UINT32(k, drive.tick);
        assert_gates_open();
        in.command.request = DRIVE_REQUEST_RUN;
    }
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    assert_gates_open();
}

TEST(test_ready_waits_for_the_command_with_open_gates)
{
    go_to(DRIVE_STATE_READY);
    for (uint32_t k = 0U; k < 100U; k++) {
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
        assert_gates_open();
    }
}

TEST(test_run_command_enables_the_gates_in_the_next_tick_and_stop_opens_them_in_its_own)
{
    go_to(DRIVE_STATE_READY);
    in.command.request = DRIVE_REQUEST_RUN;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    assert_gates_open();
    tick();
    TEST_ASSERT_TRUE(out.gate_enable);
    assert_phases(4250U); /* the null vector */
    in.command.request = 0U;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    assert_gates_open();
}

TEST(test_a_fault_told_that_is_none_ends_a_run_as_a_stop_does)
{
    static const uint8_t none[] = {DRIVE_MODE_FAULT + FAULT_NONE, DRIVE_MODE_FAULT + FAULT_COUNT,
                                   FAULT_CURRENT_SUM, 0xFFU};

    for (uint32_t k = 0U; k < (sizeof none / sizeof none[0]); k++) {
        setUp();
        go_to(DRIVE_STATE_RUN);
        in.command = (drive_command_t){.mode = none[k], .request = DRIVE_REQUEST_FAIL};
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
        assert_gates_open();
    }
}

/* ---- calibration ---- */

TEST(test_offset_is_the_mean_of_the_samples_and_is_removed)
{
    tick();
    for (uint32_t k = 0U; k < CALIBRATION_TICKS; k++) {
        in.adc_ia = (uint16_t)(2050U + (k % 2U)); /* mean 2050.5 */
        in.adc_ib = 2040U;
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    TEST_ASSERT_EQUAL_INT32(16404, drive.sensors.offset_a); /* 2050.5·8 */
    TEST_ASSERT_EQUAL_INT32(16320, drive.sensors.offset_b);
    in.adc_ia = 2151U;
    tick();
    TEST_ASSERT_EQUAL_INT32((2151 * 8) - 16404, instant_sample(&drive, &in).phase_a);
    TEST_ASSERT_EQUAL_INT32(0, instant_sample(&drive, &in).phase_b);
}

TEST(test_offset_of_one_sample_or_of_4096_at_full_scale_is_their_mean)
{
    for (uint32_t log2 = 0U; log2 <= 12U; log2 += 12U) {
        setUp();
        cfg.sampling.offset_log2 = log2;
        cfg.protection.offset_max = 32767;
        seal();
        in.adc_ia = 4095U;
        in.adc_ib = 0U;
        ticks(1U + (1U << log2));
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
        TEST_ASSERT_EQUAL_INT32(4095 * 8, drive.sensors.offset_a);
        TEST_ASSERT_EQUAL_INT32(0, drive.sensors.offset_b);
    }
}

TEST(test_offset_beyond_its_limit_is_a_fault_with_open_gates)
{
    /* 819 of Q15 are 102.4 counts. */
    static const uint16_t bad[] = {MID_COUNTS + 103U, MID_COUNTS - 103U};

    for (uint32_t i = 0U; i < 4U; i++) {
        setUp();
        in.adc_ia = ((i % 2U) == 0U) ? bad[i / 2U] : MID_COUNTS;
        in.adc_ib = ((i % 2U) == 0U) ? MID_COUNTS : bad[i / 2U];
        in.command.request = DRIVE_REQUEST_RUN;
        ticks(1U + CALIBRATION_TICKS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(824, drive.fault.value);
        TEST_ASSERT_EQUAL_INT32(819, drive.fault.limit);
        assert_gates_open();
    }
}

TEST(test_offset_at_its_limit_is_accepted)
{
    in.adc_ia = MID_COUNTS + 102U;
    in.adc_ib = MID_COUNTS - 102U;
    go_to(DRIVE_STATE_READY);
}

/* ---- faults ---- */

/* The states of a drive without start-up; test_low_speed.c has the others. */
static const drive_state_t STATES[] = {DRIVE_STATE_INIT, DRIVE_STATE_OFFSET_CAL, DRIVE_STATE_READY,
                                       DRIVE_STATE_RUN};

TEST(test_a_sample_at_an_end_of_the_converter_is_named_so)
{
    static const uint16_t ends[] = {0U, 4095U, 4096U, 65535U};

    for (uint32_t k = 0U; k < 8U; k++) {
        setUp();
        go_to(DRIVE_STATE_RUN);
        in.adc_ia = ((k % 2U) == 0U) ? ends[k / 2U] : MID_COUNTS;
        in.adc_ib = ((k % 2U) == 0U) ? MID_COUNTS : ends[k / 2U];
        tick();
        assert_gates_open();
        TEST_ASSERT_EQUAL_INT(FAULT_ADC_SATURATED, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(14746, drive.fault.limit);
        TEST_ASSERT_EQUAL_UINT32(drive.tick - 1U, drive.fault.tick);
    }
}

/* Ticks in RUN until the drive opens the gates by a fault, which has to be in its tick. */
static uint32_t run_to_fault(fault_id_t id, uint32_t most)
{
    uint32_t k = 0U;

    while ((drive.state == DRIVE_STATE_RUN) && (k < most)) {
        TEST_ASSERT_TRUE(out.gate_enable);
        tick();
        k++;
    }
    assert_gates_open();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(id, drive.fault.id);
    TEST_ASSERT_EQUAL_UINT32(drive.tick - 1U, drive.fault.tick);
    return k;
}

#define SUPERVISION_TICKS (40U) /* of 10 */

TEST(test_one_late_tick_more_than_allowed_is_a_fault_in_its_tick)
{
    go_to(DRIVE_STATE_RUN);
    in.flags = DRIVE_FLAG_LATE;
    TEST_ASSERT_EQUAL_UINT32(cfg.supervision.late_max + 1U, run_to_fault(FAULT_LATE, 1000U));
}

/* It is what they have led to. */
TEST(test_an_overcurrent_in_the_last_late_tick_is_called_late)
{
    go_to(DRIVE_STATE_RUN);
    in.flags = DRIVE_FLAG_LATE;
    ticks(cfg.supervision.late_max);
    in.adc_ia = 4000U;
    TEST_ASSERT_EQUAL_UINT32(1U, run_to_fault(FAULT_LATE, 1U));
}

TEST(test_late_ticks_without_current_are_no_fault)
{
    go_to(DRIVE_STATE_READY);
    in.flags = DRIVE_FLAG_LATE;
    ticks(1000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
}

TEST(test_a_flipped_bit_of_the_configuration_is_a_fault_in_bounded_time_in_every_state)
{
    const uint32_t most = 2U * (uint32_t)CONFIG_GUARD_STEPS * SUPERVISION_TICKS;

    go_to(DRIVE_STATE_RUN);
    supervise_nothing(); /* there is no motor */
    cfg.position_loop.gain ^= 1;
    TEST_ASSERT_TRUE(run_to_fault(FAULT_CONFIGURATION, most) <= most);
    setUp();
    go_to(DRIVE_STATE_READY);
    cfg.position_loop.gain ^= 1;
    ticks(most);
    TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, drive.fault.id);
}

TEST(test_overtemperature_is_a_fault_in_every_state_that_a_drive_rests_in)
{
    static const drive_state_t states[] = {DRIVE_STATE_READY, DRIVE_STATE_RUN};

    for (uint32_t s = 0U; s < 2U; s++) {
        setUp();
        go_to(states[s]);
        supervise_nothing();
        cfg.derating.temperature.gain = example_derating_cfg().temperature.gain;
        seal();
        in.adc_temperature = 2100U; /* limit 2048 */
        ticks((cfg.derating.temperature_periods + 2U) * SUPERVISION_TICKS);
        TEST_ASSERT_EQUAL_INT(FAULT_OVERTEMPERATURE, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(2100, drive.fault.value);
        assert_gates_open();
    }
}

TEST(test_currents_that_do_not_follow_at_standstill_are_a_lost_phase)
{
    uint32_t k = 0U;

    go_to(DRIVE_STATE_RUN);
    in.adc_ia = MID_COUNTS + 200U; /* 1600 of Q15 that nobody asked for, limit 1101 */
    while ((drive.state == DRIVE_STATE_RUN) && (k < 2000U)) {
        nn_observer_start(&drive.rotor.observer, &cfg.observer, 0, (dq_t){0, 0},
                          trig_sincos(0U)); /* it stands */
        drive.rotor.position.turns_q32 = 0;
        tick();
        k++;
    }
    TEST_ASSERT_EQUAL_INT(FAULT_LOST_PHASE, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(cfg.supervision.follow_error_max, drive.fault.limit);
    assert_gates_open();
}

static void run_a_slow_period(uint16_t bus)
{
    in.adc_bus = bus;
    for (uint32_t k = 0U; k < cfg.slow_ticks; k++) {
        drive.rotor.observer.speed = 10000000;
        tick();
    }
}

TEST(test_a_high_bus_takes_the_braking_torque_and_a_low_one_the_motoring)
{
    go_to(DRIVE_STATE_RUN);
    run_a_slow_period(3600U); /* 396 V */
    TEST_ASSERT_TRUE((drive.motion.torque_range.lower > -2000) &&
                     (drive.motion.torque_range.upper == 8192));
    run_a_slow_period(1850U); /* 203 V */
    TEST_ASSERT_TRUE((drive.motion.torque_range.lower == -8192) &&
                     (drive.motion.torque_range.upper < 2000));
}

TEST(test_the_shortest_slow_periods_supervise_too)
{
    for (uint32_t n = 6U; n <= 7U; n++) {
        setUp();
        cfg.slow_ticks = n;
        seal();
        TEST_ASSERT_NULL(drive_init(&drive, &cfg));
        quiet_frame();
        go_to(DRIVE_STATE_RUN);
        in.adc_temperature = 4000U;
        TEST_ASSERT_TRUE(run_to_fault(FAULT_OVERTEMPERATURE, 1000U) <=
                         ((cfg.derating.temperature_periods + 2U) * SUPERVISION_STEPS * n));
    }
}

TEST(test_each_fault_opens_the_gates_in_its_tick_in_every_state_that_watches_it)
{
    for (uint32_t f = 0U; f < 4U; f++) {
        for (uint32_t s = 0U; s < 4U; s++) {
            setUp();
            go_to(STATES[s]);
            TEST_ASSERT_EQUAL_INT(STATES[s] == DRIVE_STATE_RUN, (s != 0U) && out.gate_enable);
            FAULT_FRAMES[f].make(&in);
            tick();
            assert_gates_open();
            if (STATES[s] < FAULT_FRAMES[f].first) {
                TEST_ASSERT_TRUE(drive.state != DRIVE_STATE_FAULT);
                continue;
            }
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(FAULT_FRAMES[f].id, drive.fault.id);
            /* A break is no measurement of ours. */
            if (FAULT_FRAMES[f].id != FAULT_BREAK) {
                TEST_ASSERT_EQUAL_INT32(FAULT_FRAMES[f].limit, drive.fault.limit);
                TEST_ASSERT_EQUAL_INT32(FAULT_FRAMES[f].value, drive.fault.value);
            }
        }
    }
}

/* ---- the safe state: its configuration shorts the motor above OPEN_SPEED ---- */

#define OPEN_SPEED (20000000) /* 1397 rpm, 215 ticks a turn */
#define SHORT_TICKS (430U)

static void assert_short(void)
{
    TEST_ASSERT_TRUE(out.gate_enable);
    assert_phases(0U);
}

static void short_above_speed(void)
{
    setUp();
    cfg.safe_state = example_safe_state_cfg(OPEN_SPEED, 2000, SHORT_TICKS);
    supervise_nothing();
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
}

/* RUN, as if the rotor had this speed by the estimate and that by the reference. */
static void run_at(step_t estimate, step_t reference)
{
    short_above_speed();
    go_to(DRIVE_STATE_RUN);
    drive.rotor.observer.speed = estimate;
    drive.motion.speed_loop.reference = reference;
}

/*
 * Where the estimate is lost the reference tells the speed. Below RUN a load may drive the rotor on
 * while the vector is slow. In RUN the vector is where the rotor was caught.
 */
TEST(test_a_fault_of_a_rotor_that_may_be_fast_shorts_the_motor_in_its_tick)
{
    static const step_t FAST = OPEN_SPEED + 100000;
    static const step_t SLOW = OPEN_SPEED - 1000000;
    const struct {
        const char *name;
        drive_state_t state;
        step_t estimate;
        step_t reference;
        step_t vector;
        bool shorts;
    } cases[] = {
        {"fast estimate", DRIVE_STATE_RUN, -FAST, 0, 0, true},
        {"fast reference", DRIVE_STATE_RUN, 0, FAST, 0, true},
        {"slow", DRIVE_STATE_RUN, SLOW, SLOW, OPEN_SPEED + 1, false},
        {"below RUN", DRIVE_STATE_HANDOVER, FAST, 0, 0, true},
    };

    for (uint32_t k = 0U; k < (4U * 3U); k++) {
        const uint32_t at = k / 3U;
        const uint32_t f = 1U + (k % 3U); /* all but the break; a high bus shorts any motor */
        const bool shorts = cases[at].shorts || (FAULT_FRAMES[f].id == FAULT_OVERVOLTAGE);

        run_at(cases[at].estimate, cases[at].reference);
        drive.state = cases[at].state;
        drive.vector.step = cases[at].vector;
        FAULT_FRAMES[f].make(&in);
        tick();
        TEST_ASSERT_EQUAL_INT_MESSAGE(shorts, out.gate_enable, cases[at].name);
        assert_phases(shorts ? 0U : 4250U);
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_STATE_FAULT, drive.state, cases[at].name);
        TEST_ASSERT_EQUAL_INT_MESSAGE(FAULT_FRAMES[f].id, drive.fault.id, cases[at].name);
    }
}

/* Estimate and reference are those of the last run. */
static void leave_probe(step_t vector)
{
    run_at(OPEN_SPEED + 100000, OPEN_SPEED + 100000);
    drive.state = DRIVE_STATE_PROBE;
    drive.vector.step = vector;
    make_overcurrent(&in);
    tick();
}

TEST(test_in_probe_the_vector_tells_the_speed)
{
    leave_probe(-OPEN_SPEED - 1);
    assert_short();
    leave_probe(OPEN_SPEED);
    assert_gates_open();
}

/* The estimate and the reference, which follows it, are of a slow rotor. */
static void leave_torque_control(step_t forward, step_t backward, bool by_fault)
{
    run_at(0, 0);
    drive.motion.mode = (uint8_t)DRIVE_MODE_TORQUE;
    in.command.mode = (uint8_t)DRIVE_MODE_TORQUE;
    cfg.torque_loop.speed_forward = forward;
    cfg.torque_loop.speed_backward = backward;
    if (by_fault) {
        make_overcurrent(&in);
    } else {
        in.command.request = 0U;
    }
    tick();
}

TEST(test_behind_a_fault_of_torque_control_the_rotor_may_be_as_fast_as_the_window_allows)
{
    leave_torque_control(OPEN_SPEED + 1, 0, true);
    assert_short();
    leave_torque_control(0, OPEN_SPEED + 1, true);
    assert_short();
    leave_torque_control(OPEN_SPEED, OPEN_SPEED, true);
    assert_gates_open();
    leave_torque_control(OPEN_SPEED + 1, OPEN_SPEED + 1, false);
    assert_gates_open();
}

TEST(test_a_stop_of_a_fast_rotor_shorts_the_motor_until_it_is_slow)
{
    run_at(OPEN_SPEED + 100000, 0);
    in.command.request = 0U;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    for (uint32_t k = 0U; k < SHORT_TICKS; k++) {
        assert_short();
        tick();
    }
    ticks(20U); /* a span */
    assert_gates_open();
}

/* The currents of the short circuit are no zero of a sensor, and no place to start from. */
TEST(test_while_the_motor_is_shorted_nothing_begins)
{
    run_at(OPEN_SPEED + 100000, 0);
    make_overcurrent(&in);
    tick();
    quiet_frame();
    in.command.request = DRIVE_REQUEST_CLEAR;
    ticks(SHORT_TICKS - 1U);
    assert_short();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    ticks(30U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);

    run_at(OPEN_SPEED + 100000, 0);
    in.command.request = 0U;
    tick();
    in.command.request = DRIVE_REQUEST_RUN;
    ticks(SHORT_TICKS - 1U);
    assert_short();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    ticks(30U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
}

TEST(test_a_break_opens_the_gates_at_any_speed_until_it_is_cleared)
{
    run_at(OPEN_SPEED + 100000, 0);
    make_break(&in);
    tick();
    assert_gates_open();
    quiet_frame();
    make_overvoltage(&in);
    ticks(10U);
    assert_gates_open();

    run_at(OPEN_SPEED + 100000, 0); /* in the short circuit */
    make_overcurrent(&in);
    tick();
    assert_short();
    make_break(&in);
    tick();
    assert_gates_open();
    quiet_frame();
    in.command.request = DRIVE_REQUEST_CLEAR;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
    TEST_ASSERT_EQUAL_INT(SAFE_STATE_OPEN, drive.safe_state.phase);
}

/* A load turns the motor: with open gates its EMF charges the bus. */
TEST(test_a_high_bus_shorts_a_motor_that_is_not_driven)
{
    short_above_speed();
    go_to(DRIVE_STATE_READY);
    assert_gates_open();
    make_overvoltage(&in);
    tick();
    assert_short();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, drive.fault.id);
}

/* Both are watched from RUN on only: the tick that enters RUN must watch them already. */
TEST(test_a_run_command_at_overcurrent_or_undervoltage_never_enables_the_gates)
{
    for (uint32_t f = 1U; f < 4U; f += 2U) {
        setUp();
        go_to(DRIVE_STATE_READY);
        FAULT_FRAMES[f].make(&in);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
        in.command.request = DRIVE_REQUEST_RUN;
        for (uint32_t k = 0U; k < 5U; k++) {
            tick();
            assert_gates_open();
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(FAULT_FRAMES[f].id, drive.fault.id);
            TEST_ASSERT_EQUAL_INT32(FAULT_FRAMES[f].value, drive.fault.value);
            TEST_ASSERT_EQUAL_INT32(FAULT_FRAMES[f].limit, drive.fault.limit);
        }
    }
}

/* The command comes first: with the gates open anyway only what READY watches can be wrong. */
TEST(test_a_stop_in_the_frame_of_a_fault_latches_only_what_ready_watches)
{
    for (uint32_t f = 0U; f < 4U; f++) {
        const bool watched = FAULT_FRAMES[f].first <= DRIVE_STATE_READY;

        setUp();
        go_to(DRIVE_STATE_RUN);
        FAULT_FRAMES[f].make(&in);
        in.command.request = 0U;
        tick();
        assert_gates_open();
        TEST_ASSERT_EQUAL_INT(watched ? DRIVE_STATE_FAULT : DRIVE_STATE_READY, drive.state);
        TEST_ASSERT_EQUAL_INT(watched ? FAULT_FRAMES[f].id : FAULT_NONE, drive.fault.id);
    }
}

TEST(test_nothing_new_is_latched_in_fault)
{
    for (uint32_t f = 0U; f < 4U; f++) {
        fault_t first;

        setUp();
        go_to(DRIVE_STATE_RUN);
        FAULT_FRAMES[f].make(&in);
        tick();
        first = drive.fault;
        for (uint32_t other = 0U; other < 4U; other++) {
            quiet_frame();
            FAULT_FRAMES[other].make(&in);
            tick();
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_MEMORY(&first, &drive.fault, sizeof first);
        }
    }
}

TEST(test_a_fault_stays_latched_until_cleared_without_the_run_command)
{
    static const uint8_t requests[] = {0U, DRIVE_REQUEST_RUN,
                                       DRIVE_REQUEST_RUN | DRIVE_REQUEST_CLEAR};

    for (uint32_t f = 0U; f < 4U; f++) {
        setUp();
        go_to(DRIVE_STATE_RUN);
        FAULT_FRAMES[f].make(&in);
        tick();
        quiet_frame();
        for (uint32_t k = 0U; k < 300U; k++) {
            in.command.request = requests[k % 3U];
            tick();
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            assert_gates_open();
        }
        in.command.request = DRIVE_REQUEST_CLEAR;
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_OFFSET_CAL, drive.state);
        assert_gates_open();
        in.command.request = 0U;
        ticks(CALIBRATION_TICKS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    }
}

TEST(test_a_fault_that_persists_comes_back_after_clearing)
{
    go_to(DRIVE_STATE_RUN);
    make_break(&in);
    tick();
    in.command.request = DRIVE_REQUEST_CLEAR;
    tick();
    in.command.request = 0U;
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_BREAK, drive.fault.id);
}

TEST(test_a_clear_in_the_frame_of_the_fault_does_not_acknowledge_it)
{
    go_to(DRIVE_STATE_READY);
    in.command.request = DRIVE_REQUEST_CLEAR;
    make_break(&in);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
}

/* ---- running ---- */

TEST(test_current_demand_changes_once_in_a_slow_period_only)
{
    int32_t before = 0;
    uint32_t changes = 0U;

    go_to(DRIVE_STATE_READY);
    await_slow_period();
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.target = 20000000;
    for (uint32_t k = 1U; k <= 100U; k++) {
        tick();
        if (drive.control.current_ref.q != before) {
            TEST_ASSERT_EQUAL_UINT32(0U, k % cfg.slow_ticks);
            changes++;
        }
        before = drive.control.current_ref.q;
    }
    /* It moves in every period until it has reached its limit. */
    TEST_ASSERT_TRUE(changes > 4U);
}

TEST(test_observer_sees_the_ratio_of_two_ticks_ago_times_the_mean_bus)
{
    ab_t ratios[2] = {{0, 0}, {0, 0}};
    seeded_t seed = {0x0B5E4EU};
    int32_t bus_before = 0;

    ask_to_run(20000000);
    tick();
    for (uint32_t k = 0U; k < 200U; k++) {
        int32_t bus = 0;

        bus_before = drive.bus;
        in.adc_bus = (uint16_t)seeded_in(&seed, 2500, 3000);
        tick();
        bus = (bus_before + drive.bus) >> 1;
        assert_ab((ab_t){(ratios[0].alpha * bus) >> 15, (ratios[0].beta * bus) >> 15},
                  applied_voltage());
        ratios[0] = ratios[1];
        ratios[1] = drive.control.ratio_next;
    }
    TEST_ASSERT_TRUE(ratios[0].beta != 0);
}

TEST(test_change_to_position_mode_takes_the_present_position_as_its_start)
{
    go_to(DRIVE_STATE_RUN);
    drive.rotor.position.turns_q32 = 123456789012;
    nn_observer_start(&drive.rotor.observer, &cfg.observer, 0, (dq_t){0, 0},
                      trig_sincos(rotor_position_angle(&drive.rotor.position)));
    in.command.mode = DRIVE_MODE_POSITION;
    in.command.target = (int32_t)((123456789012 - (28 * TURN_Q32)) / 65536); /* of 14 turns */
    ticks(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT64(28 * TURN_Q32, drive.motion.position_loop.zero_q32);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_POSITION, drive.motion.mode);
    /* Within the rest that the Q16 command cannot express: the profile starts there. */
    TEST_ASSERT_TRUE(llabs(drive.motion.position_loop.profile_q32 - 123456789012) < 1000000);
}

TEST(test_profile_moves_by_its_speed_times_the_ticks_of_the_slow_period)
{
    static const uint32_t periods[] = {6U, 37U};

    for (uint32_t i = 0U; i < 2U; i++) {
        cfg = example_drive_cfg();
        cfg.slow_ticks = periods[i];
        supervise_nothing(); /* there is no motor */
        TEST_ASSERT_NULL(drive_init(&drive, &cfg));
        quiet_frame();
        go_to(DRIVE_STATE_READY);
        in.command = (drive_command_t){
            .target = INT32_MAX, .mode = DRIVE_MODE_POSITION, .request = DRIVE_REQUEST_RUN};
        tick();
        for (uint32_t k = 0U; k < 50U; k++) {
            const int64_t before = drive.motion.position_loop.profile_q32;

            ticks(periods[i]);
            TEST_ASSERT_TRUE(drive.motion.position_loop.profile_speed > 0);
            if (k > 0U) { /* the first period starts with the change of mode */
                TEST_ASSERT_EQUAL_INT64(
                    before + ((int64_t)drive.motion.position_loop.profile_speed * periods[i]),
                    drive.motion.position_loop.profile_q32);
            }
        }
    }
}

TEST(test_an_unknown_mode_counts_as_speed)
{
    go_to(DRIVE_STATE_RUN);
    in.command.mode = 7U;
    in.command.target = 5000000;
    ticks(cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT32(143166, drive.motion.speed_reference); /* one ramp */
}

TEST(test_saturated_samples_keep_their_sign)
{
    go_to(DRIVE_STATE_READY);
    in.adc_ia = 65535U;
    in.adc_ib = 0U;
    in.adc_bus = 65535U;
    tick();
    TEST_ASSERT_EQUAL_INT32(16383, instant_sample(&drive, &in).phase_a);
    TEST_ASSERT_EQUAL_INT32(-16384, instant_sample(&drive, &in).phase_b);
    TEST_ASSERT_EQUAL_INT32(32767, drive.bus);
}

/* ---- purity ---- */

/* Frames that keep a drive running most of the time, with everything else random. */
static drive_in_t seeded_frame(seeded_t *seed)
{
    const uint32_t event = seeded_u32(seed) % 1000U;

    return (drive_in_t){
        .adc_ia = (uint16_t)seeded_in(seed, 1000, 3000),
        .adc_ib = (uint16_t)seeded_in(seed, 1000, 3000),
        .adc_bus = (uint16_t)((event == 1U) ? 4095 : seeded_in(seed, 2200, 3400)),
        .flags = (event == 2U) ? DRIVE_FLAG_BREAK : 0U,
        .command = {.target = seeded_i32(seed),
                    .mode = (uint8_t)(seeded_u32(seed) % 3U),
                    .request = (event < 20U) ? DRIVE_REQUEST_CLEAR : DRIVE_REQUEST_RUN},
    };
}

TEST(test_equal_frames_give_equal_states_and_outputs_byte_by_byte)
{
    seeded_t seed = {0x9E37U};
    static drive_t other;
    drive_out_t other_out;

    cfg.sampling.offset_log2 = 4U;
    cfg.protection.offset_max = 32767;
    seal();
    memset(&other, 0, sizeof other);
    memset(&other_out, 0, sizeof other_out);
    memset(&out, 0, sizeof out);
    (void)drive_init(&other, &cfg);
    for (int32_t k = 0; k < 20000; k++) {
        in = seeded_frame(&seed);
        drive_step(&drive, &in, &out);
        drive_step(&other, &in, &other_out);
        TEST_ASSERT_EQUAL_MEMORY(&drive, &other, sizeof drive);
        TEST_ASSERT_EQUAL_MEMORY(&out, &other_out, sizeof out);
    }
}

TEST(test_a_copy_is_a_snapshot_from_which_the_same_future_follows)
{
    static drive_in_t frames[2000];
    static drive_t snapshot;
    static drive_t end;
    seeded_t seed = {0x5AA9U};

    cfg.sampling.offset_log2 = 4U;
    cfg.protection.offset_max = 32767;
    seal();
    for (int32_t k = 0; k < 3000; k++) {
        in = seeded_frame(&seed);
        tick();
    }
    snapshot = drive;
    for (int32_t k = 0; k < 2000; k++) {
        frames[k] = seeded_frame(&seed);
        drive_step(&drive, &frames[k], &out);
    }
    end = drive;
    drive = snapshot;
    for (int32_t k = 0; k < 2000; k++) {
        drive_step(&drive, &frames[k], &out);
    }
    TEST_ASSERT_EQUAL_MEMORY(&end, &drive, sizeof drive);
}

/* ---- any frame ---- */

static void assert_everything_in_range(void)
{
    const dq_t voltage = drive.control.voltage;
    const int32_t limit = modulator_limit(&cfg.modulator, drive.bus);

    for (int32_t p = 0; p < 3; p++) {
        TEST_ASSERT_TRUE(out.compare.phase[p] <= cfg.modulator.timer_counts);
    }
    TEST_ASSERT_TRUE(!out.gate_enable || (drive.state == DRIVE_STATE_RUN) ||
                     (drive.state == DRIVE_STATE_PROBE));
    TEST_ASSERT_TRUE((drive.state >= DRIVE_STATE_INIT) && (drive.state <= DRIVE_STATE_FAULT));
    TEST_ASSERT_TRUE((drive.bus >= 0) && (drive.bus <= 32767));
    TEST_ASSERT_TRUE(abs(drive.control.current_ref.q) <= cfg.derating.current_max);
    if (drive.state == DRIVE_STATE_RUN) {
        TEST_ASSERT_TRUE(((voltage.d * voltage.d) + (voltage.q * voltage.q)) <= (limit * limit));
    }
}

static uint16_t extreme_count(seeded_t *seed)
{
    static const uint16_t ends[] = {0U, 1U, 2047U, 2048U, 2049U, 4094U, 4095U, 65535U};

    return ends[seeded_u32(seed) % 8U];
}

static int32_t extreme_target(seeded_t *seed)
{
    static const int32_t ends[] = {INT32_MIN, -1, 0, 1, INT32_MAX};

    return ends[seeded_u32(seed) % 5U];
}

TEST(test_any_raw_frame_keeps_all_outputs_in_range)
{
    seeded_t seed = {0xF4A4E5U};

    for (uint32_t run = 0U; run < 40U; run++) {
        setUp();
        cfg.sampling.offset_log2 = run % 13U;
        cfg.sampling.current_shift = run % 8U;
        cfg.sampling.bus_shift = (run / 2U) % 8U;
        cfg.protection = (protection_cfg_t){8192, 32766, 0, 0};
        supervise_nothing();
        TEST_ASSERT_NULL(drive_init(&drive, &cfg));
        cfg.protection = (protection_cfg_t){16382, 32766, 0, 32767};
        seal();
        for (uint32_t k = 0U; k < 5000U; k++) {
            in.adc_ia = ((k % 2U) == 0U) ? extreme_count(&seed) : (uint16_t)seeded_u32(&seed);
            in.adc_ib = ((k % 3U) == 0U) ? extreme_count(&seed) : (uint16_t)seeded_u32(&seed);
            in.adc_bus = ((k % 5U) == 0U) ? extreme_count(&seed) : (uint16_t)seeded_u32(&seed);
            in.flags = (uint16_t)(seeded_u32(&seed) & ((k % 7U) == 0U ? 0xFFFFU : 0xFFFEU));
            in.command.target = extreme_target(&seed);
            in.command.mode = (uint8_t)seeded_u32(&seed);
            in.command.request = (uint8_t)seeded_u32(&seed);
            tick();
            assert_everything_in_range();
        }
    }
}

TEST(test_wild_but_allowed_measurements_keep_a_running_drive_in_range)
{
    seeded_t seed = {0x3177DU};

    cfg.protection = (protection_cfg_t){16382, 32766, 0, 32767};
    supervise_nothing();
    go_to(DRIVE_STATE_RUN);
    for (uint32_t k = 0U; k < 100000U; k++) {
        /* |a|, |b| and |a + b| within ±16382: ±1023 counts each. */
        in.adc_ia = (uint16_t)((int32_t)MID_COUNTS + seeded_in(&seed, -1, 1) * 1023);
        in.adc_ib = (uint16_t)((int32_t)MID_COUNTS + seeded_in(&seed, -1, 1) * 1023);
        in.adc_bus = (uint16_t)seeded_in(&seed, 0, 4095);
        in.command.target = ((k % 1000U) == 0U) ? extreme_target(&seed) : in.command.target;
        in.command.mode = (uint8_t)((k / 10000U) % 2U);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
        assert_everything_in_range();
    }
}

/* ---- closed loop ---- */

static void run_motor(uint32_t count, double load_nm)
{
    for (uint32_t k = 0U; k < count; k++) {
        example_motor_measure(&motor, &in);
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
        example_motor_tick(&motor, &out, load_nm);
    }
}

/* Of the shaft, which has two pole pairs. */
static double shaft_turns(void)
{
    return motor.angle / 2.0 / (2.0 * EXAMPLE_PI);
}

static double estimated_turns(int64_t position_q32)
{
    return (double)position_q32 / 4294967296.0 / 2.0;
}

static double shaft_rpm(void)
{
    return motor.speed / 2.0 * 30.0 / EXAMPLE_PI;
}

/* Speeds in tests below hold to 1 % of rated speed: 18 rpm, half the specified 2 % band. */
#define SPEED_TOLERANCE_RPM (18.0)

TEST(test_speed_command_is_followed_by_a_motor_in_both_directions_and_under_load)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        setUp();
        ask_to_run((int32_t)lround(sign * 1000.0 * STEPS_PER_RPM));
        for (int32_t loaded = 0; loaded <= 1; loaded++) {
            run_motor(5000U, loaded * sign * 3.0);
            TEST_ASSERT_DOUBLE_WITHIN(SPEED_TOLERANCE_RPM, sign * 1000.0, shaft_rpm());
        }
        TEST_ASSERT_DOUBLE_WITHIN(SPEED_TOLERANCE_RPM, sign * 1000.0,
                                  drive_speed(&drive) / STEPS_PER_RPM);
    }
}

/* Position holds to 2° mechanical as specified; the estimate itself follows the rotor. */
#define POSITION_TOLERANCE_TURNS (2.0 / 360.0)

TEST(test_position_command_is_reached_by_a_motor_in_both_directions)
{
    ask_to_run(0);
    in.command.mode = DRIVE_MODE_POSITION;
    for (int32_t sign = 1; sign >= -1; sign -= 2) {
        in.command.target = sign * 3 * 65536; /* electrical turns: 1.5 mechanical */
        run_motor(10000U, 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, sign * 1.5, shaft_turns());
        TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, sign * 1.5,
                                  estimated_turns(drive_position_q32(&drive)));
    }
}

/*
 * One slow period. The profile keeps its own ramp. The reference adds the correction of the lag,
 * which grows by gain·lag·period, 3.1 % of the lag of the speed, in a period. The bridge takes
 * three periods to the torque of the ramp: until then the rotor falls back by 1, 2/3 and 1/3 of a
 * ramp, two in all.
 */
static void run_without_bump(void)
{
    const step_t reference = drive.motion.speed_loop.reference;
    const bool changes = drive.motion.mode != (uint8_t)DRIVE_MODE_POSITION;
    const step_t profile = changes ? reference : drive.motion.position_loop.profile_speed;

    run_motor(cfg.slow_ticks, 0.0);
    TEST_ASSERT_TRUE(abs(drive.motion.position_loop.profile_speed - profile) <=
                     cfg.position_loop.ramp);
    TEST_ASSERT_TRUE((100 * (int64_t)abs(drive.motion.speed_loop.reference - reference)) <=
                     (107 * (int64_t)cfg.position_loop.ramp));
    TEST_ASSERT_TRUE(abs(drive.control.current_ref.q) < cfg.derating.current_max);
}

TEST(test_change_to_position_mode_at_speed_has_no_bump_and_comes_back_to_the_target)
{
    static const double speeds_rpm[] = {-1950.0, -1200.0, -300.0, 600.0, 900.0, 1500.0, 1800.0};

    for (uint32_t i = 0U; i < (sizeof speeds_rpm / sizeof speeds_rpm[0]); i++) {
        int64_t before = 0;
        int64_t target = 0;

        setUp();
        ask_to_run((int32_t)lround(speeds_rpm[i] * STEPS_PER_RPM));
        run_motor(6000U, 0.0);
        in.command.mode = DRIVE_MODE_POSITION;
        in.command.target = 0;
        before = drive_position_q32(&drive);
        for (uint32_t k = 0U; k < 1500U; k++) {
            run_without_bump();
        }
        target = drive.motion.position_loop.zero_q32;
        TEST_ASSERT_EQUAL_INT64(0, target % (2 * TURN_Q32)); /* where it started, in this turn */
        TEST_ASSERT_TRUE(llabs(target - before) <= (TURN_Q32 + (TURN_Q32 / 10)));
        TEST_ASSERT_EQUAL_INT64(target, drive.motion.position_loop.profile_q32);
        TEST_ASSERT_EQUAL_INT32(0, drive.motion.position_loop.profile_speed);
        TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, estimated_turns(target),
                                  estimated_turns(drive_position_q32(&drive)));
    }
}

/*
 * As after half a day at 1800 rpm. The zero is the start of the turn of the shaft that is nearest:
 * half a turn of it is 1 electrical one.
 */
TEST(test_a_change_to_position_mode_unwinds_no_turn_that_speed_control_has_made)
{
    static const int64_t turns[] = {1000000, -1000000, 1000000001};

    for (uint32_t i = 0U; i < (sizeof turns / sizeof turns[0]); i++) {
        double start = 0.0;

        setUp();
        ask_to_run((int32_t)lround(60.0 * STEPS_PER_RPM));
        run_motor(6000U, 0.0);
        in.command.target = 0;
        run_motor(2000U, 0.0);
        drive.rotor.position.turns_q32 += turns[i] * 2 * TURN_Q32;
        start = motor.angle;
        in.command.mode = DRIVE_MODE_POSITION;
        run_motor(10000U, 0.0);
        TEST_ASSERT_TRUE(fabs(motor.angle - start) < (2.0 * EXAMPLE_PI * 1.02));
        TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, 0.0, remainder(shaft_turns(), 1.0));
        TEST_ASSERT_EQUAL_INT64(0, drive.motion.position_loop.profile_q32 -
                                       drive.motion.position_loop.zero_q32);
    }
}

/* The request stays for so long as the drive takes to be told of another one. */
static void zero_here(void)
{
    in.command.request = DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO;
    run_motor(2U * cfg.slow_ticks, 0.0);
    in.command.request = DRIVE_REQUEST_RUN;
}

TEST(test_a_zero_at_rest_in_position_mode_moves_nothing_and_targets_count_from_it)
{
    int64_t profile = 0;

    ask_to_run(0);
    in.command.mode = DRIVE_MODE_POSITION;
    in.command.target = (int32_t)lround(1.3 * 2.0 * 65536.0);
    run_motor(10000U, 0.0);
    profile = drive.motion.position_loop.profile_q32;
    zero_here();
    TEST_ASSERT_EQUAL_INT64(profile, drive.motion.position_loop.profile_q32);
    in.command.target = 0;
    run_motor(2000U, 0.0);
    TEST_ASSERT_EQUAL_INT64(profile, drive.motion.position_loop.profile_q32);
    TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, 1.3, shaft_turns());
    in.command.target = -2 * 65536;
    run_motor(10000U, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, 0.3, shaft_turns());
    TEST_ASSERT_DOUBLE_WITHIN(POSITION_TOLERANCE_TURNS, -1.0,
                              estimated_turns(drive_position_from_zero_q32(&drive)));
}

/* The profile brakes along its ramp, and comes back to where it was when the request ended. */
TEST(test_a_zero_on_the_way_has_no_jump_and_the_rotor_comes_back_to_it)
{
    double there = 0.0;

    ask_to_run(0);
    in.command.mode = DRIVE_MODE_POSITION;
    in.command.target = 20 * 65536;
    run_motor(3000U, 0.0);
    TEST_ASSERT_TRUE(abs(drive.motion.position_loop.profile_speed) > (10 * cfg.position_loop.ramp));
    in.command.request = DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO;
    in.command.target = 0;
    run_without_bump();
    run_without_bump();
    in.command.request = DRIVE_REQUEST_RUN;
    there = shaft_turns();
    for (uint32_t k = 0U; k < 1000U; k++) {
        run_without_bump();
    }
    TEST_ASSERT_EQUAL_INT64(drive.motion.position_loop.zero_q32,
                            drive.motion.position_loop.profile_q32);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, there, shaft_turns());
}

TEST(test_a_zero_in_speed_mode_is_where_the_rotor_is_and_changes_nothing_else)
{
    step_t before = 0;

    ask_to_run((int32_t)lround(600.0 * STEPS_PER_RPM));
    run_motor(6000U, 0.0);
    before = drive.motion.speed_loop.reference;
    zero_here();
    TEST_ASSERT_EQUAL_INT32(before, drive.motion.speed_loop.reference);
    TEST_ASSERT_TRUE(drive.motion.position_loop.zero_q32 != 0);
    TEST_ASSERT_TRUE(llabs(drive_position_from_zero_q32(&drive)) < (TURN_Q32 / 10));
}

TEST(test_without_a_sensor_a_zero_at_rest_is_none)
{
    go_to(DRIVE_STATE_READY);
    drive.rotor.position.turns_q32 = 5 * TURN_Q32; /* of the last run */
    in.command.request = DRIVE_REQUEST_ZERO;
    ticks(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    TEST_ASSERT_EQUAL_INT64(0, drive.motion.position_loop.zero_q32);
}

TEST(test_a_late_tick_leaves_the_observer_without_voltage)
{
    ask_to_run(20000000);
    run_motor(500U, 0.0);
    TEST_ASSERT_TRUE(applied_voltage().alpha != 0);
    in.flags = DRIVE_FLAG_LATE; /* of the tick before */
    tick();
    in.flags = 0U;
    tick();
    assert_ab((ab_t){0, 0}, applied_voltage());
    tick();
    TEST_ASSERT_TRUE(applied_voltage().alpha != 0);
}

/* ---- one tick beside its parts, on a running motor ---- */

/* Up to 1800 rpm, a tick at a time, with a bus that changes in every tick by up to 3 %. */
static void run_beside(int32_t sign, void (*check)(void))
{
    seeded_t seed = {0xB5B5U};

    setUp();
    TEST_ASSERT_TRUE(cfg.observer.kappa_p != 0); /* else speed_out is speed */
    ask_to_run(0);
    tick();
    in.command.target = (int32_t)lround(sign * 1800.0 * STEPS_PER_RPM);
    for (uint32_t k = 0U; k < 4000U; k++) {
        in.adc_bus = (uint16_t)seeded_in(&seed, 2780, 2864);
        run_motor(1U, 0.0);
        check();
    }
    TEST_ASSERT_DOUBLE_WITHIN(18.0, sign * 1800.0, shaft_rpm());
}

static uint32_t telling; /* ticks in which the speed without its proportional part would show */

/* Demand over bus as the tick computes it. */
static dq_t ratio_of(const modulator_t *modulator)
{
    return modulator_ratio(modulator, drive.control.voltage);
}

/* Sampled at t_k, acting on average at t_k + 1.5·T: the rotor is that much further then. */
static void check_angle_of_the_vector(void)
{
    const angle_t sampled = rotor_position_angle(&was.rotor.position);
    const step_t step = drive.rotor.observer.speed_out;
    const step_t other = drive.rotor.observer.speed;
    const angle_t middle = sampled + (angle_t)step + (angle_t)(step >> 1);
    const angle_t elsewhere = sampled + (angle_t)other + (angle_t)(other >> 1);
    const dq_t ratio = ratio_of(&drive.modulator);
    const ab_t expected = transforms_park_inverse(ratio, trig_sincos(middle));
    const ab_t unlike = transforms_park_inverse(ratio, trig_sincos(elsewhere));

    assert_ab(expected, drive.control.ratio_next);
    telling += ((unlike.alpha != expected.alpha) || (unlike.beta != expected.beta)) ? 1U : 0U;
}

TEST(test_vector_is_turned_for_the_middle_of_the_period_in_which_it_acts)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        telling = 0U;
        run_beside(sign, check_angle_of_the_vector);
        TEST_ASSERT_TRUE(telling > 1000U);
        TEST_ASSERT_TRUE((sign * drive.rotor.observer.speed_out) > 20000000);
    }
}

static void check_bus(void)
{
    const int32_t bus = (int32_t)in.adc_bus * 8; /* 15 − 12 bits */
    const angle_t sampled = rotor_position_angle(&was.rotor.position);
    const step_t step = drive.rotor.observer.speed_out;
    modulator_t modulator = was.modulator;
    ab_t ratio;

    modulator_track_bus(&modulator, modulator_bus_ahead(was.bus, bus));
    ratio = transforms_park_inverse(ratio_of(&modulator),
                                    trig_sincos(sampled + (angle_t)step + (angle_t)(step >> 1)));
    TEST_ASSERT_EQUAL_INT32(bus, drive.bus);
    TEST_ASSERT_EQUAL_INT32(modulator.inverse_bus_q12, drive.modulator.inverse_bus_q12);
    assert_ab(ratio, drive.control.ratio_next);
}

TEST(test_voltage_circle_and_reciprocal_follow_the_bus_of_the_same_tick)
{
    run_beside(1, check_bus);
}

TEST(test_reciprocal_follows_the_bus_of_the_same_tick_with_open_gates)
{
    seeded_t seed = {0x0FFU};

    for (uint32_t k = 0U; k < 600U; k++) {
        in.adc_bus = (uint16_t)seeded_in(&seed, 1000, 3600);
        tick();
        modulator_track_bus(&was.modulator, modulator_bus_ahead(was.bus, (int32_t)in.adc_bus * 8));
        TEST_ASSERT_EQUAL_INT32(was.modulator.inverse_bus_q12, drive.modulator.inverse_bus_q12);
        TEST_ASSERT_FALSE(out.gate_enable);
    }
}

/* Loops are fed with the integral ω̂; its proportional part would carry ripple into the demand. */
static void check_speed_and_demand(void)
{
    const step_t speed = drive.rotor.observer.speed;
    speed_loop_t loop = was.motion.speed_loop;
    speed_loop_t unlike = was.motion.speed_loop;
    int32_t demand = was.control.current_ref.q;
    int32_t other = demand;

    if (was.slow_count == 1U) { /* its last tick */
        demand = speed_loop_step(&loop, &cfg.speed_loop, was.motion.speed_reference, speed,
                                 drive.motion.torque_range);
        other = speed_loop_step(&unlike, &cfg.speed_loop, was.motion.speed_reference,
                                drive.rotor.observer.speed_out, drive.motion.torque_range);
    }
    TEST_ASSERT_EQUAL_INT32(demand, drive.control.current_ref.q);
    TEST_ASSERT_EQUAL_INT32(loop.pi.integral_q26, drive.motion.speed_loop.pi.integral_q26);
    telling += (other != demand) ? 1U : 0U;
}

TEST(test_speed_signal_and_current_demand_come_from_the_integral_of_the_observer)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        telling = 0U;
        run_beside(sign, check_speed_and_demand);
        TEST_ASSERT_TRUE(telling > 100U); /* of 400 slow periods */
    }
}

static void check_voltage(void)
{
    const dq_t reference = {.d = 0, .q = drive.control.current_ref.q};
    const sample_t sample = instant_sample(&drive, &in);
    const dq_t current = transforms_park(transforms_clarke(sample.phase_a, sample.phase_b),
                                         trig_sincos(rotor_position_angle(&was.rotor.position)));
    current_loop_t loop = was.control.current_loop;
    dq_t voltage;

    if (was.slow_count == 1U) { /* the plan is made with the reference */
        current_loop_plan(&loop, &cfg.current_loop, reference,
                          drive.rotor.observer.speed >> cfg.speed_shift);
    }
    voltage = current_loop_step(&loop, &cfg.current_loop, reference, current,
                                modulator_limit(&cfg.modulator, drive.bus));
    TEST_ASSERT_EQUAL_INT32(voltage.d, drive.control.voltage.d);
    TEST_ASSERT_EQUAL_INT32(voltage.q, drive.control.voltage.q);
}

TEST(test_voltage_demand_is_that_of_the_current_loop_with_no_current_along_the_flux)
{
    run_beside(1, check_voltage);
}

/* ---- what the legs lose ---- */

/* 1.2 V of 310 V are 33 counts of 8500. */
#define DROP_COUNTS (33)

TEST(test_a_device_drop_without_dead_time_is_given_back_to_the_legs_with_current)
{
    drive_cfg_t lossy = cfg;
    drive_t with_drop;
    drive_out_t without;

    go_to(DRIVE_STATE_RUN);
    in.adc_ia =
        MID_COUNTS + 200U; /* 2 A of which the reference has nothing: a quarter is expected */
    lossy.modulator.drop_q15 = 87;
    with_drop = drive;
    with_drop.cfg = &lossy;
    drive_step(&drive, &in, &without);
    drive_step(&with_drop, &in, &out);
    TEST_ASSERT_INT_WITHIN(1, DROP_COUNTS, out.compare.phase[0] - without.compare.phase[0]);
    TEST_ASSERT_INT_WITHIN(1, 0, out.compare.phase[1] - without.compare.phase[1]);
    TEST_ASSERT_INT_WITHIN(1, -DROP_COUNTS, out.compare.phase[2] - without.compare.phase[2]);
}

/*
 * As if nothing were planned before: what RUN begins with fits its own reference, speed and model.
 */
TEST(test_run_begins_with_a_plan_of_its_current_control)
{
    current_loop_t fresh;

    go_to(DRIVE_STATE_READY);
    in.command.request = DRIVE_REQUEST_RUN;
    while (drive.state != DRIVE_STATE_RUN) {
        drive.control.current_loop.constant = (dq_t){77, 77};
        tick();
    }
    fresh = drive.control.current_loop;
    current_loop_plan(&fresh, &drive.motor.model.run_loop, drive.control.current_ref,
                      drive_speed_q15(&drive, drive.rotor.observer.speed));
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &drive.control.current_loop, sizeof fresh);
}
