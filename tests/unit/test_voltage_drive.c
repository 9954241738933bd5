/* SPDX-License-Identifier: MIT */
/*
 * The voltage drive within the drive: starts, changes over and back without a jump, protection, any
 * frame.
 */
#include "driven_motor.h"
#include "fault_frames.h"
#include "instant.h"
#include "seeded.h"
#include "state_guard.h"
#include "testing.h"
#include "trig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RAD_S_PER_RPM (2.0 * EXAMPLE_PI / 30.0)
#define PATIENCE_TICKS (40000U)
/* 0.6 s of ramp to 600 rpm, the 0.1 s of the change-over, and their transients */
#define SETTLED_TICKS (10000U)

static void loaded_ticks(uint32_t count, double load)
{
    load_nm = load;
    ticks(count);
    load_nm = 0.0;
}

static void begin(double angle, double rpm)
{
    cfg.voltage_drive = example_voltage_drive_cfg();
    example_supervise_nothing(&cfg);
    power_on_at(angle, rpm * RAD_S_PER_RPM);
}

static void begin_with_sensor(double angle, double rpm)
{
    cfg = example_drive_cfg();
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.observer.eta = 0;
    cfg.observer.kappa_p = 0;
    cfg.speed_loop.ramp = 14317; /* 1000 rpm/s: nothing limits the current */
    begin(angle, rpm);
}

static void begin_without_sensor(void)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    cfg.speed_loop.ramp = 14317;
    begin(0.0, 0.0);
}

void setUp(void)
{
    begin_with_sensor(0.0, 0.0);
}

static void run_at(double rpm)
{
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.mode = (uint8_t)DRIVE_MODE_SPEED;
    in.command.target = (int32_t)lround(rpm * STEPS_PER_RPM);
}

static double true_rpm(void)
{
    return motor.speed / RAD_S_PER_RPM;
}

/* θ̂ − θ in degrees, gates open: both are of the last tick. */
static double angle_error(void)
{
    const double estimate = (double)rotor_position_angle(&drive.rotor.position) / 4294967296.0;

    return 360.0 * remainder(estimate - (in.angle * POLE_PAIRS / 65536.0), 1.0);
}

/* ---- with a sensor ---- */

TEST(test_a_sensor_is_followed_in_every_state_from_any_angle)
{
    for (int32_t degrees = -180; degrees < 180; degrees += 20) {
        begin_with_sensor(degrees * EXAMPLE_PI / 180.0, 600.0);
        ticks(200U); /* of half a turn (1 + 14)·e^-14 is left */
        /*
         * The friction of 1 mN·m·s brakes with 42 rad/s², which the loop lags by 0.03°; a step of
         * the sensor is 0.011°.
         */
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, angle_error());
        TEST_ASSERT_DOUBLE_WITHIN(3.0, true_rpm(), drive_speed(&drive) / STEPS_PER_RPM);
    }
}

TEST(test_run_begins_at_once_and_with_current_control)
{
    run_at(600.0);
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_FALSE(out.gate_enable);
    tick();
    TEST_ASSERT_TRUE(out.gate_enable);
}

TEST(test_both_directions_reach_their_speed_without_i_d)
{
    static const double rpm[] = {600.0, -600.0};

    for (uint32_t k = 0U; k < 2U; k++) {
        begin_with_sensor(1.0, 0.0);
        run_at(rpm[k]);
        ticks(25000U); /* 0.6 s of ramp, then 8 time constants of the slowest mode */
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
        TEST_ASSERT_TRUE(drive.voltage_drive.active);
        TEST_ASSERT_DOUBLE_WITHIN(3.0, rpm[k], true_rpm());
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, motor.d); /* two counts of the converter */
    }
}

/* ---- positions with a sensor ---- */

#define SHAFT_TURN_Q32 ((int64_t)POLE_PAIRS << 32)

static double shaft_turns_from_zero(void)
{
    return (double)drive_position_from_zero_q32(&drive) / (double)SHAFT_TURN_Q32;
}

static void hold_at(double turns)
{
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.mode = (uint8_t)DRIVE_MODE_POSITION;
    in.command.target = (int32_t)lround(turns * POLE_PAIRS * 65536.0);
    ticks(20000U);
}

static void stop(void)
{
    in.command.request = 0U;
    ticks(10U);
}

