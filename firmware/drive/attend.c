/* SPDX-License-Identifier: MIT */
#include "attend.h"

#include "calibration.h"
#include "estimate.h"
#include "inlining.h"
#include "life.h"
#include "monitor.h"
#include "open_loop.h"
#include "probing.h"
#include "run.h"
#include "state_guard.h"
#include "transitions.h"

/* Counts a late tick. Zero voltage acts in place of its demand. */
static void count_late(drive_t *drive, sample_t sample)
{
    fault_t fault = {.id = FAULT_NONE};
    const fault_id_t id =
        supervision_count_late(&drive->watch.supervision, &drive->cfg->supervision, &fault);

    drive->control.ratio_next = (ab_t){0, 0};
    if ((id != FAULT_NONE) && drive_is_driving(drive->state)) {
        life_fail(drive, &fault, &sample);
    }
}

/*
 * Checks the samples of this tick against the limits of this state. If a current sample is at an
 * end of the converter's range, an over-current is reported as ADC_SATURATED.
 */
static void watch(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    fault_t fault;
    const fault_id_t id = protection_check(&drive->limits, &sample, &fault);

    if (id != FAULT_NONE) {
        if ((id == FAULT_OVERCURRENT) && monitor_is_saturated(drive, in)) {
            fault.id = FAULT_ADC_SATURATED;
        }
        life_fail(drive, &fault, &sample);
    }
}

/* Resets the counts and means of the checks, and the number of failed starts. */
static void forget_last_run(drive_t *drive)
{
    drive->start.attempts = 0U;
    supervision_reset(&drive->watch.supervision);
    oscillation_reset(&drive->watch.oscillation);
}

static drive_event_t start(drive_t *drive)
{
    drive_event_t event = DRIVE_EVENT_TRACKED;

    forget_last_run(drive);
    speed_loop_restore(&drive->motion.speed_loop);
    if (drive_has_sensor(drive)) {
        run_reset_sensed(drive);
    } else if (drive->cfg->startup.current_hold == 0) {
        run_reset(drive);
    } else {
        event = open_loop_start(drive);
    }
    return event;
}

static drive_event_t obey_when_ready(drive_t *drive, uint8_t request)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if ((request & DRIVE_REQUEST_RUN) != 0U) {
        event = start(drive);
    } else if ((request & DRIVE_REQUEST_PROBE) != 0U) {
        forget_last_run(drive);
        event = probing_start(drive);
    } else {
        /* stay */
    }
    return event;
}

/* Obeys the command, or runs the calibration, while nothing is driven. */
static drive_event_t obey_at_rest(drive_t *drive, const drive_in_t *in, bool run, fault_t *fault)
{
    const bool clear = (in->command.request & DRIVE_REQUEST_CLEAR) != 0U;
    drive_event_t event;

    switch (drive->state) {
    case DRIVE_STATE_OFFSET_CAL:
        event = calibration_step(drive, in, fault);
        break;
    case DRIVE_STATE_READY:
        event = obey_when_ready(drive, in->command.request);
        break;
    case DRIVE_STATE_FAULT:
        event = (clear && !run) ? calibration_begin(drive) : DRIVE_EVENT_NONE;
        break;
    default: /* INIT */
        event = calibration_begin(drive);
        break;
    }
    return event;
}

/*
 * Obeys the command. While the safe state shorts the motor, a current flows, so nothing may begin.
 */
static void obey(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const bool shorted = safe_state_is_short(&drive->safe_state);
    const bool driving = drive_is_driving(drive->state);
    const bool run = (in->command.request & DRIVE_REQUEST_RUN) != 0U;
    const uint8_t level =
        (drive->state == DRIVE_STATE_PROBE) ? DRIVE_REQUEST_PROBE : DRIVE_REQUEST_RUN;
    const bool goes_on = (in->command.request & level) != 0U;

    if (!driving && !shorted) {
        fault_t fault;

        fault_clear(&fault);
        life_follow_or_fail(drive, obey_at_rest(drive, in, run, &fault), &fault, &sample);
    } else if (driving && !goes_on) {
        life_follow(drive, DRIVE_EVENT_STOP);
    } else {
        /* go on */
    }
}

bool attend_is_ordinary(const drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const uint32_t word = ((uint32_t)in->flags << 8U) | in->command.request;

    return (drive->state == DRIVE_STATE_RUN) && !drive_has_sensor(drive) &&
           (word == DRIVE_REQUEST_RUN) && protection_holds(&drive->limits, sample);
}

/*
 * Goes to FAULT with a fault that the background has found. Ignores a mode that is not a fault id.
 */
static void fail_as_told(drive_t *drive, const drive_command_t *command, sample_t sample)
{
    const uint32_t numbers = fx_unsigned(command->target);
    const uint32_t value = numbers & 0xFFFFU;
    const uint32_t limit = numbers >> 16U;

    if ((command->mode > (uint8_t)FAULT_NONE) && (command->mode < (uint8_t)FAULT_COUNT)) {
        const fault_t fault = {
            .id = (fault_id_t)command->mode, .value = (int32_t)value, .limit = (int32_t)limit};

        life_fail(drive, &fault, &sample);
    }
}

/* Goes to FAULT: a bit of drive->state has flipped, and its code is not a state. */
RARE static void reject_state(drive_t *drive, sample_t sample)
{
    const uint32_t code = (uint32_t)STATE_GUARD_STATE + (uint32_t)drive->state;
    const fault_t fault = {.id = FAULT_MEMORY, .value = fx_signed(code), .limit = 0};

    life_fail(drive, &fault, &sample);
}

bool attend_step(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const bool controlled = drive_is_controlled(drive->state);

    if (!transitions_is_state(drive->state)) {
        reject_state(drive, sample);
    }
    if (drive_has_sensor(drive)) {
        estimate_sense(drive, in->angle);
    }
    if (in->command.request == DRIVE_REQUEST_FAIL) {
        fail_as_told(drive, &in->command, sample);
    }
    /* FAIL replaces the request RUN. So without a valid fault id the run ends as by a stop. */
    obey(drive, in, sample);
    if (((in->command.request & DRIVE_REQUEST_ZERO) != 0U) && drive_knows_rotor(drive)) {
        run_set_zero(drive);
    }
    /*
     * Check this before the currents: a fault of the currents that late ticks cause is to be
     * reported as LATE.
     */
    if ((in->flags & DRIVE_FLAG_LATE) != 0U) {
        count_late(drive, sample);
    }
    if ((in->flags & DRIVE_FLAG_BREAK) != 0U) {
        const fault_t fault = protection_break(&sample);

        life_fail(drive, &fault, &sample);
        safe_state_break(&drive->safe_state);
    }
    watch(drive, in, sample);
    return controlled && drive_is_controlled(drive->state);
}
