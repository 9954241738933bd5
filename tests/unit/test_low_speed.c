/* SPDX-License-Identifier: MIT */
/*
 * Start-up and low speed: the sequence of states with a motor, stops and faults in each of them,
 * any frame.
 */
#include "driven_motor.h"
#include "fault_frames.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"
#include "transitions.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RAD_S_PER_RPM (2.0 * EXAMPLE_PI / 30.0)
#define SLOW_RPM (100.0) /* between nothing and the hand-over at 180 rpm */
#define FAST_RPM (600.0)
#define PATIENCE_TICKS (40000U) /* 4 s: more than any state lasts here */

/* To READY as a chip that starts again: what the drive has had stays in its memory. */
static void begin(void)
{
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    in = (drive_in_t){.adc_ia = MID_COUNTS, .adc_ib = MID_COUNTS, .adc_bus = BUS_COUNTS};
    memset(&out, 0, sizeof out);
    motor = example_motor_at(0.0, 0.0);
    load_nm = 0.0;
    for (uint32_t k = 0U; k <= CALIBRATION_TICKS; k++) {
        drive_step(&drive, &in, &out);
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
}

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    memset(&drive, 0, sizeof drive);
    begin();
}

static void stay_in(drive_state_t state, uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick();
        TEST_ASSERT_EQUAL_INT(state, drive.state);
    }
}

static void run_at(double rpm)
{
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.target = (int32_t)lround(rpm * STEPS_PER_RPM);
}

/* To the tick that enters `state`, through `through` and no other. */
static void expect_next(drive_state_t through, drive_state_t state)
{
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.state != state); k++) {
        TEST_ASSERT_EQUAL_INT(through, drive.state);
        tick();
    }
    TEST_ASSERT_EQUAL_INT(state, drive.state);
}

/* From READY through all states between. */
static void expect_start_to(drive_state_t state)
{
    static const drive_state_t way[] = {
        DRIVE_STATE_READY,   DRIVE_STATE_FLYING_START, DRIVE_STATE_ALIGN, DRIVE_STATE_HOLD,
        DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER,     DRIVE_STATE_RUN};

    for (uint32_t i = 0U; drive.state != state; i++) {
        expect_next(way[i], way[i + 1U]);
    }
}

/* The first tick of the search for a rotor that turns. */
static void search(double rpm, double wanted_rpm)
{
    motor = example_motor_at(1.0, rpm * RAD_S_PER_RPM);
    run_at(wanted_rpm);
    tick();
}

static void assert_speed(double tolerance_rpm, double rpm)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance_rpm, rpm, motor.speed / RAD_S_PER_RPM);
}

/* From READY to the tick that enters a state with current. */
static void go_to(drive_state_t state)
{
    if (state == DRIVE_STATE_PROBE) {
        in.command.request = DRIVE_REQUEST_PROBE;
        expect_next(DRIVE_STATE_READY, DRIVE_STATE_PROBE);
        tick(); /* the first with current control */
    } else {
        run_at((state <= DRIVE_STATE_HOLD) ? 0.0 : FAST_RPM);
        expect_start_to(state);
    }
}

static bool is_driving(drive_state_t state)
{
    return (state > DRIVE_STATE_READY) && (state < DRIVE_STATE_FAULT);
}

/* ---- sequence ---- */

TEST(test_a_standing_rotor_is_looked_at_then_aligned_then_held)
{
    run_at(0.0);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
    expect_start_to(DRIVE_STATE_HOLD);
    for (uint32_t k = 0U; k < 5000U; k++) {
        stay_in(DRIVE_STATE_HOLD, 1U);
        TEST_ASSERT_TRUE(out.gate_enable);
    }
}

/*
 * The vector comes from where its sweep begins: from the side it then turns to. Each further
 * attempt sweeps the other way.
 */