#define SHAFT_TOLERANCE (2.0 / 360.0)

/* Which of its electrical turns the rotor is in the sensor tells. */
TEST(test_positions_count_from_the_zero_of_the_sensor)
{
    begin_with_sensor(1.5 * 2.0 * EXAMPLE_PI, 0.0); /* three quarters of a turn of the shaft */
    ticks(200U);
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, 0.75, shaft_turns_from_zero());
}

TEST(test_a_run_in_position_mode_goes_on_with_the_count_of_the_one_before)
{
    hold_at(5.25);
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, 5.25, shaft_turns_from_zero());
    stop();
    hold_at(5.0);
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, 5.0, shaft_turns_from_zero());
    TEST_ASSERT_EQUAL_INT64(0, drive.motion.position_loop.zero_q32);
}

TEST(test_a_run_in_another_mode_ends_the_count)
{
    hold_at(5.25);
    stop();
    run_at(0.0);
    ticks(100U);
    hold_at(0.0);
    TEST_ASSERT_EQUAL_INT64(5 * SHAFT_TURN_Q32, drive.motion.position_loop.zero_q32);
    stop();
    hold_at(-1.0);
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, -1.0, shaft_turns_from_zero());
    TEST_ASSERT_EQUAL_INT64(5 * SHAFT_TURN_Q32, drive.motion.position_loop.zero_q32);
}

TEST(test_a_zero_at_rest_is_where_the_sensor_sees_the_rotor)
{
    begin_with_sensor(1.0, 0.0);
    ticks(200U);
    in.command.request = DRIVE_REQUEST_ZERO;
    ticks(20U);
    stop();
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, 0.0, shaft_turns_from_zero());
    hold_at(0.0);
    TEST_ASSERT_DOUBLE_WITHIN(SHAFT_TOLERANCE, 1.0 / (2.0 * EXAMPLE_PI * POLE_PAIRS),
                              (double)drive_position_q32(&drive) / (double)SHAFT_TURN_Q32);
}

static void run_with_little_current(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick();
        TEST_ASSERT_TRUE(hypot(motor.d, motor.q) < 1.0);
    }
}

/*
 * One PWM period without voltage lets the EMF drive e·T/L: 0.42 A at 600 rpm, then the EMF is fed
 * forward.
 */
TEST(test_a_turning_rotor_is_taken_as_it_is)
{
    begin_with_sensor(2.0, 600.0);
    run_at(600.0);
    run_with_little_current(3000U);
    TEST_ASSERT_DOUBLE_WITHIN(12.0, 600.0, true_rpm());
}

TEST(test_a_second_run_starts_afresh_where_the_rotor_is)
{
    run_at(600.0);
    ticks(8000U);
    in.command.request = 0U;
    ticks(200U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, angle_error());
    run_at(600.0);
    run_with_little_current(2000U);
}

/* ---- changing over ---- */

/*
 * To the tick that changes over to `driven`, or back; returns how far its voltage jumps, and the
 * next one's.
 */
static int32_t jump_at_change(bool driven)
{
    int32_t largest = 0;
    dq_t before = drive.control.voltage;

    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.voltage_drive.active != driven); k++) {
        before = drive.control.voltage;
        tick();
    }
    TEST_ASSERT_TRUE(drive.voltage_drive.active == driven);
    for (uint32_t k = 0U; k < 3U; k++) {
        const dq_t now = drive.control.voltage;

        largest = fx_max(largest, fx_max(abs(now.d - before.d), abs(now.q - before.q)));
        before = now;
        tick();
    }
    return largest;
}

/*
 * A current loop of 3.24 volts per ampere, per unit, makes 26 LSB of a count of the converter; both
 * axes' noise, twice.
 */
#define JUMP_LSB (110)

TEST(test_without_sensor_the_start_is_as_ever_and_then_the_voltage_goes_on)
{
    begin_without_sensor();
    run_at(600.0);
    while (drive.state != DRIVE_STATE_RUN) {
        TEST_ASSERT_FALSE(drive.voltage_drive.active);
        tick();
    }
    TEST_ASSERT_TRUE(jump_at_change(true) < JUMP_LSB);
    TEST_ASSERT_INT32_WITHIN(255, 0, drive.control.current_ref.d);
    ticks(25000U);
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, true_rpm());
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
}

