/* SPDX-License-Identifier: MIT */
/* A drive with a sensor of the shaft and an observer: which of both it takes over from the other.
 */
#include "driven_motor.h"
#include "estimate.h"
#include "shaft_trouble.h"
#include "testing.h"

#include <math.h>
#include <stdio.h>

#define RPM(rpm) ((step_t)lround((rpm) * STEPS_PER_RPM))
#define DEGREES(deg) ((deg) * EXAMPLE_PI / 180.0)
#define FAST_RPM (600.0)
#define ABOVE_RPM (400.0)   /* the observer takes over */
#define BELOW_RPM (300.0)   /* the sensor takes over again */
#define BETWEEN_RPM (250.0) /* below both, above the hand-over at 180 rpm */
#define SLOW_RPM (60.0)     /* below the hand-over */
#define SECOND (10000U)

static void run_at(double rpm)
{
    in.command.request = DRIVE_REQUEST_RUN;
    in.command.target = RPM(rpm);
}

/* At FAST_RPM, after a start with the sensor. */
static void begin_with(sensor_kind_t kind, step_t above, step_t below)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.sensor.kind = (uint32_t)kind;
    cfg.sensor.observer_above = above;
    cfg.sensor.sensor_below = below;
    sensor_off = 0.0;
    power_on();
    run_at(FAST_RPM);
    ticks(SECOND);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_FALSE(drive.rotor.failed);
}

/* By the observer. */
static void begin_fast(sensor_kind_t kind)
{
    begin_with(kind, RPM(ABOVE_RPM), RPM(BELOW_RPM));
    TEST_ASSERT_EQUAL_UINT8(ESTIMATE_OBSERVER, drive.rotor.source);
}

/* How far θ̂ is off, rad. */
static double error_of_angle(void)
{
    const double estimate =
        (double)drive.rotor.position.turns_q32 / 4294967296.0 * 2.0 * EXAMPLE_PI;

    return fabs(remainder(estimate - motor.angle, 2.0 * EXAMPLE_PI));
}

/*
 * Beyond 90° the torque would turn round. An observer that decelerates is off by much less than
 * half of that.
 */
static void assert_held(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick();
        TEST_ASSERT_EQUAL_UINT8(ESTIMATE_OBSERVER, drive.rotor.source);
        TEST_ASSERT_NOT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
        if (drive.state == DRIVE_STATE_RUN) {
            TEST_ASSERT_LESS_THAN_INT32(45, (int32_t)(error_of_angle() * 180.0 / EXAMPLE_PI));
        }
    }
}

TEST(test_a_sensor_that_is_half_a_turn_off_does_not_take_over_and_the_motor_slows_down_without_it)
{
    static const sensor_kind_t kinds[] = {SENSOR_KIND_NONE, SENSOR_KIND_HALL, SENSOR_KIND_ABSOLUTE};

    for (uint32_t k = 0U; k < COUNT(kinds); k++) {
        begin_fast(kinds[k]);
        sensor_off = EXAMPLE_PI;
        ticks(1000U); /* the tracking loop follows */
        TEST_ASSERT_FALSE(drive.rotor.failed);
        run_at(BETWEEN_RPM);
        assert_held(SECOND);
        TEST_ASSERT_TRUE(drive.rotor.failed);
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
        TEST_ASSERT_INT32_WITHIN(RPM(5.0), RPM(BETWEEN_RPM), drive_speed(&drive));
        run_at(SLOW_RPM);
        assert_held(2U * SECOND);
        TEST_ASSERT_TRUE(drive_is_imposed(drive.state));
        TEST_ASSERT_INT32_WITHIN(20, (int32_t)SLOW_RPM,
                                 (int32_t)(motor.speed / POLE_PAIRS * 30.0 / EXAMPLE_PI));
    }
}

TEST(test_a_sensor_takes_over_up_to_an_eighth_of_a_turn_off_and_hall_signals_half_a_sector_more)
{
    /* some degrees from the limit, because the observer is off by one or two itself */
    static const struct {
        sensor_kind_t kind;
        double off_deg;
        estimate_source_t source;
    } rows[] = {
        {SENSOR_KIND_ABSOLUTE, 40.0, ESTIMATE_SENSOR},
        {SENSOR_KIND_ABSOLUTE, 50.0, ESTIMATE_OBSERVER},
        {SENSOR_KIND_HALL, 70.0, ESTIMATE_SENSOR},
        {SENSOR_KIND_HALL, 80.0, ESTIMATE_OBSERVER},
    };

    for (uint32_t k = 0U; k < COUNT(rows); k++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            begin_fast(rows[k].kind);
            sensor_off = (double)sign * DEGREES(rows[k].off_deg);
            ticks(1000U);
            run_at(BETWEEN_RPM);
            for (uint32_t n = 0U; (n < SECOND) && (fx_abs(drive_speed(&drive)) > RPM(BELOW_RPM));
                 n++) {
                tick();
            }
            ticks(2U);
            TEST_ASSERT_EQUAL_UINT8(rows[k].source, drive.rotor.source);
            TEST_ASSERT_EQUAL_INT(rows[k].source == ESTIMATE_OBSERVER, drive.rotor.failed);
        }
    }
}

