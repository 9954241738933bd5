/* SPDX-License-Identifier: MIT */
#include "schedule.h"

#include "estimate.h"
#include "monitor.h"
#include "open_loop.h"
#include "run.h"

/* HOLD to HANDOVER: the motion loops move the vector. */
static bool moves_vector(drive_state_t state)
{
    return (state > DRIVE_STATE_ALIGN) && (state < DRIVE_STATE_RUN);
}

static drive_event_t event_of(fault_id_t id)
{
    return (id == FAULT_NONE) ? DRIVE_EVENT_NONE : DRIVE_EVENT_FAULT;
}

static drive_event_t step_run(drive_t *drive, const drive_command_t *command, slot_t slot)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (slot == SLOT_REFINE) {
        estimate_refine(drive);
    } else if (slot == SLOT_PLAN) {
        run_plan(drive, command, &drive->position);
    } else { /* SLOT_SPEED */
        event = run_control_speed(drive, command);
    }
    return event;
}

static drive_event_t step_vector(drive_t *drive, const drive_command_t *command, slot_t slot,
                                 fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (slot == SLOT_REFINE) {
        estimate_refine(drive);
    } else if (slot == SLOT_PLAN) {
        open_loop_plan(drive, command);
    } else { /* SLOT_SPEED */
        event = open_loop_drag(drive, fault);
    }
    return event;
}

static drive_event_t step_motion(drive_t *drive, const drive_command_t *command, slot_t slot,
                                 fault_t *fault)
{
    drive_event_t event = DRIVE_EVENT_NONE;

    if (drive->state == DRIVE_STATE_RUN) {
        event = step_run(drive, command, slot);
    } else if (moves_vector(drive->state)) {
        event = step_vector(drive, command, slot, fault);
    } else {
        /* ALIGN moves the vector by itself */
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
        if (moving) {
            event = step_motion(drive, &in->command, slot, fault);
        }
        break;
    }
    return event;
}
