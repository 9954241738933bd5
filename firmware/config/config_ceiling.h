/* SPDX-License-Identifier: MIT */
/*
 * The ceiling: the limits of the image, which no other configuration may exceed. They protect the
 * board, and the motor that the image was made for.
 *
 * A configuration comes over a line or out of the flash. config_check.h says whether the drive can
 * run with it, not whether the board bears it. The image was made from the files of board and
 * motor, so its limits are the ones that the author of these files has written.
 *
 * Limits of the board: the over-current, the highest bus, the offset of a current sensor, and four
 * of the temperature: the count at which the current is reduced to 0, on which side of that count
 * the stage is hot, how long this may last, and which counts a working sensor can have. A drive
 * that uses an angle sensor has to name it in sensor.kind, unless the image does not either. Limits
 * of the motor: its largest and its continuous current, and i²t with heat, time constant and limit.
 *
 * Pure. Context: background.
 */
#ifndef CONFIG_CEILING_H
#define CONFIG_CEILING_H

#include "drive_cfg.h"

#include <stdbool.h>

/*
 * Returns the path of the first setting of `cfg` that protects less than the setting of the image,
 * a constant string; NULL: there is none. with_motor: the image was made for the motor that is
 * connected, so the limits of the motor count too. config_check() has accepted both configurations.
 */
const char *config_ceiling_crossed(const drive_cfg_t *image, const drive_cfg_t *cfg,
                                   bool with_motor);

#endif
