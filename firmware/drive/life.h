/* SPDX-License-Identifier: MIT */
/*
 * The life of a drive: how it begins, how it changes its state, and how it begins anew. Only life.c
 * sets the state.
 *
 * Part of the drive. Control interrupt only. life.c also contains drive_init() and drive_warm()
 * (drive.h), which are called elsewhere.
 */
#ifndef LIFE_H
#define LIFE_H

#include "instant.h"
#include "state.h"

/*
 * Go to the state that follows from this event, if one does. now: this tick's instant; the state
 * begins with it (entry.h).
 */
void life_follow(drive_t *drive, drive_event_t event, const instant_t *now);

/*
 * Go to FAULT, and keep the fault and its scene (fault_scene_t), of which the sample is a part. A
 * fault is latched: in FAULT another one changes nothing.
 */
void life_fail(drive_t *drive, const fault_t *fault, const instant_t *now);

/* Calls life_fail() if the event is DRIVE_EVENT_FAULT, otherwise life_follow(). */
void life_react(drive_t *drive, drive_event_t event, const fault_t *fault, const instant_t *now);

/* Act on the event of a part that can also find a fault. Most ticks have no event. */
static inline void life_follow_or_fail(drive_t *drive, drive_event_t event, const fault_t *fault,
                                       const instant_t *now)
{
    if (event != DRIVE_EVENT_NONE) {
        life_react(drive, event, fault, now);
    }
}

/* Puts the limits of protection in force that the configuration has for the present state. */
void life_set_limits(drive_t *drive);

/*
 * The drive begins anew with this configuration, in which some words of the state have another
 * meaning, and calibrates. It keeps its tick count, a latched fault with its scene, and the heat,
 * converted to the new scale. The slow period goes on, because this tick reads the slow inputs. A
 * motor that is too fast for open gates is shorted first. Until the calibration the last zeros of
 * the current sensors stay in force, because they hold in any scale.
 */
void life_restart(drive_t *drive, const drive_cfg_t *cfg);

#endif
