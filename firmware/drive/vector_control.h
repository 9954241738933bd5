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

/* Last in a tick: control the current in the observer's frame, or impose it in the drive's frame. */
void vector_control_close(drive_t *drive, drive_out_t *out);
void vector_control_impose(drive_t *drive, bool track, drive_out_t *out);

/* The speed reference of the next slow period: ramp, or position profile. */
void vector_control_plan(drive_t *drive, const drive_command_t *command);

/* The motion loops in RUN: planning and, a tick later, speed PI and i_d*. left: as in monitor_step(). */
void vector_control_motion(drive_t *drive, const drive_command_t *command, uint32_t left);

/* In RUN: the speed asked for and the rotor's own are both so low that a current has to be imposed. */
bool vector_control_is_slow(const drive_t *drive);

/* RUN from here on: frame, references and integrals turn to the observer's angle, nothing jumps. */
void vector_control_take_over(drive_t *drive);

/* Back to an imposed current: the frame's d axis becomes the direction of the present reference. */
void vector_control_hand_back(drive_t *drive);

#endif