TEST(test_a_slow_reference_gives_back_to_current_control_which_holds)
{
    begin_without_sensor();
    run_at(600.0);
    ticks(PATIENCE_TICKS);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    run_at(0.0);
    TEST_ASSERT_TRUE(jump_at_change(false) < JUMP_LSB);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    ticks(PATIENCE_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_HOLD, drive.state);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
}

TEST(test_a_position_is_for_current_control_and_a_speed_again_for_the_voltage)
{
    run_at(600.0);
    ticks(10000U);
    in.command.mode = (uint8_t)DRIVE_MODE_POSITION;
    in.command.target = 40 * 65536;
    TEST_ASSERT_TRUE(jump_at_change(false) < JUMP_LSB);
    ticks(PATIENCE_TICKS);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_INT32_WITHIN(655, in.command.target,
                             (int32_t)(drive_position_from_zero_q32(&drive) / 65536));
    run_at(600.0);
    TEST_ASSERT_TRUE(jump_at_change(true) < JUMP_LSB);
}

TEST(test_no_change_before_the_speed_is_reached)
{
    run_at(600.0);
    while (!drive.voltage_drive.active) {
        TEST_ASSERT_TRUE(drive.tick < PATIENCE_TICKS);
        tick();
    }
    /*
     * 1/32 of it may be missing, less what the ramp of 1000 rpm/s has made good in the 0.1 s since.
     */
    TEST_ASSERT_TRUE(true_rpm() > (600.0 * 31.0 / 32.0));
}

static void run_without_it(uint32_t count, double load)
{
    for (uint32_t k = 0U; k < count; k++) {
        loaded_ticks(1U, load);
        TEST_ASSERT_FALSE(drive.voltage_drive.active);
    }
}

TEST(test_below_its_lowest_speed_current_control_stays)
{
    run_at(230.0); /* of 240 */
    run_without_it(PATIENCE_TICKS, 0.0);
}

/* With 1° of lag and hardly any braking current within it. */
TEST(test_a_load_that_drives_is_held_by_current_control)
{
    cfg.voltage_drive.compensator.brake_max = 11930465;
    cfg.crc = config_guard_crc(&cfg);
    run_at(600.0);
    ticks(SETTLED_TICKS);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    loaded_ticks(PATIENCE_TICKS, -3.0);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, true_rpm());
}

/* A least current of 1.22 A; a load takes 1.72 A, and the friction 0.05 A. */
TEST(test_a_current_that_falls_below_its_floor_is_given_back_and_then_kept)
{
    cfg.current_reference.floor = 1000;
    cfg.current_reference.floor_shift = 0U;
    cfg.current_reference.slope = 65;
    cfg.crc = config_guard_crc(&cfg);
    state_guard_keep_config(&drive.state_guard, drive.cfg);
    run_at(600.0);
    loaded_ticks(PATIENCE_TICKS, 2.0);
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
    ticks(PATIENCE_TICKS);
    TEST_ASSERT_FALSE(drive.voltage_drive.active);
    TEST_ASSERT_INT32_WITHIN(100, 1000, drive.control.current_ref.d);
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, true_rpm());
}

/* It takes 4° under 3 N·m. */
TEST(test_a_lead_beyond_its_end_is_left_to_current_control)
{
    cfg.voltage_drive.compensator.lead_max = 11930465; /* 1° */
    cfg.crc = config_guard_crc(&cfg);
    run_at(600.0);
    run_without_it(PATIENCE_TICKS, 3.0);
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, true_rpm());
}

/* Closer than the converter resolves. */
TEST(test_no_change_while_currents_are_not_where_they_are_asked_for)
{
    cfg.voltage_drive.compensator.current_min = 1;
    cfg.crc = config_guard_crc(&cfg);
    run_at(600.0);
    run_without_it(PATIENCE_TICKS, 0.0);
}

TEST(test_more_than_the_torque_range_gives_back_at_once)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin_with_sensor(0.0, 0.0);
        run_at(sign * 600.0);
        ticks(SETTLED_TICKS);
        TEST_ASSERT_TRUE(drive.voltage_drive.active);
        virtual_resistance_start(&drive.voltage_drive.damping,
                                 (dq_t){0, (sign > 0) ? (drive.motion.torque_range.upper + 2000)
                                                      : (drive.motion.torque_range.lower - 2000)});
        ticks(cfg.slow_ticks);
        TEST_ASSERT_FALSE(drive.voltage_drive.active);
    }
}