TEST(test_a_rotor_is_pulled_in_backwards_for_a_speed_below_zero_and_at_every_other_attempt)
{
    static const struct {
        uint8_t mode;
        int32_t target;
        uint32_t attempts;
        bool backwards;
    } rows[] = {
        {DRIVE_MODE_SPEED, 0, 0U, false},  {DRIVE_MODE_SPEED, 1, 0U, false},
        {DRIVE_MODE_SPEED, -1, 0U, true},  {DRIVE_MODE_POSITION, -1, 0U, false},
        {DRIVE_MODE_SPEED, 1, 1U, true},   {DRIVE_MODE_SPEED, 1, 2U, false},
        {DRIVE_MODE_SPEED, -1, 1U, false},
    };

    for (uint32_t k = 0U; k < COUNT(rows); k++) {
        begin();
        in.command = (drive_command_t){
            .request = DRIVE_REQUEST_RUN, .mode = rows[k].mode, .target = rows[k].target};
        tick();
        drive.start.attempts = rows[k].attempts;
        expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_ALIGN);
        TEST_ASSERT_EQUAL(rows[k].backwards, drive.start.align.backwards);
        TEST_ASSERT_EQUAL(rows[k].backwards, drive.vector.position.turns_q32 > 0);
    }
}

TEST(test_a_low_speed_is_dragged_and_never_handed_over)
{
    go_to(DRIVE_STATE_HOLD);
    run_at(SLOW_RPM);
    expect_next(DRIVE_STATE_HOLD, DRIVE_STATE_IF_RAMP);
    stay_in(DRIVE_STATE_IF_RAMP, 10000U);
    /* The rotor is synchronous with the vector: it swings about its speed by less than a fifth. */
    assert_speed(0.2 * SLOW_RPM, SLOW_RPM);
    run_at(0.0);
    expect_next(DRIVE_STATE_IF_RAMP, DRIVE_STATE_HOLD);
}

/* Of rated speed 1 %: 18 rpm. */
#define SPEED_TOLERANCE_RPM (18.0)

TEST(test_a_high_speed_is_reached_through_hand_over_and_handed_back_to_come_to_rest_held)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        run_at(sign * FAST_RPM);
        expect_start_to(DRIVE_STATE_RUN);
        ticks(15000U);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
        assert_speed(SPEED_TOLERANCE_RPM, sign * FAST_RPM);
        run_at(0.0);
        ticks(PATIENCE_TICKS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_HOLD, drive.state);
        assert_speed(SPEED_TOLERANCE_RPM / 10.0, 0.0);
    }
}

/*
 * The bearing's friction is only viscous, so nothing but the ripple keeps the rotor from the
 * vector: a count of the converter, 10 mA of 8 A, is 0.07°; of the swing, damped with 0.7 at 79
 * rad/s, nothing is left after 1 s.
 */
#define ALIGNED_RAD (0.2 * EXAMPLE_PI / 180.0)

TEST(test_alignment_brings_the_rotor_from_every_angle_to_the_angle_of_the_frame)
{
    for (int32_t k = 0; k < 16; k++) {
        begin();
        motor = example_motor_at(2.0 * EXAMPLE_PI * k / 16.0, 0.0);
        run_at(((k % 2) == 0) ? 0.0 : -0.001);
        ticks(PATIENCE_TICKS / 2U);
        TEST_ASSERT_TRUE((drive.state == DRIVE_STATE_HOLD) || (drive.state == DRIVE_STATE_IF_RAMP));
        TEST_ASSERT_DOUBLE_WITHIN(
            ALIGNED_RAD, 0.0,
            remainder(motor.angle - ((double)rotor_position_angle(&drive.vector.position) /
                                     4294967296.0 * 2.0 * EXAMPLE_PI),
                      2.0 * EXAMPLE_PI));
    }
}

/*
 * A motor that is as configured: R within 1 %, for the voltage is rounded by the modulator to
 * 1/8500 of 310 V, 36 mV of 6.8 V between both levels, and the current by the converter, 10 mA of
 * 3.2 A. L within 2 %: two counts of the converter, 20 mA, of 3.2 A and the same again for the
 * quantised voltage.
 */
#define R_TOLERANCE (0.01)
#define L_TOLERANCE (0.02)

TEST(test_alignment_measures_what_was_configured)
{
    go_to(DRIVE_STATE_HOLD);
    TEST_ASSERT_TRUE(drive.motor.identified);
    TEST_ASSERT_DOUBLE_WITHIN(R_TOLERANCE, 1.0, drive.motor.model.resistance_q14 / 16384.0);
    TEST_ASSERT_DOUBLE_WITHIN(L_TOLERANCE, 1.0, drive.motor.model.inductance_q14 / 16384.0);
}

