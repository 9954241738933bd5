/* SPDX-License-Identifier: MIT */
#include "schedule.h"

#include "estimate.h"
#include "frame.h"
#include "monitor.h"
#include "motor.h"
#include "open_loop.h"
#include "run.h"
#include "state_guard.h"
#include "vector.h"
#include "voltage_drive.h"

/* HOLD to HANDOVER, in which the motion loops move the vector. */
static bool moves_vector(drive_state_t state)
{
    return (state > DRIVE_STATE_ALIGN) && (state < DRIVE_STATE_RUN);
}

/* HOLD to RUN. ALIGN moves the vector by itself. */
static bool plans_motion(drive_state_t state)
{
    return (state > DRIVE_STATE_ALIGN) && (state < DRIVE_STATE_FAULT);
}

static drive_event_t event_of(fault_id_t id)
{
    return (id == FAULT_NONE) ? DRIVE_EVENT_NONE : DRIVE_EVENT_FAULT;
}

void schedule_end_voltage_drive(drive_t *drive)
{
    frame_resume(&drive->control, drive, virtual_resistance_mean(&drive->voltage_drive.damping));
    run_resume(&drive->motion, drive);
    voltage_drive_reset(&drive->voltage_drive);
}

/* The speed PI of the voltage drive, or its end. */
static void step_voltage_drive(drive_t *drive, const drive_command_t *command, int32_t bus)
{
    if (voltage_drive_count_end(&drive->voltage_drive, drive, command)) {
        schedule_end_voltage_drive(drive);
    } else {
        run_follow_command(&drive->motion, drive);
        voltage_drive_set_magnitude(&drive->voltage_drive, drive, bus);
    }
}

/*
 * Sets i_q*, leads the estimate by the acceleration that it makes, and changes to the voltage drive
 * when its time has come.
 */
static void step_current_control(drive_t *drive, const drive_command_t *command, dq_t current)
{
    const step_t before = drive->motion.speed_loop.reference;

    frame_ask_q(&drive->control, run_step_torque(&drive->motion, drive));
    if (drive->cfg->run.acceleration_q14 != 0) {
        estimate_accelerate(&drive->rotor, drive, run_expected_change(drive, before));
    }
    if (voltage_drive_count_calm(&drive->voltage_drive, drive, command, current)) {
        voltage_drive_begin(&drive->voltage_drive, drive);
        frame_ask(&drive->control, (dq_t){0, 0}); /* the voltage drive has no current reference */
    }
    frame_plan_rotor(&drive->control, drive);
}

/* SPEED in RUN. */
static drive_event_t control_rotor(drive_t *drive, const drive_command_t *command,
                                   const instant_t *now)
{
    bool slow = false;

    open_loop_count_run(&drive->start, &drive->cfg->startup);
    if (drive->voltage_drive.active) {
        step_voltage_drive(drive, command, now->sample.bus);
    } else {
        step_current_control(drive, command, now->along_rotor);
        slow = run_is_to_be_held(drive);
    }
    return slow ? DRIVE_EVENT_SLOW : DRIVE_EVENT_NONE;
}

/* SPEED from HOLD to HANDOVER. */
static drive_event_t move_vector(drive_t *drive, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_FAULT;

    if (state_guard_check_vector(drive, fault) != FAULT_NONE) {
        /* a fault */
    } else if (drive_is_held(drive) && estimate_may_take_sensor(drive)) {
        event = DRIVE_EVENT_TRACKED;
    } else {
        frame_ask_q(&drive->control, run_accelerate(&drive->motion, drive));
        vector_move(&drive->vector, drive->motion.speed_loop.reference);
        event = open_loop_judge(&drive->start, drive, fault);
    }
    return event;
}

static drive_event_t control_speed(drive_t *drive, const drive_command_t *command,
                                   const instant_t *now, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->state == DRIVE_STATE_RUN) {
        event = control_rotor(drive, command, now);
    } else if (moves_vector(drive->state)) {
        event = move_vector(drive, fault);
    } else {
        /* ALIGN moves the vector by itself */
    }
    return event;
}

static void plan(motion_t *motion, state_guard_t *guard, const drive_t *drive,
                 const drive_command_t *command)
{
    const rotor_position_t *const position = drive_frame_position(drive);

    if (command->mode != motion->mode) {
        run_change_mode(motion, drive, command->mode, position);
        state_guard_forget(guard);
    }
    run_plan(motion, drive, command, position);
    if (drive->state != DRIVE_STATE_RUN) {
        run_plan_vector(motion, drive, open_loop_has_to_stand(drive));
    }
}

static void refine(motor_t *motor, rotor_t *rotor, const drive_t *drive)
{
    const step_t calm = estimate_calm_speed(drive);

    motor_refine(motor, drive->cfg, &rotor->observer, calm);
    estimate_refine(rotor, drive, calm);
}

static void limit(motion_t *motion, control_t *control, const drive_t *drive, const instant_t *now,
                  torque_range_t range)
{
    run_allow(motion, range);
    if ((drive->state == DRIVE_STATE_RUN) && !drive->voltage_drive.active) {
        frame_ask_d(control, run_plan_current_d(motion, drive, now));
    }
}

static fault_id_t watch_phases(watch_t *watch, motion_t *motion, const drive_t *drive,
                               const sample_t *sample, fault_t *fault)
{
    fault_id_t id = monitor_phases(watch, drive, sample, fault);

    if ((id == FAULT_NONE) && (drive->state == DRIVE_STATE_RUN) &&
        (drive->cfg->oscillation.act != (uint32_t)OSCILLATION_ACT_NONE)) {
        id = monitor_swing(watch, drive, fault);
        if ((id != FAULT_NONE) && monitor_may_lower(drive)) {
            run_set_bandwidth(motion, true);
            fault_clear(fault);
            id = FAULT_NONE;
        }
    }
    return id;
}

drive_event_t schedule_step(drive_t *drive, const drive_in_t *in, const instant_t *now, slot_t slot,
                            bool moving, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    switch (slot) {
    case SLOT_PHASES:
        event = event_of(watch_phases(&drive->watch, &drive->motion, drive, &now->sample, fault));
        break;
    case SLOT_CHECKS:
        event = event_of(monitor_next_check(drive, in, now, fault));
        break;
    case SLOT_LIMITS:
        limit(&drive->motion, &drive->control, drive, now,
              monitor_derate(&drive->derating, drive, now->sample.bus));
        break;
    case SLOT_REFINE:
        if (moving && (drive->state > DRIVE_STATE_ALIGN)) {
            refine(&drive->motor, &drive->rotor, drive);
        }
        break;
    case SLOT_PLAN:
        if (moving && plans_motion(drive->state)) {
            plan(&drive->motion, &drive->state_guard, drive, &in->command);
        }
        break;
    default: /* SPEED */
        if (moving) {
            event = control_speed(drive, &in->command, now, fault);
        }
        break;
    }
    return event;
}
