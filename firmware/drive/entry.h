/* SPDX-License-Identifier: MIT */
/*
 * What begins when the drive enters a state: each way of control begins where the one before it has
 * ended, so that neither voltage nor torque jumps.
 *
 * Part of the drive; called from life.c only.
 */
#ifndef ENTRY_H
#define ENTRY_H

#include "instant.h"
#include "state.h"

/* Call when the state has just changed from `from` to drive->state. now: this tick's instant. */
void entry_begin(drive_t *drive, drive_state_t from, const instant_t *now);

#endif