TEST(test_a_turning_rotor_is_caught_without_alignment_and_goes_on)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        search(sign * FAST_RPM, sign * FAST_RPM);
        expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_RUN);
        for (uint32_t k = 0U; k < 5000U; k++) {
            stay_in(DRIVE_STATE_RUN, 1U);
            assert_speed(5.0 * SPEED_TOLERANCE_RPM, sign * FAST_RPM);
        }
        TEST_ASSERT_DOUBLE_WITHIN(SPEED_TOLERANCE_RPM, sign * FAST_RPM,
                                  drive_speed(&drive) / STEPS_PER_RPM);
    }
}

TEST(test_a_rotor_that_turns_too_slowly_to_be_taken_over_is_held_by_a_vector_that_turns_with_it)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin();
        search(sign * 150.0, sign * FAST_RPM); /* of 180, from where the observer takes over */
        expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_IF_RAMP);
        TEST_ASSERT_EQUAL_INT32(drive.start.flying_start.speed, drive.vector.step);
        TEST_ASSERT_EQUAL_UINT32(rotor_position_angle(&drive.rotor.position),
                                 rotor_position_angle(&drive.vector.position));
        expect_next(DRIVE_STATE_IF_RAMP, DRIVE_STATE_HANDOVER);
        expect_next(DRIVE_STATE_HANDOVER, DRIVE_STATE_RUN);
    }
}

TEST(test_a_caught_rotor_is_measured_at_its_first_standstill)
{
    search(FAST_RPM, FAST_RPM);
    ticks(3000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_FALSE(drive.motor.identified);
    run_at(0.0);
    for (uint32_t k = 0U; (k < (2U * PATIENCE_TICKS)) && !drive.motor.identified; k++) {
        tick();
        TEST_ASSERT_TRUE(is_driving(drive.state));
        TEST_ASSERT_TRUE(drive.state != DRIVE_STATE_FLYING_START);
    }
    TEST_ASSERT_TRUE(drive.motor.identified);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(R_TOLERANCE, 1.0, drive.motor.model.resistance_q14 / 16384.0);
}

static void catch_it(void)
{
    search(FAST_RPM, FAST_RPM);
    expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_RUN);
}

/*
 * The converter's half a count is 4 LSB in both axes, 5.7 of the 670 LSB in which a pulse of two
 * ticks ends: each direction is off by 0.0085 rad at most, and each magnitude by as large a share.
 * The rotor turns by 0.63 rad from one to the other: 3.6 % together.
 */
#define PULSE_L_TOLERANCE (0.036)
#define TELLING_GAP (24U) /* pulses */

TEST(test_a_caught_rotor_has_the_inductance_of_its_pulses_until_it_is_measured)
{
    const double file = 0.8; /* of the motor's L */
    int32_t *const emf_current = &cfg.startup.flying_start.emf_current;
    int32_t measured;

    *emf_current = (int32_t)lround(*emf_current / file);
    cfg.startup.flying_start.gap_factor = TELLING_GAP;
    begin();
    catch_it();
    TEST_ASSERT_FALSE(drive.motor.identified);
    TEST_ASSERT_DOUBLE_WITHIN(PULSE_L_TOLERANCE / file, 1.0 / file,
                              drive.motor.model.inductance_q14 / 16384.0);
    TEST_ASSERT_EQUAL_INT32(16384, drive.motor.model.saliency_q14);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, drive.motor.model.resistance_q14 / 16384.0);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);

    begin();
    go_to(DRIVE_STATE_HOLD);
    measured = drive.motor.model.inductance_q14;
    in.command.request = 0U;
    tick();
    catch_it();
    TEST_ASSERT_TRUE(drive.start.flying_start.inductance_q14 > (measured + 2000));
    TEST_ASSERT_EQUAL_INT32(measured, drive.motor.model.inductance_q14);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.motion.speed_loop.halvings);
}

TEST(test_a_caught_rotor_whose_pulses_do_not_tell_has_a_soft_speed_loop)
{
    cfg.startup.flying_start.gap_factor = 1U;
    begin();
    catch_it();
    TEST_ASSERT_EQUAL_INT32(16384, drive.motor.model.inductance_q14);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.motion.speed_loop.halvings);
}

