/* SPDX-License-Identifier: MIT */
/*
 * A drive that is put where it matters: calibrated, just asked to run, on a motor at rest. The
 * motor takes it on from there, or a test puts it into a state at a speed (stand_in()) and has it
 * do one tick or the work of one slot of the slow schedule. Each test program has one.
 */
#ifndef PLACED_DRIVE_H
#define PLACED_DRIVE_H

#include "instant.h"
#include "life.h"
#include "schedule.h"
#include "state_guard.h"

#include "driven_motor.h"

#define HOLD DRIVE_STATE_HOLD
#define IF_RAMP DRIVE_STATE_IF_RAMP
#define HANDOVER DRIVE_STATE_HANDOVER
#define RUN DRIVE_STATE_RUN
#define FAULT DRIVE_STATE_FAULT
#define SEARCH DRIVE_STATE_FLYING_START

#define QUARTER (0x40000000)
#define PATIENCE_TICKS (40000U) /* 4 s: more than any state lasts here */

static instant_t now; /* what slots() measures */
static fault_t fault;

/* With `cfg` as it is now. */
static inline void begin(void)
{
    power_on();
    in.command.request = DRIVE_REQUEST_RUN;
    tick();
    now = (instant_t){.sample = {.bus = drive.bus}};
}

void setUp(void)
{
    cfg = example_drive_cfg_with_startup();
    cfg.modulator = example_modulator_cfg(); /* the inverter of example_motor.h has no dead time */
    begin();
}

static inline void run_to(drive_state_t state, double rpm)
{
    in.command.target = (int32_t)lround(rpm * STEPS_PER_RPM);
    for (uint32_t k = 0U; (k < PATIENCE_TICKS) && (drive.state != state); k++) {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(state, drive.state);
}

/* In this state, with vector, rotor and what is asked of them at this speed. */
static inline void stand_in(drive_state_t state, step_t speed)
{
    drive.state = state;
    drive.limits = protection_limits(&cfg.protection, drive_is_driving(state));
    speed_loop_reset(&drive.motion.speed_loop, speed);
    drive.motion.speed_reference = speed;
    drive.vector.step = speed;
    drive.rotor.observer.speed = speed;
}

static inline void know_motor(bool identified)
{
    drive.motor.identified = identified;
    state_guard_keep_measured(&drive.state_guard, &drive);
}

/* The work of one slot of the slow schedule, so many times, and what follows from it. */
static inline void slots(slot_t slot, uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        const drive_event_t event = schedule_step(&drive, &in, &now, slot, true, &fault);

        life_follow_or_fail(&drive, event, &fault, &now);
    }
}

static inline void slot(slot_t which)
{
    slots(which, 1U);
}

#endif
