/* SPDX-License-Identifier: MIT */
/*
 * The application on a binding of memory: example_cfg.h measures what `measured` says,
 * `hardware.health`, `.inputs`, `.shaft` and `.now` are the binding's, and `.pulses` are the pulses
 * that have ended and were not fetched. Each test program has one.
 */
#ifndef EXAMPLE_APP_H
#define EXAMPLE_APP_H

#include "about.h"
#include "app.h"
#include "example_cfg.h"

#include "testing.h"

#define EXAMPLE_MIDDLE (2048U)           /* counts without current */
#define EXAMPLE_BUS_COUNT (2822U)        /* 310 V of 450 V */
#define EXAMPLE_CALIBRATION_TICKS (260U) /* 256 samples and the changes of state */
#define EXAMPLE_PULSES (64U)             /* that the binding holds */
#define EXAMPLE_SPEED_STEP (28633115)    /* of 2000 rpm: 28633115.3 */

struct hal {
    uint32_t ticks;
    hal_health_t health;
    uint32_t kept[HAL_KEPT_WORDS];
    hal_reset_t reset;
    hal_inputs_t inputs;
    hal_shaft_t shaft;
    uint32_t now; /* time, in 1/HAL_PULSE_HZ */
    hal_pulse_t pulses[EXAMPLE_PULSES];
    uint32_t pulse_first;
    uint32_t pulse_end; /* index behind the last pulse */
};

/* The scales of example_cfg.h on its motor. */
static const about_t ABOUT = {
    .name = "a board",
    .rotation = {.pole_pairs = 2U, .tick_ps = 100000000U},
    .speed_max_rpm = 2000,
    .current_zero_count = EXAMPLE_MIDDLE,
    .current_full_scale_ua = 20000000U,
    .bus_full_scale_uv = 450000000U,
    .temperature = {.points = 2U, .at = {{0, -50000}, {4096, 150000}}},
};

static drive_in_t measured;
static drive_cfg_t cfg;
static app_t app;
static hal_t hardware;
static bool interrupted; /* a control interrupt comes while the background asks for the health */

void hal_sample(hal_t *hal, drive_in_t *in)
{
    const drive_command_t command = in->command;

    (void)hal;
    *in = measured;
    in->command = command;
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    (void)out;
    hal->ticks++;
}

void hal_open_gates(hal_t *hal)
{
    (void)hal;
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}

hal_health_t hal_health(const hal_t *hal)
{
    if (interrupted) {
        control_isr(&app);
    }
    return hal->health;
}

hal_shaft_t hal_shaft(hal_t *hal)
{
    const hal_shaft_t shaft = hal->shaft;

    hal->shaft.indexed = false;
    return shaft;
}

bool hal_pulse(hal_t *hal, hal_pulse_t *pulse)
{
    const bool there = hal->pulse_first != hal->pulse_end;

    if (there) {
        *pulse = hal->pulses[hal->pulse_first % EXAMPLE_PULSES];
        hal->pulse_first++;
    }
    return there;
}

uint32_t hal_pulse_now(const hal_t *hal)
{
    return hal->now;
}

hal_inputs_t hal_inputs(const hal_t *hal)
{
    return hal->inputs;
}

void hal_keep(hal_t *hal, uint32_t index, uint32_t word)
{
    hal->kept[index] = word;
}

uint32_t hal_kept(const hal_t *hal, uint32_t index)
{
    return hal->kept[index];
}

hal_reset_t hal_reset(const hal_t *hal)
{
    return hal->reset;
}

static void tick(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        control_isr(&app);
    }
}

/* So long that the drive has taken the command. */
static inline void tick_period(void)
{
    tick(cfg.slow_ticks);
}

static void power_on(void)
{
    cfg = example_drive_cfg();
    hardware = (hal_t){.health.adc_ic = EXAMPLE_MIDDLE, .inputs = {.throttle = HAL_NO_THROTTLE}};
    interrupted = false;
    measured = (drive_in_t){
        .adc_ia = EXAMPLE_MIDDLE, .adc_ib = EXAMPLE_MIDDLE, .adc_bus = EXAMPLE_BUS_COUNT};
    TEST_ASSERT_NULL(app_init(&app, &hardware, &cfg));
}

static inline void calibrate(void)
{
    tick(EXAMPLE_CALIBRATION_TICKS);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

static inline void fail(void)
{
    measured.flags = DRIVE_FLAG_BREAK;
    tick(1U);
    measured.flags = 0U;
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
}

#endif