/* ---- the command withdrawn ---- */

/* As soon as each state is entered, and after about half of it. */
TEST(test_a_stop_opens_the_gates_in_its_tick_in_every_state_and_the_next_start_searches_again)
{
    static const uint32_t half[] = {20U, 50U, 2000U, 100U, 400U, 5U, 1000U};

    for (uint32_t k = 0U; k < 14U; k++) {
        const drive_state_t state =
            transitions_state(transitions_number(DRIVE_STATE_FLYING_START) + (k / 2U));
        const bool later = (k % 2U) != 0U;

        begin();
        go_to(state);
        ticks(later ? half[k / 2U] : 0U);
        TEST_ASSERT_TRUE(is_driving(drive.state));
        /* The tick that enters ALIGN has ended the pulses; the first pulse begins a tick later. */
        TEST_ASSERT_TRUE(out.gate_enable || later || (state == DRIVE_STATE_ALIGN) ||
                         (state == DRIVE_STATE_FLYING_START));
        in.command.request = later ? DRIVE_REQUEST_CLEAR : 0U;
        stay_in(DRIVE_STATE_READY, 1U);
        assert_gates_open();
        stay_in(DRIVE_STATE_READY, later ? 0U : 100U);
        assert_gates_open();
        in.command.request = DRIVE_REQUEST_RUN;
        tick();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
        TEST_ASSERT_EQUAL_UINT32(0U, drive.start.attempts);
        TEST_ASSERT_EQUAL_INT32(0, drive.control.current_ref.d);
        TEST_ASSERT_EQUAL_INT32(0, drive.control.current_ref.q);
    }
}

/* ---- faults ---- */

static const struct {
    void (*make)(drive_in_t *frame);
    fault_id_t id;
} FAULTS[] = {
    {make_break, FAULT_BREAK},
    {make_overcurrent, FAULT_OVERCURRENT},
    {make_overvoltage, FAULT_OVERVOLTAGE},
    {make_undervoltage, FAULT_UNDERVOLTAGE},
};

TEST(test_each_fault_opens_the_gates_in_its_tick_in_every_state_of_the_start)
{
    for (uint32_t s = transitions_number(DRIVE_STATE_FLYING_START);
         s <= transitions_number(DRIVE_STATE_RUN); s++) {
        static drive_t entered;
        static drive_in_t frame;

        begin();
        go_to(transitions_state(s));
        entered = drive;
        frame = in;
        for (uint32_t f = 0U; f < 4U; f++) {
            drive = entered;
            in = frame;
            FAULTS[f].make(&in);
            drive_step(&drive, &in, &out);
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            TEST_ASSERT_EQUAL_INT(FAULTS[f].id, drive.fault.id);
            assert_gates_open();
            in = frame;
            drive_step(&drive, &in, &out); /* latched, whatever the command */
            TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
            assert_gates_open();
        }
    }
}

/* Heat found in any tick of the search, also in those in which a pulse flows. */
TEST(test_a_fault_found_during_the_search_opens_the_gates_in_its_tick)
{
    uint32_t in_a_pulse = 0U;

    for (uint32_t phase = 0U; phase < (cfg.slow_ticks * SUPERVISION_STEPS); phase++) {
        setUp();
        cfg.derating.temperature_periods = 0U;
        begin();
        ticks(phase);
        go_to(DRIVE_STATE_FLYING_START);
        in.adc_temperature = 2100U; /* limit 2048 */
        expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_FAULT);
        TEST_ASSERT_EQUAL_INT(FAULT_OVERTEMPERATURE, drive.fault.id);
        TEST_ASSERT_FALSE(out.gate_enable);
        in_a_pulse += drive.start.flying_start.gates ? 1U : 0U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, in_a_pulse);
}

/* ---- a start that fails ---- */

/* A residual of less than 1 LSB is never reached: the observer cannot prove itself. */
static void make_handover_impossible(uint32_t attempts)
{
    cfg.startup.residual_max = 1;
    cfg.startup.handover_periods = 20U;
    cfg.startup.attempts = attempts;
    begin();
    run_at(FAST_RPM);
}

