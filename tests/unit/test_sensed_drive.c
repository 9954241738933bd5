/* SPDX-License-Identifier: MIT */
/* A drive with a sensor of the shaft and an observer: which of both it takes over from the other.
 */
#include "driven_motor.h"
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

/* At FAST_RPM by the observer, after a start with the sensor. */
static void begin_fast(sensor_kind_t kind)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    cfg.sampling.sensor_pole_pairs = 2U;
    cfg.sensor.kind = (uint32_t)kind;
    cfg.sensor.observer_above = RPM(ABOVE_RPM);
    cfg.sensor.sensor_below = RPM(BELOW_RPM);
    sensor_off = 0.0;
    power_on();
    run_at(FAST_RPM);
    ticks(SECOND);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, drive.state);
    TEST_ASSERT_EQUAL_UINT8(ESTIMATE_OBSERVER, drive.rotor.source);
    TEST_ASSERT_FALSE(drive.rotor.failed);
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
