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

/*
 * Call before the first tick of OFFSET_CAL. It ends a safe state. It forgets J, because J was
 * learned from the speed that the observer saw before the fault. R, L and φ stay: they were
 * measured, or lie within a range around the values of the files.
 */
drive_event_t calibration_begin(drive_t *drive);

/*
 * One tick of OFFSET_CAL. CALIBRATED: both zeros are known, each the mean of 2^offset_log2 samples.
 * FAULT: a zero is too far from mid-scale.
 */
drive_event_t calibration_step(drive_t *drive, const drive_in_t *in, fault_t *fault);

#endif