TEST(test_a_start_is_repeated_as_often_as_allowed_and_is_then_a_fault)
{
    for (uint32_t attempts = 1U; attempts <= 3U; attempts++) {
        drive_state_t before = DRIVE_STATE_READY;
        uint32_t starts = 0U;

        make_handover_impossible(attempts);
        for (uint32_t k = 0U;
             (k < (attempts * PATIENCE_TICKS)) && (drive.state != DRIVE_STATE_FAULT); k++) {
            tick();
            TEST_ASSERT_TRUE(drive.state != DRIVE_STATE_RUN);
            if (drive.state == DRIVE_STATE_FLYING_START) { /* the rotor stops when it is let go */
                motor = example_motor_at(motor.angle, 0.0);
                starts += (before != DRIVE_STATE_FLYING_START) ? 1U : 0U;
            }
            before = drive.state;
        }
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(FAULT_STARTUP, drive.fault.id);
        TEST_ASSERT_EQUAL_UINT32(attempts, starts);
        TEST_ASSERT_EQUAL_INT32(1, drive.fault.limit);
        TEST_ASSERT_TRUE(drive.fault.value >= drive.fault.limit);
        assert_gates_open();
    }
}

TEST(test_a_failed_start_stays_latched_and_is_tried_afresh_after_clearing)
{
    make_handover_impossible(1U);
    ticks(PATIENCE_TICKS);
    TEST_ASSERT_EQUAL_INT(FAULT_STARTUP, drive.fault.id);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    in.command.request = DRIVE_REQUEST_CLEAR;
    tick();
    in.command.request = 0U;
    ticks(CALIBRATION_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    run_at(FAST_RPM);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, drive.start.attempts);
}

/*
 * Its first attempt leaves it at 180 rpm: only the observer's proof fails. The tick that repeats a
 * start opens the gates, else the search takes the last current for the rotor's.
 */
TEST(test_a_rotor_that_turns_when_its_start_is_repeated_is_caught)
{
    make_handover_impossible(3U);
    go_to(DRIVE_STATE_HANDOVER);
    expect_next(DRIVE_STATE_HANDOVER, DRIVE_STATE_FLYING_START);
    assert_gates_open();
    expect_next(DRIVE_STATE_FLYING_START, DRIVE_STATE_RUN);
    ticks(15000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    assert_speed(SPEED_TOLERANCE_RPM, FAST_RPM);
}

#define TORN_RPM (300.0) /* 10 turns of the field a second */
/* of the 100 in a turn; the residual falls towards the end of each half */
#define TORN_PERIODS (20U)

/* A load turns the rotor away under the vector; what else would notice that is switched off. */
TEST(test_a_rotor_that_is_torn_from_the_vector_makes_the_start_begin_again)
{
    example_supervise_nothing(&cfg);
    cfg.startup.lost_periods = TORN_PERIODS;
    begin();
    go_to(DRIVE_STATE_HOLD);
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.state == DRIVE_STATE_HOLD); k++) {
        motor.speed = TORN_RPM * RAD_S_PER_RPM;
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_UINT32(1U, drive.start.attempts);
    assert_gates_open();
}

/* Currents of 200 counts that turn by that many steps a tick, through the diodes of open gates. */
static void turn_current(double amplitude_a, double amplitude_b, double speed)
{
    double angle = 0.0;

    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.state != DRIVE_STATE_FAULT); k++) {
        in.adc_ia = (uint16_t)lround((double)MID_COUNTS + (amplitude_a * cos(angle)));
        in.adc_ib = (uint16_t)lround((double)MID_COUNTS + (amplitude_b * cos(angle - 2.0943951)));
        drive_step(&drive, &in, &out);
        TEST_ASSERT_FALSE(out.gate_enable);
        angle += speed / 4294967296.0 * 6.2831853;
    }
}

/* A sensor that stands still looks like a current that never ends. */
TEST(test_a_current_that_does_not_end_with_open_gates_is_a_stuck_sensor)
{
    for (int32_t b = 0; b < 2; b++) {
        setUp();
        run_at(0.0);
        turn_current((b != 0) ? 0.0 : 200.0, (b != 0) ? 400.0 : 0.0, 0.0);
        TEST_ASSERT_EQUAL_INT(FAULT_ADC_STUCK, drive.fault.id);
        TEST_ASSERT_EQUAL_INT32(200 * 8, drive.fault.value);
        TEST_ASSERT_EQUAL_INT32(cfg.startup.flying_start.current / 4, drive.fault.limit);
        TEST_ASSERT_EQUAL_UINT32(CALIBRATION_TICKS + cfg.startup.flying_start.wait_ticks,
                                 drive.fault.tick);
    }
}

