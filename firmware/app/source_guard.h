/* SPDX-License-Identifier: MIT */
/*
 * Watches whether a source of commands is heard: the PC, the person at the console, the input. If
 * not, the motor is brought to rest.
 *
 * The guard watches from a command of its source until the source leaves or another source
 * commands. It keeps watching when the line has gone back to the console after a pause. A PC that
 * only reads is not watched. When its source has not been heard for the time-out and a run of this
 * source is in force, the target speed becomes 0, and the request ends when the motor is at rest. A
 * measurement of the motor ends at once. Then the guard watches nothing until the next command.
 *
 * Time is counted in control ticks: without ticks no time-out ends, and the motor does not move
 * either. Context: background.
 */
#ifndef SOURCE_GUARD_H
#define SOURCE_GUARD_H

#include "app.h"
#include "identify.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    source_t source; /* that the guard watches; set once */
    uint32_t heard;  /* tick in which the source was heard last */
    bool watching;   /* the source has commanded the drive, so the guard watches */
    bool stopping;   /* the target speed is 0 because the source was not heard */
} source_guard_t;

/* Call when the source is heard: a good frame, a typed byte. tick: the present tick. */
void source_guard_heard(source_guard_t *guard, uint32_t tick);

/* Call when the source leaves, or another one commands. From now on nothing is watched. */
void source_guard_leave(source_guard_t *guard);

/*
 * Call when the source commands the drive. From now on the guard watches, and a stop that is under
 * way is given up. Call source_guard_heard() for the same frame or byte after it.
 */
void source_guard_commanded(source_guard_t *guard);

/* Whether the source was heard last more than `ticks` before `tick`. */
bool source_guard_is_silent(const source_guard_t *guard, uint32_t tick, uint32_t ticks);

/*
 * The source is lost: begins to stop what it commands. identify: the measurement that ends too,
 * with the reason `why`. Returns whether there was something to stop.
 */
bool source_guard_lose(source_guard_t *guard, app_t *app, identify_t *identify, const char *why);

/*
 * One pass. Returns true in the pass in which the drive begins to stop because the source was not
 * heard for `timeout_ticks`. With `timeout_ticks` = 0 the drive never stops for this reason.
 */
bool source_guard_step(source_guard_t *guard, app_t *app, identify_t *identify, uint32_t tick,
                       uint32_t timeout_ticks);

/* Whether the motor is so slow that a run may end: below 1/256 of the highest speed. */
bool source_guard_is_slow(const app_t *app);

#endif
