/* SPDX-License-Identifier: MIT */
/*
 * The control tick of the states with gates on: estimate, motion loops, current control, modulation.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VECTOR_CONTROL_H
#define VECTOR_CONTROL_H

#include "drive.h"

/* The rotor is taken to be at rest at angle 0, nothing flows. The model stays as it is. */
void vector_control_reset(drive_t *drive);

/*
 * First in a tick: currents to the estimated frame, the observer. It is trained when `track`, else it follows the
 * frame's speed.
 */
void vector_control_estimate(drive_t *drive, bool track);

/* Once in a slow period: residual, flux and static part of the observer. */
void vector_control_refine(drive_t *drive);

/*
 * Last in a tick: control the current in the observer's frame in RUN, else impose it in the drive's. Enables the gates
 * and advances both angles; unless `track`, θ̂ closes up to the frame.
 */
void vector_control_close(drive_t *drive, bool track, drive_out_t *out);

/* The speed reference of the next slow period: ramp, or position profile. */
void vector_control_plan(drive_t *drive, const drive_command_t *command);

/*
 * The slow period's parts in RUN: refine, plan, speed PI and i_d*. Hands back to HOLD when it is slow and the imposed
 * current has faded in. left: ticks to the end of the period.
 */
void vector_control_motion(drive_t *drive, const drive_command_t *command, uint32_t left);

/* RUN from here on: frame, references and integrals turn to the observer's angle, nothing jumps. */
void vector_control_take_over(drive_t *drive);

#endif
