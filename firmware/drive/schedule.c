/* SPDX-License-Identifier: MIT */
#include "schedule.h"

#include "estimate.h"
#include "monitor.h"
#include "open_loop.h"
#include "run.h"

/* HOLD to RUN: the motion loops run. */
static bool has_motion_loops(drive_state_t state)
{
    return (state > DRIVE_STATE_ALIGN) && (state < DRIVE_STATE_FAULT);
}

static drive_event_t event_of(fault_id_t id)
{
    return (id == FAULT_NONE) ? DRIVE_EVENT_NONE : DRIVE_EVENT_FAULT;
}

static void plan_motion(drive_t *drive, const drive_command_t *command)
{
    if (drive->state == DRIVE_STATE_RUN) {
        run_plan(drive, command, &drive->position);
    } else {
        open_loop_plan(drive, command);
    }
}

static drive_event_t control_speed(drive_t *drive, const drive_command_t *command, fault_t *fault)
{
    return (drive->state == DRIVE_STATE_RUN) ? run_control_speed(drive, command)
                                             : open_loop_drag(drive, fault);
}

static drive_event_t step_motion(drive_t *drive, const drive_command_t *command, slot_t slot,
                                 fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (slot == SLOT_REFINE) {
        estimate_refine(drive);
    } else if (slot == SLOT_PLAN) {
        plan_motion(drive, command);
    } else { /* SLOT_SPEED */
        event = control_speed(drive, command, fault);
    }
    return event;
}

drive_event_t schedule_step(drive_t *drive, const drive_in_t *in, slot_t slot, bool moving,
                            fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    switch (slot) {
    case SLOT_PHASES:
        event = event_of(monitor_phases(drive, fault));
        break;
    case SLOT_CHECKS:
        event = event_of(monitor_next_check(drive, in->adc_temperature, fault));
        break;
    case SLOT_LIMITS:
        monitor_limits(drive);
        break;
    default: /* REFINE, PLAN, SPEED */
        if (moving && has_motion_loops(drive->state)) {
            event = step_motion(drive, &in->command, slot, fault);
        }
        break;
    }
    return event;
}
