/* SPDX-License-Identifier: MIT */
#include "schedule.h"

#include "estimate.h"
#include "monitor.h"
#include "open_loop.h"
#include "run.h"

/* HOLD to HANDOVER, in which the motion loops move the vector. */
static bool moves_vector(drive_state_t state)
{
    return (state > DRIVE_STATE_ALIGN) && (state < DRIVE_STATE_RUN);
}

static drive_event_t event_of(fault_id_t id)
{
    return (id == FAULT_NONE) ? DRIVE_EVENT_NONE : DRIVE_EVENT_FAULT;
}

static drive_event_t control_speed(drive_t *drive, const drive_command_t *command,
                                   const instant_t *now, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->state == DRIVE_STATE_RUN) {
        event = run_control_speed(drive, command, now);
    } else if (moves_vector(drive->state)) {
        event = open_loop_drag(drive, fault);
    } else {
        /* ALIGN moves the vector by itself */
    }
    return event;
}

static void plan(drive_t *drive, const drive_command_t *command)
{
    if (drive->state == DRIVE_STATE_RUN) {
        run_plan(drive, command, &drive->rotor.position);
    } else if (moves_vector(drive->state)) {
        open_loop_plan(drive, command);
    } else {
        /* ALIGN moves the vector by itself */
    }
}

drive_event_t schedule_step(drive_t *drive, const drive_in_t *in, const instant_t *now, slot_t slot,
                            bool moving, fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    switch (slot) {
    case SLOT_PHASES:
        event = event_of(monitor_phases(drive, &now->sample, fault));
        break;
    case SLOT_CHECKS:
        event = event_of(monitor_next_check(drive, in, now, fault));
        break;
    case SLOT_LIMITS:
        monitor_limits(drive, now->sample.bus);
        if (drive->state == DRIVE_STATE_RUN) {
            run_limit(drive, now);
        }
        break;
    case SLOT_REFINE:
        if (moving && (drive->state > DRIVE_STATE_ALIGN)) {
            estimate_refine(drive);
        }
        break;
    case SLOT_PLAN:
        if (moving) {
            plan(drive, &in->command);
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
