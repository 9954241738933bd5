/* SPDX-License-Identifier: MIT */
/*
 * Checks whether the arithmetic can work with a configuration: first the ranges of cfg.def, then
 * the rules between two settings.
 */
#ifndef CONFIG_CHECK_H
#define CONFIG_CHECK_H

#include "drive_cfg.h"

/*
 * Check every setting but crc. Returns NULL when all are right. Otherwise it returns the path in
 * drive_cfg_t of the first one that is not, as a constant string ("startup.align.sweep_speed").
 * Pure, any context.
 */
const char *config_check(const drive_cfg_t *cfg);

#endif
