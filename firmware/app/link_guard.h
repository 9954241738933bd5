/* SPDX-License-Identifier: MIT */
/*
 * Watches whether the PC is heard. If not, the line goes back to the console after a pause, and the
 * motor is brought to rest after cfg->link.timeout_ticks.
 *
 * The guard watches from a command of the PC until the PC says goodbye or a person commands. It
 * keeps watching when the line has gone back to the console after a pause. A PC that only reads is
 * not watched. When no frame has come for timeout_ticks and a run is requested, the target speed
 * becomes 0, and the request ends when the motor is at rest. A measurement of the motor ends at
 * once. Then the guard watches nothing until the next command.
 *
 * Time is counted in control ticks: without ticks no time-out ends, and the motor does not move
 * either. Context: background.
 */
#ifndef LINK_GUARD_H
#define LINK_GUARD_H

#include "app.h"
#include "identify.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t heard; /* tick of the last good frame */
    bool watching;  /* the PC has commanded the drive, so the guard watches */
    bool stopping;  /* the target speed is 0 because the PC was not heard */
} link_guard_t;

/* Call when a good frame has come. tick: the present tick. */
void link_guard_heard(link_guard_t *guard, uint32_t tick);

/* Call when the PC says goodbye, or a person commands. From now on nothing is watched. */
void link_guard_leave(link_guard_t *guard);

/*
 * Call when the PC commands the drive. From now on the guard watches, and a stop that is under way
 * is given up. Call link_guard_heard() for the same frame after it.
 */
void link_guard_commanded(link_guard_t *guard);

/* Whether the last good frame came more than `ticks` before `tick`. */
bool link_guard_is_silent(const link_guard_t *guard, uint32_t tick, uint32_t ticks);

/*
 * One pass. Returns true in the pass in which the drive begins to stop because no good frame has
 * come for `timeout_ticks`. With `timeout_ticks` = 0 the drive never stops for this reason.
 */
bool link_guard_step(link_guard_t *guard, app_t *app, identify_t *identify, uint32_t tick,
                     uint32_t timeout_ticks);

#endif
