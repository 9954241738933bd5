/* What the parts of the drive share: its state, and what follows from it. From within drive_step only. */
#ifndef DRIVE_STATE_H
#define DRIVE_STATE_H

#include "drive.h"

/* CATCH_SPIN to RUN: current may flow. */
static inline bool drive_is_driving(drive_state_t state)
{
    return (state > DRIVE_STATE_READY) && (state < DRIVE_STATE_FAULT);
}

/* The parts of the configuration that the model corrects. */
static inline model_nominal_t drive_nominal(const drive_t *drive)
{
    return (model_nominal_t){&drive->cfg->observer, &drive->cfg->current_loop,
                             &drive->cfg->hold_loop};
}

/* Change the state; its limits are in force from here on. */
void drive_enter(drive_t *drive, drive_state_t state);

/* Latch a fault. The gates open in this tick. */
void drive_fail(drive_t *drive, fault_t fault);

#endif
