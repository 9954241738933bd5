/* SPDX-License-Identifier: MIT */
/*
 * The control tick of the states with gates on: estimate, motion loops, current control, modulation.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VECTOR_CONTROL_H
#define VECTOR_CONTROL_H

#include "drive.h"

/* Start with a rotor at rest at angle 0 and zero current. The model stays as it is. */
void vector_control_reset(drive_t *drive);

/*
 * First in a tick: turns the currents into the estimated frame and runs the observer. track: the observer is trained;
 * else it follows the speed of the frame.
 */
void vector_control_estimate(drive_t *drive, bool track);

/* Once per slow period: residual, flux correction and ρ of the observer. */
void vector_control_refine(drive_t *drive);

/*
 * Last in a tick: controls the current, in RUN in the frame of the observer, else in the frame of the drive. Enables the
 * gates and advances both angles. Without `track`, θ̂ approaches the angle of the frame.
 */
void vector_control_close(drive_t *drive, bool track, drive_out_t *out);

/* Computes the speed reference of the next slow period: ramp, or position profile. */
void vector_control_plan(drive_t *drive, const drive_command_t *command);

/*
 * The parts of a slow period in RUN: refine, plan, speed PI and i_d*. Changes to HOLD when the speed is low and the
 * imposed current has risen to its level. left: ticks to the end of the period.
 */
void vector_control_motion(drive_t *drive, const drive_command_t *command, uint32_t left);

/* Change to RUN. Frame, references and integrals are turned to the angle of the observer, so that nothing jumps. */
void vector_control_take_over(drive_t *drive);

#endif
