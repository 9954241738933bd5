/* SPDX-License-Identifier: MIT */
/*
 * What protects is locked: another configuration may not protect less than the one in force, unless
 * somebody has unlocked it at rest (commander.h).
 *
 * What a file chooses may not be less at all: what has a ceiling (config_ceiling.h), the watch for
 * swings, the time-out of the link, the lowest bus, the limits of the supply, late ticks, and the
 * times of overspeed, runaway and stall, but for their rounding. What follows from the motor's
 * constants may be twice as wide, as the constants are when they are corrected: the limits of the
 * supervision, the amplitude of a swing, the speed up to which gates open. Of most of them twice is
 * meant from what was unlocked last, so that many small changes lead no further than one.
 *
 * Pure. Context: background.
 */
#ifndef CONFIG_LOCK_H
#define CONFIG_LOCK_H

#include "drive_cfg.h"

#define CONFIG_LOCK_LIMITS (12U)

/* What follows from the motor's constants, as it was unlocked last. */
typedef struct {
    uint32_t limits[CONFIG_LOCK_LIMITS];
} config_lock_t;

/*
 * This configuration is in force with the will of whoever may unlock: at the start, and when it was
 * unlocked.
 */
void config_lock_keep(config_lock_t *lock, const drive_cfg_t *cfg);

/*
 * Returns the path of the first setting of `to` that protects less than that of `from`, or than
 * twice what `lock` has, a constant string; NULL: none does. Both configurations are good by
 * config_check.h.
 */
const char *config_lock_refused(const config_lock_t *lock, const drive_cfg_t *from,
                                const drive_cfg_t *to);

#endif
