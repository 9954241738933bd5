/* SPDX-License-Identifier: MIT */
/*
 * The lock: another configuration may not protect less than the configuration in force, unless a
 * user has unlocked this at rest (commander.h).
 *
 * Settings that a file chooses may not protect less at all, apart from the rounding of times. These
 * are the settings with a ceiling (config_ceiling.h), the watch for swings, the time-out of the
 * link, the lowest bus, the limits of the supply, late ticks, and the times of overspeed, runaway
 * and stall.
 *
 * Limits that follow from the constants of the motor may become twice as wide, because they do so
 * when somebody corrects these constants. These are the limits of the supervision, the amplitude of
 * a swing, and the speed up to which the gates open. For most of them the factor of two is relative
 * to the configuration that was unlocked last, so many small changes cannot widen a limit further
 * than one change.
 *
 * Pure. Context: background.
 */
#ifndef CONFIG_LOCK_H
#define CONFIG_LOCK_H

#include "drive_cfg.h"

#define CONFIG_LOCK_LIMITS (12U)

/*
 * Copy of the limits that follow from the constants of the motor, taken at the start and whenever
 * an unlocked configuration is taken over.
 */
typedef struct {
    uint32_t limits[CONFIG_LOCK_LIMITS];
} config_lock_t;

/*
 * Copies the limits of `cfg` to `lock`. Call at the start, and when an unlocked configuration is
 * taken over.
 */
void config_lock_keep(config_lock_t *lock, const drive_cfg_t *cfg);

/*
 * Returns the path of the first setting of `to` that protects less than `from` does, or whose limit
 * is wider than twice the limit in `lock`, a constant string; NULL: there is none. config_check()
 * has accepted both configurations.
 */
const char *config_lock_refused(const config_lock_t *lock, const drive_cfg_t *from,
                                const drive_cfg_t *to);

#endif
