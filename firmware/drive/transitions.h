/* SPDX-License-Identifier: MIT */
/* The state machine of the drive as a table: which state follows from an event. drive.c alone sets the state. */
#ifndef TRANSITIONS_H
#define TRANSITIONS_H

#include "state.h"

/* Returns the state that follows, or `state` when nothing does. In FAULT another fault is not followed. Pure, any context. */
drive_state_t transitions_next(drive_state_t state, drive_event_t event);

#endif
