/* SPDX-License-Identifier: MIT */
/*
 * The life of a drive: how it begins, from which state it goes to which, and how it begins anew.
 * Only life.c sets the state.
 *
 * Part of the drive. Control interrupt only, but for drive_init() and drive_warm() (drive.h), which
 * are here too.
 */
#ifndef LIFE_H
#define LIFE_H

#include "state.h"

/* Go to the state that follows from this event, if one does. */
void life_follow(drive_t *drive, drive_event_t event);

/*
 * Go to FAULT, and keep what was around it. A fault is latched: in FAULT another one changes
 * nothing.
 */
void life_fail(drive_t *drive, const fault_t *fault);

/* life_fail() with DRIVE_EVENT_FAULT, else life_follow(). */
void life_react(drive_t *drive, drive_event_t event, const fault_t *fault);

/* Act on the event of a part that can find a fault too. Most ticks have none. */
static inline void life_follow_or_fail(drive_t *drive, drive_event_t event, const fault_t *fault)
{
    if (event != DRIVE_EVENT_NONE) {
        life_react(drive, event, fault);
    }
}

/*
 * Words of the state mean something else from now on, so the drive begins anew and calibrates. What
 * remains is the clock, a latched fault, and the heat of the same current. The slow period goes on:
 * this tick has read its slow inputs. A motor that is too fast for open gates is shorted first; the
 * zeros of its current sensors hold in any scale.
 */
void life_restart(drive_t *drive, const drive_cfg_t *cfg);

#endif
