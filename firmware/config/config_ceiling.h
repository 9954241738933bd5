/* SPDX-License-Identifier: MIT */
/*
 * What no other configuration lifts: the limits by which the image protects the board, and the
 * motor that it was made for.
 *
 * A configuration comes over a line or out of the flash. config_check.h says whether the drive can
 * run with it, not whether the board bears it. The image was made from the files of board and
 * motor, so its limits are those that their author has written.
 *
 * Of the board: the over-current, the highest bus, the offset of a current sensor, and the
 * temperature: the count at which no current is left, on which side of it the stage is hot, how
 * long that may last, and which counts a whole sensor has. Of the motor: its largest and its
 * continuous current, and i²t: heat, time constant and limit.
 *
 * Pure. Context: background.
 */
#ifndef CONFIG_CEILING_H
#define CONFIG_CEILING_H

#include "drive_cfg.h"

#include <stdbool.h>

/*
 * Returns the path of the first setting of `cfg` that protects less than that of the image, a
 * constant string; NULL: none does. with_motor: the image was made for the motor that is connected,
 * so the motor's limits count too. Both configurations are good by config_check.h.
 */
const char *config_ceiling_crossed(const drive_cfg_t *image, const drive_cfg_t *cfg,
                                   bool with_motor);

#endif
