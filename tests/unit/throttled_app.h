/* SPDX-License-Identifier: MIT */
/*
 * The application with an input, on the binding of memory of example_app.h: the drive of these
 * tests does at once what it is asked, and its motor follows the target by RATE in a tick. Ticks
 * are 100 µs long.
 */
#ifndef THROTTLED_APP_H
#define THROTTLED_APP_H

#include "commander.h"
#include "config_check.h"
#include "example_app.h"
#include "input.h"

#define TICK_UNITS (HAL_PULSE_HZ / 10000U) /* of the time of pulses */
#define ARM (5000U)                        /* ticks of example_input_cfg() */
#define TIMEOUT (1000U)
#define RATE (100000)      /* of speed_max, 28633115, in a tick: 29 ms from standstill */
#define REST_COUNT (2048U) /* of the potentiometer of example_input_cfg(): its middle */
#define HALF_COUNT (3000U) /* 51.6 % of the upper side, less the dead band: 50 % */
#define STOP_TICKS (3000U) /* from half of the demand to open gates */

static live_config_t live;
static identify_t identify;
static input_t input;
static const char *lost; /* the last reason that the input has told */
static step_t speed;
static uint32_t converts_each; /* so many ticks lie between conversions; begin_with() sets 1 */

/* What the drive makes of the command, and one pass of the background. */
static void pass(void)
{
    const drive_command_t asked = command_mailbox_take(&app.mailbox);
    const bool runs = (asked.request & DRIVE_REQUEST_RUN) != 0U;
    const char *why = NULL;

    if (app.drive.state != DRIVE_STATE_FAULT) {
        app.drive.state = runs ? DRIVE_STATE_RUN : DRIVE_STATE_READY;
    } else if (asked.request == DRIVE_REQUEST_CLEAR) {
        app.drive.state = DRIVE_STATE_READY;
    } else {
        /* the fault is latched */
    }
    speed = fx_towards(
        speed, (runs && (asked.mode == (uint8_t)DRIVE_MODE_SPEED)) ? asked.target : 0, RATE);
    app.drive.rotor.observer.speed = speed;
    hardware.ticks++;
    hardware.now += TICK_UNITS;
    if ((hardware.ticks % converts_each) == 0U) {
        hardware.inputs.conversions++;
    }
    commander_step(&app);
    why = input_step(&input, &live, &identify, hardware.ticks);
    lost = (why == NULL) ? lost : why;
}

static inline void passes(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        pass();
    }
}

/* Power-up with these settings of the input. */
static void begin_with(const input_cfg_t *settings)
{
    power_on();
    cfg.input = *settings;
    cfg.crc = config_guard_crc(&cfg);
    TEST_ASSERT_NULL(config_check(&cfg));
    live = (live_config_t){.app = &app, .hal = &hardware, .about = ABOUT};
    live.in_force = &live.other;
    live.other.cfg = cfg;
    app.drive.state = DRIVE_STATE_READY;
    identify_init(&identify, &app, &ABOUT);
    input_init(&input);
    lost = NULL;
    speed = 0;
    converts_each = 1U;
}

static inline bool runs(void)
{
    return (command_mailbox_take(&app.mailbox).request & DRIVE_REQUEST_RUN) != 0U;
}

static inline int32_t target(void)
{
    return command_mailbox_take(&app.mailbox).target;
}

#endif
