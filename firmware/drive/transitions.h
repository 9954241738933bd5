/* SPDX-License-Identifier: MIT */
/*
 * The state machine of the drive as a table: which state follows from an event. life.c alone sets
 * the state.
 */
#ifndef TRANSITIONS_H
#define TRANSITIONS_H

#include "state.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * Returns the state that follows, or `state` when the event changes nothing. In FAULT another fault
 * changes nothing. From a code that is not a state, every event leads to FAULT. Pure, any context.
 */
drive_state_t transitions_next(drive_state_t state, drive_event_t event);

/* Whether this is the code of a state. Pure, any context. */
bool transitions_is_state(drive_state_t state);

/*
 * The number of a state, 0…DRIVE_STATES − 1, in the order of drive_state_t; DRIVE_STATES if the
 * code is not a state. Pure, any context.
 */
uint32_t transitions_number(drive_state_t state);

/* The state with this number; FAULT if it is DRIVE_STATES or more. Pure, any context. */
drive_state_t transitions_state(uint32_t number);

#endif
