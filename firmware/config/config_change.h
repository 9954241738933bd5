/* SPDX-License-Identifier: MIT */
/*
 * Whether one configuration may take the place of another while current flows: the column RUN or
 * REST of cfg.def.
 */
#ifndef CONFIG_CHANGE_H
#define CONFIG_CHANGE_H

#include "drive_cfg.h"

/*
 * Returns NULL when `to` may take the place of `from` in any state of the drive. Otherwise it
 * returns the path in drive_cfg_t of the first setting for which the drive has to be at rest with
 * open gates, as a constant string: of a row that is REST and differs, or startup.current_hold when
 * one of them has a start-up and the other has none. Both are configurations that config_check()
 * accepts. Pure, any context.
 */
const char *config_change_refused(const drive_cfg_t *from, const drive_cfg_t *to);

#endif
