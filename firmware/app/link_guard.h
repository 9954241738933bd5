/* SPDX-License-Identifier: MIT */
/*
 * Watches whether the PC is heard. If not, the line goes back to the console after a pause, and the
 * motor is brought to rest after cfg->link.timeout_ticks.
 *
 * The motor is watched from a command of the PC on to the end of the link, also when the line has
 * gone back to the console after a pause. A PC that only reads is not watched. When no frame has
 * come for timeout_ticks and a run is requested, the target speed becomes 0, and the request ends
 * when the motor is at rest. A measurement of the motor ends at once. Then nothing is watched until
 * the next command.
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
    uint32_t heard; /* tick of the last frame */
    bool watching;  /* the PC has commanded the drive */
    bool stopping;  /* the speed is 0 because the PC was not heard */
} link_guard_t;

/* A good frame came in this tick. */
void link_guard_heard(link_guard_t *guard, uint32_t tick);

/* The PC says goodbye, or a person commands: nothing is watched any more. */
void link_guard_leave(link_guard_t *guard);

/*
 * The PC commands the drive: from now on it is watched, and a stop that is under way is given up.
 * The call of link_guard_heard() for its frame follows.
 */
void link_guard_commanded(link_guard_t *guard);

/* Whether the last frame came more than so many ticks ago. */
bool link_guard_is_silent(const link_guard_t *guard, uint32_t tick, uint32_t ticks);

/*
 * One pass. True when the drive begins to stop because no frame came for `timeout_ticks`; 0: it
 * never does.
 */
bool link_guard_step(link_guard_t *guard, app_t *app, identify_t *identify, uint32_t tick,
                     uint32_t timeout_ticks);

#endif
