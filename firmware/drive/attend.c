/* SPDX-License-Identifier: MIT */
#include "attend.h"

#include "calibration.h"
#include "estimate.h"
#include "frame.h"
#include "inlining.h"
#include "life.h"
#include "monitor.h"
#include "run.h"
#include "state_guard.h"
#include "trig.h"

/*
 * Checks the samples of this tick against the limits of this state. If a current sample is at an
 * end of the converter's range, an over-current is reported as ADC_SATURATED.
 */
static fault_id_t check_samples(const drive_t *drive, const drive_in_t *in, sample_t sample,
                                fault_t *fault)
{
    fault_id_t id = protection_check(&drive->limits, &sample, fault);

    if ((id == FAULT_OVERCURRENT) && monitor_is_saturated(drive, in)) {
        id = FAULT_ADC_SATURATED;
        fault->id = id;
    }
    return id;
}

/* Whether the sensor has failed though it tells an angle that can be followed. */
static bool is_sensor_turned(const rotor_t *rotor)
{
    return rotor->failed && rotor->followed;
}

/* Returns the fault of a sensor that has failed; value: why, a shaft_trouble_t. */
static fault_t sensor_fault(const drive_t *drive, const drive_in_t *in)
{
    uint32_t trouble = ((uint32_t)in->flags >> DRIVE_TROUBLE_SHIFT) & DRIVE_TROUBLE_MASK;

    if (is_sensor_turned(&drive->rotor)) {
        trouble = (uint32_t)SHAFT_TROUBLE_TURNED;
    } else if (trouble == 0U) {
        trouble = (uint32_t)SHAFT_TROUBLE_COUNTS;
    } else {
        /* the decoder has told it */
    }
    return (fault_t){.id = FAULT_ANGLE_SENSOR, .value = fx_signed(trouble), .limit = 0};
}

/*
 * A start without the angle of a sensor needs a start-up, which a drive with a sensor may not have.
 */
static drive_event_t start_run(const drive_t *drive, const drive_in_t *in, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_TRACKED;

    if (drive_may_impose(drive)) {
        event = DRIVE_EVENT_SEARCH;
    } else if (drive_has_sensor(drive) && !drive_is_sensed(drive)) {
        event = DRIVE_EVENT_FAULT;
        *fault = sensor_fault(drive, in);
    } else {
        /* the rotor is known, or taken to be at angle 0 */
    }
    return event;
}

static drive_event_t obey_when_ready(const drive_t *drive, const drive_in_t *in, fault_t *fault)
{
    const uint8_t request = in->command.request;
    drive_event_t event = DRIVE_EVENT_NONE;

    if ((request & DRIVE_REQUEST_RUN) != 0U) {
        event = start_run(drive, in, fault);
    } else if ((request & DRIVE_REQUEST_PROBE) != 0U) {
        event = DRIVE_EVENT_PROBE;
    } else {
        /* stay */
    }
    return event;
}

/* Obeys the command, or runs the calibration, while nothing is driven. */
static drive_event_t obey_at_rest(sensors_t *sensors, const drive_t *drive, const drive_in_t *in,
                                  fault_t *fault)
{
    const uint8_t request = in->command.request;
    const bool clear = (request & (DRIVE_REQUEST_CLEAR | DRIVE_REQUEST_RUN)) == DRIVE_REQUEST_CLEAR;
    drive_event_t event;

    switch (drive->state) {
    case DRIVE_STATE_OFFSET_CAL:
        event = calibration_step(sensors, drive->cfg, in, fault);
        break;
    case DRIVE_STATE_READY:
        event = obey_when_ready(drive, in, fault);
        break;
    case DRIVE_STATE_FAULT:
        event = clear ? DRIVE_EVENT_CALIBRATE : DRIVE_EVENT_NONE;
        break;
    default: /* INIT */
        event = DRIVE_EVENT_CALIBRATE;
        break;
    }
    return event;
}

/*
 * Obeys the command. While the safe state shorts the motor, a current flows, so nothing may begin.
 */
static void obey(drive_t *drive, const drive_in_t *in, const instant_t *now)
{
    const bool driving = drive_is_driving(drive->state);
    const bool calibrating = drive->state == DRIVE_STATE_OFFSET_CAL;
    const uint8_t level =
        (drive->state == DRIVE_STATE_PROBE) ? DRIVE_REQUEST_PROBE : DRIVE_REQUEST_RUN;

    if (!driving && !safe_state_is_short(&drive->safe_state)) {
        fault_t fault;
        drive_event_t event;

        fault_clear(&fault);
        event = obey_at_rest(&drive->sensors, drive, in, &fault);
        if (calibrating && (event != DRIVE_EVENT_NONE)) {
            state_guard_keep_measured(&drive->state_guard, drive);
        }
        life_follow_or_fail(drive, event, &fault, now);
    } else if (driving && ((in->command.request & level) == 0U)) {
        life_follow(drive, DRIVE_EVENT_STOP, now);
    } else {
        /* go on */
    }
}

