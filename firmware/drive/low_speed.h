/* SPDX-License-Identifier: MIT */
/*
 * Start-up and low speed, where the back-EMF is too small to find the rotor angle.
 *
 * The drive imposes a current vector at an angle of its own (open-loop I/f). The rotor follows it as a synchronous machine
 * follows its supply, displaced by the load angle. The current control is soft, so that the resistance of the windings
 * damps the swinging of the rotor, as a short circuit would. Above track_speed the observer runs free beside it. Above
 * handover_speed the observer takes over when its residual is small enough, that is, when it has found the rotor. Else
 * the start is repeated.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef LOW_SPEED_H
#define LOW_SPEED_H

#include "drive.h"

/* From READY: begin CATCH_SPIN. */
void low_speed_start(drive_t *drive);

/* One complete tick of CATCH_SPIN. May change to ALIGN, or to RUN from the next tick on. */
void low_speed_catch(drive_t *drive, const drive_in_t *in, drive_out_t *out);

/* Each tick of ALIGN, HOLD, IF_RAMP, HANDOVER: sets the imposed current. Changes the state at the end of ALIGN. */
void low_speed_step(drive_t *drive);

/* The parts of a slow period in these states. May change the state. left: ticks to the end of the period. */
void low_speed_motion(drive_t *drive, const drive_command_t *command, uint32_t left);

/* Whether the observer runs free. */
bool low_speed_tracks(const drive_t *drive);

#endif