TEST(test_a_drive_that_is_not_asked_to_never_changes_over)
{
    begin_with_sensor(0.0, 0.0);
    cfg.voltage_drive.enabled = 0U;
    cfg.crc = config_guard_crc(&cfg);
    run_at(600.0);
    run_without_it(10000U, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(6.0, 600.0, true_rpm());
}

/* ---- the virtual resistance ---- */

#define BUMP_COUNTS (51) /* half an ampere */

/* Phase a has half an ampere more. */
static drive_in_t bumped_frame(void)
{
    drive_in_t bumped = in;

    bumped.adc_ia = (uint16_t)(in.adc_ia + BUMP_COUNTS);
    return bumped;
}

/* As the drive turns it. */
static dq_t bumped_current(void)
{
    const drive_in_t bumped = bumped_frame();
    const sample_t sample = instant_sample(&drive, &bumped);

    return transforms_park(transforms_clarke(sample.phase_a, sample.phase_b),
                           trig_sincos(rotor_position_angle(&drive.rotor.position)));
}

/* What the drive makes of that frame with this configuration. */
static drive_t after_a_bump(drive_t from, const drive_cfg_t *with, drive_out_t *applied)
{
    const drive_in_t bumped = bumped_frame();

    from.cfg = with;
    drive_step(&from, &bumped, applied);
    return from;
}

/* The voltage that one frame of this makes with the virtual resistance, and without it. */
typedef struct {
    dq_t current;
    dq_t with;
    dq_t without;
} bumped_t;

static bumped_t after_a_bump_with_and_without(void)
{
    drive_cfg_t bare = cfg;
    drive_t after = after_a_bump(drive, &cfg, &out);
    bumped_t bumped = {.current = bumped_current(), .with = after.control.voltage};

    bare.voltage_drive.damping.resistance_q15 = 0;
    bumped.without = after_a_bump(drive, &bare, &out).control.voltage;
    return bumped;
}

static double length(dq_t vector)
{
    return hypot(vector.d, vector.q);
}

/* Not in the last tick of a slow period, in which the magnitude changes too. */
static void run_loaded_until_settled(void)
{
    run_at(600.0);
    loaded_ticks(PATIENCE_TICKS, 2.0);
    while (drive.slow_count < 3U) {
        loaded_ticks(1U, 2.0);
    }
    measure();
    TEST_ASSERT_TRUE(drive.voltage_drive.active);
}

TEST(test_a_change_of_the_current_meets_the_virtual_resistance)
{
    bumped_t after;
    dq_t change;

    run_loaded_until_settled();
    after = after_a_bump_with_and_without();
    change = virtual_resistance_mean(&drive.voltage_drive.damping);
    change = (dq_t){after.current.d - change.d, after.current.q - change.q};
    TEST_ASSERT_TRUE(length(change) > 350.0); /* of 410 */
    /* R_v·i of 0.175 U_b/I_b, rounded down in both */
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 0.175 * change.d, after.without.d - after.with.d);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 0.175 * change.q, after.without.q - after.with.q);
}

/* What the network is given as the voltage that acts is this ratio, two ticks later. */
TEST(test_the_observer_is_told_of_the_virtual_resistances_part)
{
    const double bus = 310.0 / 450.0;
    drive_t with;
    double ratio;
    double demand;

    run_loaded_until_settled();
    with = after_a_bump(drive, &cfg, &out);
    ratio = hypot(with.control.ratio_next.alpha, with.control.ratio_next.beta);
    demand = length(with.control.voltage);
    /* The reciprocal of the bus is good to 2^-11, the products to an LSB in each axis. */
    TEST_ASSERT_DOUBLE_WITHIN((demand / bus / 2048.0) + 3.0, demand / bus, ratio);
    drive = with;
    drive_step(&drive, &in, &out);
    TEST_ASSERT_EQUAL_INT32(with.control.ratio_next.alpha, drive.control.ratio_acting.alpha);
    TEST_ASSERT_EQUAL_INT32(with.control.ratio_next.beta, drive.control.ratio_acting.beta);
}