/* The drive goes on where it has been: no fault, no other source. */
TEST(test_a_sensor_that_dies_at_speed_leaves_the_motor_to_the_observer_down_to_an_imposed_current)
{
    begin_fast(SENSOR_KIND_ABSOLUTE);
    in.flags = DRIVE_FLAG_NO_ANGLE;
    run_at(SLOW_RPM);
    assert_held(3U * SECOND);
    TEST_ASSERT_TRUE(drive_is_imposed(drive.state));
}

/* Slow, by the sensor, after a start with the sensor. */
static void begin_slow(void)
{
    begin_fast(SENSOR_KIND_ABSOLUTE);
    run_at(SLOW_RPM);
    ticks(2U * SECOND);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_EQUAL_UINT8(ESTIMATE_SENSOR, drive.rotor.source);
}

TEST(test_a_sensor_that_dies_below_the_hand_over_leaves_the_motor_to_an_imposed_current)
{
    begin_slow();
    in.flags = DRIVE_FLAG_NO_ANGLE;
    tick();
    TEST_ASSERT_TRUE(drive_is_imposed(drive.state));
    assert_held(SECOND);
    TEST_ASSERT_INT32_WITHIN(20, (int32_t)SLOW_RPM,
                             (int32_t)(motor.speed / POLE_PAIRS * 30.0 / EXAMPLE_PI));
}

/* The observer begins with the angle of the sensor, so it cannot hold such a rotor. */
TEST(test_a_fast_rotor_whose_sensor_was_turned_stops_with_the_sensors_fault)
{
    begin_with(SENSOR_KIND_ABSOLUTE, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(ESTIMATE_SENSOR, drive.rotor.source);
    drive.rotor.failed = true; /* as doubt_sensor() tells; it goes on to tell an angle */
    tick();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_ANGLE_SENSOR, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(SHAFT_TROUBLE_TURNED, drive.fault.value);
}

/* A drive without a start-up needs the angle of its sensor from the start on. */
static void assert_start_fails(uint16_t trouble, shaft_trouble_t named)
{
    cfg = example_drive_cfg();
    cfg.observer.eta = 0; /* an observer beside a sensor has a start-up */
    cfg.observer.kappa_p = 0;
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.sensor.kind = (uint32_t)SENSOR_KIND_ABSOLUTE;
    sensor_off = 0.0;
    power_on();
    in.flags = (uint16_t)(DRIVE_FLAG_NO_ANGLE | ((uint32_t)trouble << DRIVE_TROUBLE_SHIFT));
    run_at(SLOW_RPM);
    ticks(2U * cfg.slow_ticks);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_ANGLE_SENSOR, drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(named, drive.fault.value);
}

TEST(test_a_start_without_the_angle_of_the_only_sensor_fails_and_says_why_the_angle_is_missing)
{
    assert_start_fails(SHAFT_TROUBLE_FRAME, SHAFT_TROUBLE_FRAME);
    assert_start_fails(0U, SHAFT_TROUBLE_COUNTS);
}

static void know_sensor(bool followed, bool aligned, bool failed)
{
    drive.rotor.followed = followed;
    drive.rotor.aligned = aligned;
    drive.rotor.failed = failed;
}

TEST(test_a_sensor_is_taken_after_an_alignment_only_if_it_tells_a_known_angle_and_has_not_failed)
{
    begin_fast(SENSOR_KIND_NONE);
    for (uint32_t k = 0U; k < 8U; k++) {
        know_sensor((k & 1U) != 0U, (k & 2U) != 0U, (k & 4U) != 0U);
        TEST_ASSERT_EQUAL(k == 3U, estimate_may_take_sensor(&drive));
    }
    cfg.sampling.sensor_pole_pairs = 0U;
    know_sensor(true, true, false);
    TEST_ASSERT_FALSE(estimate_may_take_sensor(&drive));
}

/* An alignment finds the zero of an encoder; that of an absolute sensor is known. */
TEST(test_an_alignment_tells_the_zero_of_an_encoder_that_is_followed_and_of_nothing_else)
{
    static const sensor_kind_t kinds[] = {SENSOR_KIND_ENCODER, SENSOR_KIND_ABSOLUTE};

    begin_fast(SENSOR_KIND_ABSOLUTE);
    for (uint32_t k = 0U; k < COUNT(kinds); k++) {
        for (int32_t followed = 0; followed < 2; followed++) {
            cfg.sensor.kind = (uint32_t)kinds[k];
            know_sensor(followed != 0, false, false);
            estimate_align_sensor(&drive.rotor, &drive);
            TEST_ASSERT_EQUAL((k == 0U) && (followed != 0), drive.rotor.aligned);
        }
    }
}

/* The speed of a sensor is that of the rotor, and not that of the vector. */
TEST(test_an_imposed_vector_does_not_tell_the_speed_of_a_drive_whose_sensor_does)
{
    begin_slow();
    drive.vector.step = 7 * RPM(SLOW_RPM);
    estimate_follow(&drive.rotor, &drive);
    TEST_ASSERT_INT32_WITHIN(RPM(10.0), RPM(SLOW_RPM), drive.rotor.observer.speed);
    drive.rotor.source = (uint8_t)ESTIMATE_OBSERVER;
    estimate_follow(&drive.rotor, &drive);
    TEST_ASSERT_EQUAL_INT32(7 * RPM(SLOW_RPM), drive.rotor.observer.speed);
}
