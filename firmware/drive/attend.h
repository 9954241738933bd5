/* SPDX-License-Identifier: MIT */
/*
 * The part of a tick before the control: reads the sensor, obeys the command and the flags, and
 * checks the samples against their limits. It may change the state.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef ATTEND_H
#define ATTEND_H

#include "io.h"
#include "state.h"

#include <stdbool.h>

/*
 * Whether attend_step() would do no more than attend_sensor(): the drive is in RUN, without a flag,
 * the command is to run, and the samples are within their limits. Pure.
 */
bool attend_is_ordinary(const drive_t *drive, const drive_in_t *in, sample_t sample);

/*
 * Attends to the frame. Returns whether the current was controlled before this call and still is.
 */
bool attend_step(drive_t *drive, const drive_in_t *in, sample_t sample);

/*
 * Attends to the sensor that the drive has, in an ordinary tick. Returns whether the current is
 * still controlled.
 */
bool attend_sensor(drive_t *drive, const drive_in_t *in, sample_t sample);

#endif
