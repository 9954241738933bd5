/* SPDX-License-Identifier: MIT */
/* Functions on the state that the parts of the drive share. Call from within drive_step only. */
#ifndef DRIVE_STATE_H
#define DRIVE_STATE_H

#include "drive.h"

/*
 * The work of a slow period is spread over its last ticks, one part per tick, so that the longest tick is shorter. The
 * number of a part is the number of ticks left in the period.
 */
typedef enum {
    SLOW_PART_SPEED = 0, /* speed PI, or speed of the imposed vector; next state */
    SLOW_PART_PLAN,      /* speed reference: ramp or position profile */
    SLOW_PART_LIMITS,    /* limits of the torque current */
    SLOW_PART_CHECKS,    /* one of the checks that take turns */
    SLOW_PART_PHASES,    /* check for lost phases */
    SLOW_PART_REFINE,    /* residual, flux and static part of the observer */
    SLOW_PARTS
} slow_part_t;

/* CATCH_SPIN to RUN: current may flow. */
static inline bool drive_is_driving(drive_state_t state)
{
    return (state > DRIVE_STATE_READY) && (state < DRIVE_STATE_FAULT);
}

/* ALIGN to RUN: the current is controlled. */
static inline bool drive_is_controlled(drive_state_t state)
{
    return (state > DRIVE_STATE_CATCH_SPIN) && (state < DRIVE_STATE_FAULT);
}

/* The parts of the configuration that the model corrects. */
static inline model_nominal_t drive_nominal(const drive_t *drive)
{
    return (model_nominal_t){&drive->cfg->observer, &drive->cfg->current_loop,
                             &drive->cfg->hold_loop};
}

/* Change the state. The protection limits of the new state apply from now on. */
void drive_enter(drive_t *drive, drive_state_t state);

/* Latch a fault. The gates open in this tick. */
void drive_fail(drive_t *drive, fault_t fault);

#endif