/* Its EMF is above this bus, and it is no faster than it may be. */
TEST(test_a_rotor_that_feeds_the_bus_through_open_gates_is_too_fast_for_it)
{
    for (uint32_t share = 4U; share <= 6U; share += 2U) { /* of the limit, tenths */
        double limit;

        setUp();
        run_at(0.0);
        in.adc_bus = (uint16_t)((in.adc_bus * 7U) / 10U);
        drive_step(&drive, &in, &out);
        limit = (drive.bus / sqrt(3.0) / cfg.current_loop.emf_q13) * 8192.0 *
                (double)((uint32_t)1U << cfg.speed_shift);
        TEST_ASSERT_TRUE(limit < cfg.speed_loop.speed_max);
        turn_current(200.0, 200.0, -limit * share / 10.0);
        TEST_ASSERT_EQUAL_INT((share > 5U) ? FAULT_OVERSPEED : FAULT_ADC_STUCK, drive.fault.id);
        if (share > 5U) {
            TEST_ASSERT_DOUBLE_WITHIN(0.001 * limit, limit, drive.fault.limit);
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * limit, limit * share / 10.0, drive.fault.value);
        }
    }
}

/* ---- charge of the bootstrap supplies ---- */

#define CHARGE_TICKS (50U)

static void charge(void)
{
    run_at(0.0);
    for (uint32_t k = 0U;
         (k < PATIENCE_TICKS) && (drive.start.flying_start.phase != FLYING_START_CHARGE); k++) {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
    TEST_ASSERT_EQUAL_INT(FLYING_START_CHARGE, drive.start.flying_start.phase);
}

static void begin_charging(void)
{
    cfg.startup.flying_start.charge_ticks = CHARGE_TICKS;
    begin();
    charge();
}

static void assert_charges_then_aligns(void)
{
    for (uint32_t k = 0U; k < CHARGE_TICKS; k++) {
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FLYING_START, drive.state);
        TEST_ASSERT_TRUE(out.gate_enable);
        for (int32_t p = 0; p < 3; p++) {
            TEST_ASSERT_EQUAL_UINT16(0U, out.compare.phase[p]);
        }
        tick();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_ALIGN, drive.state);
    TEST_ASSERT_FALSE(out.gate_enable);
}

TEST(test_low_sides_alone_are_on_for_the_charge_before_the_first_high_side)
{
    begin_charging();
    assert_charges_then_aligns();
}

TEST(test_a_charge_that_was_stopped_begins_anew_behind_a_new_look)
{
    begin_charging();
    ticks(CHARGE_TICKS - 1U);
    in.command.request = 0U;
    stay_in(DRIVE_STATE_READY, 1U);
    assert_gates_open();
    run_at(0.0);
    ticks(2U);
    TEST_ASSERT_EQUAL_UINT32(1U,
                             drive.start.flying_start.phase); /* nothing flows: the first pulse */
    charge();
    assert_charges_then_aligns();
}

/* Somebody turns the shaft: the shorted windings carry what flows then. */
TEST(test_a_fault_in_the_charge_opens_the_gates_at_once)
{
    for (uint32_t f = 0U; f < 2U; f++) { /* a break, overcurrent */
        setUp();
        begin_charging();
        ticks(CHARGE_TICKS / 2U);
        TEST_ASSERT_TRUE(out.gate_enable);
        FAULTS[f].make(&in);
        drive_step(&drive, &in, &out);
        TEST_ASSERT_EQUAL_INT(FAULTS[f].id, drive.fault.id);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        assert_gates_open();
    }
}

/* ---- any frame ---- */

