/* SPDX-License-Identifier: MIT */
/*
 * Watches that the PC is heard: for the line, which goes back to the console after a pause, and for the motor, which is
 * brought to rest when cfg->link.timeout_ticks says so.
 *
 * The motor is watched from a hello to a bye, also when the line has gone back to the console in between. When the PC was not heard
 * for so long and a run is asked for, the speed becomes 0, and the request ends when the motor is at rest. A measurement
 * of the motor ends at once.
 *
 * Time is that of the control ticks: without ticks nothing runs out, and nothing moves either. Context: background.
 */
#ifndef LINK_GUARD_H
#define LINK_GUARD_H

#include "app.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t heard; /* tick of the last frame */
    bool watching;
    bool stopping; /* the speed is 0 because the PC was not heard */
} link_guard_t;

/* A frame came in. */
void link_guard_heard(link_guard_t *guard, uint32_t tick);

/* The motor is watched from now on, or not any more. */
void link_guard_watch(link_guard_t *guard, bool on);

/* Somebody commands the drive: a stop that is under way is given up. */
void link_guard_commanded(link_guard_t *guard);

/* Whether no frame came for so many ticks; 0: never. */
bool link_guard_is_silent(const link_guard_t *guard, uint32_t tick, uint32_t ticks);

/* One pass. True when the stop begins now, because the PC was not heard for `timeout_ticks`; 0: never. */
bool link_guard_step(link_guard_t *guard, app_t *app, uint32_t tick, uint32_t timeout_ticks);

#endif
