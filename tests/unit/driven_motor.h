/* SPDX-License-Identifier: MIT */
/* A drive on the motor and the inverter of example_motor.h. Each test program has one. */
#ifndef DRIVEN_MOTOR_H
#define DRIVEN_MOTOR_H

#include "drive.h"
#include "example_cfg.h"
#include "example_motor.h"

#include "testing.h"

#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))
#define MID_COUNTS (2048U) /* zero current */
#define BUS_COUNTS (2822U) /* 310 V */
#define CALIBRATION_TICKS (256U)
#define STEPS_PER_RPM (14316.56) /* 2 pole pairs, 10 kHz */
#define POLE_PAIRS (2.0)

static drive_cfg_t cfg;
static drive_t drive;
static drive_in_t in;
static drive_out_t out;
static example_motor_t motor;
static double load_nm;
static double sensor_off; /* how far the angle of the sensor is off, electrical, rad */

/* Both currents, and the angle for a drive with a sensor. */
static void measure(void)
{
    const double turns = (motor.angle + sensor_off) / (2.0 * EXAMPLE_PI) / POLE_PAIRS;

    example_motor_measure(&motor, &in);
    in.angle = (uint16_t)((uint32_t)lround((turns - floor(turns)) * 65536.0) & 0xFFFFU);
}

static void tick(void)
{
    measure();
    drive_step(&drive, &in, &out);
    example_motor_tick(&motor, &out, load_nm);
}

static void ticks(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick();
    }
}

/* To READY with `cfg` as it is now. The speed is electrical, in rad/s. */
static void power_on_at(double angle, double speed)
{
    cfg.crc = config_guard_crc(&cfg);
    memset(&drive, 0, sizeof drive);
    TEST_ASSERT_NULL(drive_init(&drive, &cfg));
    in = (drive_in_t){.adc_bus = BUS_COUNTS};
    out = (drive_out_t){.gate_enable = false};
    motor = example_motor_at(angle, speed);
    load_nm = 0.0;
    ticks(CALIBRATION_TICKS + 1U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, drive.state);
}

static inline void power_on(void)
{
    power_on_at(0.0, 0.0);
}

static inline void assert_gates_open(void)
{
    TEST_ASSERT_FALSE(out.gate_enable);
    for (int32_t p = 0; p < 3; p++) {
        TEST_ASSERT_EQUAL_UINT16(4250U, out.compare.phase[p]); /* half of 8500 */
    }
}

#endif
