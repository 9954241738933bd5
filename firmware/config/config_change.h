/* SPDX-License-Identifier: MIT */
/*
 * Whether one configuration may replace another while current flows: the column RUN or REST of
 * cfg.def.
 */
#ifndef CONFIG_CHANGE_H
#define CONFIG_CHANGE_H

#include "drive_cfg.h"

/*
 * Returns NULL when `to` may replace `from` in any state of the drive. Otherwise it returns the
 * path in drive_cfg_t of the first setting for which the drive has to be at rest with open gates,
 * as a constant string. This is a row that is REST and differs, or startup.current_hold when only
 * one of the two has a start-up. config_check() has accepted both. Pure, any context.
 */
const char *config_change_refused(const drive_cfg_t *from, const drive_cfg_t *to);

#endif
