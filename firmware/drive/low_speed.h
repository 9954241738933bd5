/* SPDX-License-Identifier: MIT */
/*
 * What the drive does below the speed at which the back-EMF tells the rotor's angle.
 *
 * A current vector is imposed whose angle the drive sets; the rotor follows it like a synchronous machine follows
 * its supply, displaced by the load angle. The current control is soft, so that the windings' resistance damps
 * the rotor's swinging as a short circuit would. Above track_speed the observer runs free beside it; above
 * handover_speed it takes over when its residual says that it has found the rotor, else the start is repeated.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef LOW_SPEED_H
#define LOW_SPEED_H

#include "drive.h"

/* From READY: look for a rotor that turns. */
void low_speed_start(drive_t *drive);

/* One tick of CATCH_SPIN, the whole of it. May end in ALIGN, or in RUN from the next tick on. */
void low_speed_catch(drive_t *drive, const drive_in_t *in, drive_out_t *out);

/* Each tick of ALIGN, HOLD, IF_RAMP, HANDOVER: the imposed current. The end of ALIGN changes the state. */
void low_speed_step(drive_t *drive);

/* The slow period's parts in these states; may change the state. left: ticks to the end of the period. */
void low_speed_motion(drive_t *drive, const drive_command_t *command, uint32_t left);

/* Whether the observer runs free. */
bool low_speed_tracks(const drive_t *drive);

#endif
