/* SPDX-License-Identifier: MIT */
/*
 * What protects below the ceilings (config_ceiling.h), and is locked: another configuration may not protect less than the one in
 * force, unless somebody has unlocked it at rest (commander.h).
 *
 * What a file chooses may not be less at all: the watch for swings, the time-out of the link, the short circuit at a stop, the lowest bus, the
 * limits of the supply, late ticks, and the times for which a symptom may last. What follows from the motor's constants may be up to
 * twice as wide, as the constants are when they are corrected: the limits of the supervision and the amplitude of a swing.
 *
 * Pure. Context: background.
 */
#ifndef CONFIG_LOCK_H
#define CONFIG_LOCK_H

#include "drive_cfg.h"

/*
 * Returns the path of the first setting of `to` that protects less than that of `from`, a constant string; NULL: none does. Both
 * configurations are good by config_check.h.
 */
const char *config_lock_refused(const drive_cfg_t *from, const drive_cfg_t *to);

#endif