/* Phases so short that all states are passed often. */
static void hurry(void)
{
    cfg.sampling.offset_log2 = 2U;
    cfg.protection = (protection_cfg_t){12000, 32766, 0, 4375};
    cfg.startup.align.sweep_ticks = 5U;
    cfg.startup.align.sweep_speed = 35791394;
    cfg.startup.align.pull_ticks = 10U;
    cfg.startup.align.settle_ticks = 5U;
    cfg.startup.align.measure_log2 = 6U;
    cfg.startup.ramp = 2000000;
    cfg.startup.residual_max = 8000;
    cfg.startup.residual_lost = 8191;
    cfg.startup.attempts = 100U;
    cfg.speed_loop.ramp = 2000000;
    example_supervise_nothing(&cfg);
}

static void assert_everything_in_range(void)
{
    for (int32_t p = 0; p < 3; p++) {
        TEST_ASSERT_TRUE(out.compare.phase[p] <= cfg.modulator.timer_counts);
    }
    TEST_ASSERT_TRUE(is_driving(drive.state) || !out.gate_enable);
    TEST_ASSERT_TRUE((drive.state >= DRIVE_STATE_INIT) && (drive.state <= DRIVE_STATE_FAULT));
    TEST_ASSERT_TRUE(abs(drive.control.current_ref.d) <= 23171);
    TEST_ASSERT_TRUE(abs(drive.control.current_ref.q) <= 23171);
    TEST_ASSERT_TRUE(abs(drive.rotor.observer.speed) <= cfg.observer.speed_limit);
    TEST_ASSERT_TRUE(abs(drive.rotor.observer.rho_q13) <= cfg.observer.rho_max_q13);
    TEST_ASSERT_TRUE((drive.rotor.residual >= 0) && (drive.rotor.residual <= 16384));
    TEST_ASSERT_TRUE(drive.start.attempts <= cfg.startup.attempts);
}

/* |a|, |b| and |a + b| within ±12000 most of the time: ±700 counts each. */
static void wild_frame(seeded_t *seed, uint32_t k)
{
    static const int32_t targets[] = {INT32_MIN, -3000000, -1, 0, 1, 3000000, INT32_MAX};
    const uint32_t event = seeded_u32(seed) % 5000U;

    in.adc_ia = (uint16_t)((int32_t)MID_COUNTS + (seeded_in(seed, -1, 1) * 700));
    in.adc_ib = (uint16_t)((int32_t)MID_COUNTS + (seeded_in(seed, -1, 1) * 700));
    in.adc_bus = (uint16_t)seeded_in(seed, 0, 4095);
    in.flags = (event == 0U) ? DRIVE_FLAG_BREAK : 0U;
    if ((k % 500U) == 0U) {
        in.command.target = targets[seeded_u32(seed) % 7U];
        in.command.mode = (uint8_t)(seeded_u32(seed) % 3U);
    }
    in.command.request = (event < 5U) ? DRIVE_REQUEST_CLEAR : DRIVE_REQUEST_RUN;
    if ((k % 3000U) < 1500U) { /* calmer currents let the start go on */
        in.adc_ia = (uint16_t)seeded_in(seed, 2040, 2056);
        in.adc_ib = (uint16_t)seeded_in(seed, 2040, 2056);
    }
}

TEST(test_any_frame_keeps_the_start_in_range_and_reaches_every_state)
{
    static drive_t other;
    seeded_t seed = {0x57A47U};
    drive_out_t other_out = {0};
    uint32_t visits[DRIVE_STATES] = {0U};

    cfg = example_drive_cfg_with_startup();
    hurry();
    memset(&drive, 0, sizeof drive);
    memset(&other, 0, sizeof other);
    memset(&out, 0, sizeof out);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    TEST_ASSERT_NULL(drive_init(&other, &cfg));
    for (uint32_t k = 0U; k < 300000U; k++) {
        wild_frame(&seed, k);
        drive_step(&drive, &in, &out);
        drive_step(&other, &in, &other_out);
        assert_everything_in_range();
        TEST_ASSERT_EQUAL_MEMORY(&drive, &other, sizeof drive);
        visits[transitions_number(drive.state)]++;
    }
    for (uint32_t s = 1U; s < DRIVE_STATES; s++) {
        const bool asked = s != transitions_number(DRIVE_STATE_PROBE);
        char text[32];

        (void)snprintf(text, sizeof text, "state %u is reached", (unsigned)s);
        TEST_ASSERT_EQUAL_MESSAGE(asked, visits[s] > 0U, text);
    }
}