/* At the end of the voltage it is U that gives way: a vector that is cut off would not damp. */
TEST(test_the_magnitude_leaves_room_for_the_virtual_resistance)
{
    bumped_t after;
    int32_t limit;

    run_loaded_until_settled();
    drive.voltage_drive.magnitude = FX_Q15_MAX;
    limit = modulator_limit(&cfg.modulator, drive.bus);
    after = after_a_bump_with_and_without();
    TEST_ASSERT_DOUBLE_WITHIN(2.0, limit, length(after.without));
    TEST_ASSERT_TRUE(length(after.with) <= (limit + 2.0));
    TEST_ASSERT_TRUE(length(after.with) > (limit - (2.0 * 0.175 * 1.42 * 420.0)));
    for (int32_t sign = -1; sign <= 1; sign += 2) { /* with the voltage and against it */
        virtual_resistance_start(&drive.voltage_drive.damping, (dq_t){0, sign * 4000});
        after = after_a_bump_with_and_without();
        TEST_ASSERT_TRUE(length(after.with) <= (limit + 2.0));
    }
}

/* A mean would follow the currents' own mode late, and feed it. */
TEST(test_the_dead_time_is_compensated_by_the_current_of_the_tick)
{
    drive_t other;
    drive_out_t expected;
    drive_out_t compensated;

    run_loaded_until_settled();
    cfg.modulator = example_modulator_cfg_with_dead_time(); /* that inverter has none */
    drive.modulator.dead_time_q15 = cfg.modulator.dead_time_q15;
    cfg.voltage_drive.damping.resistance_q15 = 0; /* what the mean is for beside */
    other = drive;
    virtual_resistance_start(&other.voltage_drive.damping, (dq_t){-3000, -3000});
    (void)after_a_bump(drive, &cfg, &expected);
    (void)after_a_bump(other, &cfg, &compensated);
    for (uint32_t k = 0U; k < 3U; k++) {
        TEST_ASSERT_EQUAL_UINT16(expected.compare.phase[k], compensated.compare.phase[k]);
    }
    in.adc_ia = (uint16_t)(MID_COUNTS - (in.adc_ia - MID_COUNTS));
    in.adc_ib = (uint16_t)(MID_COUNTS - (in.adc_ib - MID_COUNTS));
    (void)after_a_bump(drive, &cfg, &compensated);
    TEST_ASSERT_TRUE(abs(compensated.compare.phase[0] - expected.compare.phase[0]) > 100);
}

/* ---- protection ---- */

TEST(test_protection_stays_in_force)
{
    for (uint32_t k = 0U; k < COUNT(FAULT_FRAMES); k++) {
        begin_with_sensor(0.0, 0.0);
        run_at(600.0);
        ticks(SETTLED_TICKS);
        TEST_ASSERT_TRUE(drive.voltage_drive.active);
        measure();
        FAULT_FRAMES[k].make(&in);
        drive_step(&drive, &in, &out);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        TEST_ASSERT_EQUAL_INT(FAULT_FRAMES[k].id, drive.fault.id);
        TEST_ASSERT_FALSE(out.gate_enable);
    }
}

TEST(test_the_voltage_stays_within_the_circle_whatever_the_frame)
{
    seeded_t seeded = {3U};

    for (uint32_t run = 0U; run < 200U; run++) {
        begin_with_sensor(0.0, 0.0);
        run_at(600.0);
        tick();
        for (uint32_t k = 0U; k < 200U; k++) {
            const dq_t *const v = &drive.control.voltage;

            in.adc_ia = (uint16_t)seeded_in(&seeded, 300, 3800);
            in.adc_ib = (uint16_t)seeded_in(&seeded, 300, 3800);
            in.adc_bus = (uint16_t)seeded_in(&seeded, 1900, 3600);
            in.angle = (uint16_t)seeded_u32(&seeded);
            in.command.target = seeded_i32(&seeded);
            in.command.request = DRIVE_REQUEST_RUN;
            drive_step(&drive, &in, &out);
            if (drive.voltage_drive.active && (drive.state == DRIVE_STATE_RUN)) {
                /* two parts, both rounded down */
                const int32_t limit = modulator_limit(&cfg.modulator, drive.bus) + 1;

                TEST_ASSERT_TRUE(length(*v) <= (limit + 1.0));
            }
        }
    }
}