bool attend_is_ordinary(const drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const uint32_t word = ((uint32_t)in->flags << 8U) | in->command.request;

    return (drive->state == DRIVE_STATE_RUN) && (word == DRIVE_REQUEST_RUN) &&
           protection_holds(&drive->limits, sample);
}

/* Finds the fault that the background has found. A mode that names no fault is none. */
static fault_id_t check_told(const drive_command_t *command, fault_t *fault)
{
    const uint32_t numbers = fx_unsigned(command->target);
    const uint32_t value = numbers & 0xFFFFU;
    const uint32_t limit = numbers >> 16U;
    const uint32_t told = (uint32_t)command->mode - DRIVE_MODE_FAULT;
    fault_id_t id = FAULT_NONE;

    if ((command->request == DRIVE_REQUEST_FAIL) && (told > (uint32_t)FAULT_NONE) &&
        (told < (uint32_t)FAULT_COUNT)) {
        id = (fault_id_t)told;
        *fault = (fault_t){.id = id, .value = (int32_t)value, .limit = (int32_t)limit};
    }
    return id;
}

/*
 * A late tick is a fault only while the motor is driven. Zero voltage acts in place of its demand.
 */
static fault_id_t count_late(control_t *control, watch_t *watch, const drive_t *drive,
                             fault_t *fault)
{
    const fault_id_t id = monitor_late(watch, drive, fault);

    frame_lose_demand(control);
    return drive_is_driving(drive->state) ? id : FAULT_NONE;
}

/*
 * The sensor has failed in RUN. The observer holds the motor above the hand-over speed. Below it a
 * current is imposed where the present one points; an observer beside a sensor has a start-up. A
 * drive that has no observer stops, and so does a fast one whose sensor was turned: the observer
 * begins with the sensor's angle.
 */
RARE static void lose_sensor(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const instant_t now = {.sample = sample, .along_rotor = {0, 0}, .along_vector = {0, 0}};
    const drive_cfg_t *const cfg = drive->cfg;
    const bool fast = fx_abs(drive->rotor.observer.speed) >= cfg->startup.handover_speed;
    const bool observed = cfg->observer.eta != 0;

    if (observed && !fast) {
        const ab_t current = transforms_clarke(sample.phase_a, sample.phase_b);
        instant_t turned = now;

        turned.along_rotor =
            transforms_park(current, trig_sincos(rotor_position_angle(&drive->rotor.position)));
        life_follow(drive, DRIVE_EVENT_SLOW, &turned);
    } else if (!observed || is_sensor_turned(&drive->rotor)) {
        const fault_t fault = sensor_fault(drive, in);

        life_fail(drive, &fault, &now);
    } else {
        /* the observer goes on */
    }
}

static void fail_if(drive_t *drive, fault_id_t id, const fault_t *fault, const instant_t *now)
{
    if (id != FAULT_NONE) {
        life_fail(drive, fault, now);
    }
}

/* The words of the tracking loop have changed by themselves. */
RARE static void fail_damaged_sensor(drive_t *drive, sample_t sample)
{
    const instant_t now = {.sample = sample, .along_rotor = {0, 0}, .along_vector = {0, 0}};
    fault_t fault;

    fault_clear(&fault);
    fail_if(drive, state_guard_check_sensor(drive, &fault), &fault, &now);
}

NEVER_INLINED bool attend_sensor(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    if (!angle_sensor_holds(&drive->rotor.angle_sensor)) {
        fail_damaged_sensor(drive, sample);
    }
    if (estimate_sense(&drive->rotor, drive, in)) {
        lose_sensor(drive, in, sample);
    }
    return drive_is_controlled(drive->state);
}

bool attend_step(drive_t *drive, const drive_in_t *in, sample_t sample)
{
    const instant_t now = {.sample = sample, .along_rotor = {0, 0}, .along_vector = {0, 0}};
    const bool controlled = drive_is_controlled(drive->state);
    fault_t fault;

    fault_clear(&fault);
    fail_if(drive, state_guard_check_state(drive, &fault), &fault, &now);
    if (drive_has_sensor(drive)) {
        (void)attend_sensor(drive, in, sample);
    }
    fail_if(drive, check_told(&in->command, &fault), &fault, &now);
    /* FAIL replaces the request RUN. So without a valid fault id the run ends as by a stop. */
    obey(drive, in, &now);
    if (((in->command.request & DRIVE_REQUEST_ZERO) != 0U) && drive_knows_rotor(drive)) {
        run_set_zero(&drive->motion, drive);
    }
    /*
     * Check this before the currents: a fault of the currents that late ticks cause is to be
     * reported as LATE.
     */
    if ((in->flags & DRIVE_FLAG_LATE) != 0U) {
        fail_if(drive, count_late(&drive->control, &drive->watch, drive, &fault), &fault, &now);
    }
    if ((in->flags & DRIVE_FLAG_BREAK) != 0U) {
        fault = protection_break(&sample);
        life_fail(drive, &fault, &now);
        safe_state_break(&drive->safe_state);
    }
    fail_if(drive, check_samples(drive, in, sample, &fault), &fault, &now);
    return controlled && drive_is_controlled(drive->state);
}