/* The largest of everything that config_check accepts. */
TEST(test_any_frame_keeps_the_most_extreme_configuration_in_range)
{
    for (uint32_t run = 0U; run < 20U; run++) {
        seeded_t seed = {0xE17E4U + run};

        cfg = example_drive_cfg_with_startup();
        hurry();
        cfg.speed_shift = 1U + (run % 16U);
        cfg.observer.speed_limit =
            (cfg.speed_shift > 14U) ? 0x20000000 : (32767 << cfg.speed_shift);
        cfg.speed_loop.speed_max = cfg.observer.speed_limit;
        cfg.startup.align.sweep_speed = cfg.observer.speed_limit;
        cfg.current_loop.emf_q13 = ((run % 2U) == 0U) ? 16250 : 0;
        cfg.current_loop.reactance_d_q13 = 16250;
        cfg.current_loop.reactance_q_q13 = 16250;
        cfg.current_loop.resistance_q13 = 32767;
        cfg.hold_loop = cfg.current_loop;
        cfg.startup.flying_start = (flying_start_cfg_t){.current = 1,
                                                        .wait_ticks = 256U,
                                                        .pulse_ticks = 1U + (run % 16U),
                                                        .gap_factor = 1U,
                                                        .pause_max = 256U,
                                                        .emf_current = 1 + (int32_t)(run * 1700U),
                                                        .emf_shift = run,
                                                        .decay_q15 = (int32_t)run * 1700,
                                                        .charge_ticks = run};
        cfg.startup.align.inductance.step_voltage = 32767;
        cfg.startup.align.inductance.pulse_voltage = 32767;
        cfg.startup.handover_speed = 2;
        cfg.startup.track_speed = 1;
        cfg.startup.hold_speed = 1;
        cfg.startup.loaded_speed = 1;
        cfg.startup.current_hold = 16384;
        cfg.startup.current_move = 16384;
        cfg.current_reference.floor = 16384;
        cfg.current_reference.slope = 16384;
        cfg.startup.current_slope = 16384;
        cfg.modulator.dead_time_q15 = 8192;
        cfg.modulator.drop_q15 = 2048;
        cfg.modulator.edge_slope = 32767;
        cfg.model = (model_cfg_t){15000,
                                  8192,
                                  16384,
                                  8192,
                                  32767,
                                  0,
                                  {0x10000000, 15U, 32767, 0},
                                  {0x10000000, 15U, 32767, 16384}};
        cfg.crc = config_guard_crc(&cfg);
        TEST_ASSERT_NULL(drive_init(&drive, &cfg));
        for (uint32_t k = 0U; k < 10000U; k++) {
            wild_frame(&seed, k);
            drive_step(&drive, &in, &out);
            assert_everything_in_range();
        }
    }
}

/* ---- what acts on an imposed current ---- */

#define SUPERVISION_TICKS (cfg.slow_ticks * SUPERVISION_STEPS)

TEST(test_heat_takes_from_an_imposed_current_too)
{
    go_to(DRIVE_STATE_HOLD);
    cfg.derating.current_continuous = cfg.startup.current_hold / 2;
    drive.derating.heat_q24 = (1 << 24) + (1 << 20); /* beyond all derating, below the fault */
    state_guard_keep_heat(&drive.state_guard, &drive.derating);
    cfg.derating.heat_rate = 0;
    cfg.crc = config_guard_crc(&cfg);
    config_guard_reset(&drive.guard);
    state_guard_keep_config(&drive.state_guard, drive.cfg);
    ticks(20U * SUPERVISION_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_EQUAL_INT32(cfg.startup.current_hold / 2, drive.control.current_ref.d);
}

TEST(test_a_winding_at_rest_cools_whatever_the_last_current_was)
{
    for (uint32_t s = transitions_number(DRIVE_STATE_HOLD);
         s <= transitions_number(DRIVE_STATE_RUN); s++) {
        int32_t before;

        setUp();
        go_to(transitions_state(s));
        in.command.request = 0U;
        tick();
        before = drive.derating.heat_q24 = 1 << 24;
        state_guard_keep_heat(&drive.state_guard, &drive.derating);
        ticks(SUPERVISION_TICKS);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
        TEST_ASSERT_LESS_THAN_INT32(before, drive.derating.heat_q24);
    }
}
