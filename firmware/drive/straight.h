/* SPDX-License-Identifier: MIT */
/*
 * An ordinary tick of RUN, before and after its slow part. Both functions call the parts that every tick calls. The compiler
 * puts these parts into them, and leaves out the branches for other states.
 *
 * Part of the drive; called from drive_step only, in RUN without a sensor.
 */
#ifndef STRAIGHT_H
#define STRAIGHT_H

#include "io.h"
#include "state.h"

/* estimate_step() with training. */
void straight_estimate(drive_t *drive);

/* The frame of the rotor from its current to compare values, and θ̂ of the next instant. */
void straight_control(drive_t *drive, drive_out_t *out);

#endif
