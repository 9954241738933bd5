/* SPDX-License-Identifier: MIT */
/*
 * OFFSET_CAL: measures the zeros of the current sensors, and their noise, while the gates are open.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef CALIBRATION_H
#define CALIBRATION_H

#include "io.h"
#include "state.h"

/*
 * Zero of a sensor before the calibration, Q15 of I_b: mid-scale, as I_b is twice the converter's
 * full scale.
 */
#define CALIBRATION_NOMINAL_Q15 (16384)

/* Call before the first tick of OFFSET_CAL. The zeros in force stay until the calibration ends. */
void calibration_begin(sensors_t *sensors);

/* Another configuration begins: the zeros hold in any scale, so those of `before` stay in force. */
void calibration_keep(sensors_t *sensors, const sensors_t *before);

/*
 * One tick of OFFSET_CAL. CALIBRATED: both zeros are known, each the mean of 2^offset_log2 samples.
 * FAULT: a zero is too far from mid-scale.
 */
drive_event_t calibration_step(sensors_t *sensors, const drive_cfg_t *cfg, const drive_in_t *in,
                               fault_t *fault);

#endif
