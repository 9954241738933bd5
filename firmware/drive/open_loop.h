/* SPDX-License-Identifier: MIT */
/*
 * Start-up and low speed, where the back-EMF is too small to find the rotor angle.
 *
 * The drive imposes a current vector at an angle of its own (open-loop I/f). The rotor follows it
 * as a synchronous machine follows its supply, displaced by the load angle. The current control is
 * soft, so that the resistance of the windings damps the swinging of the rotor, as a short circuit
 * would. Above track_speed the observer is trained and no longer follows the vector. Above
 * handover_speed the observer takes over when its residual is small enough, that is, when it has
 * found the rotor. Otherwise the start is repeated.
 *
 * Part of the drive; called from drive_step only. A function that returns an event writes `fault`
 * only when that event is DRIVE_EVENT_FAULT.
 */
#ifndef OPEN_LOOP_H
#define OPEN_LOOP_H

#include "instant.h"
#include "io.h"
#include "state.h"

/* From READY: begin FLYING_START. */
drive_event_t open_loop_start(drive_t *drive);

/*
 * One complete tick of FLYING_START. STANDS: the rotor stands, or turns too slowly to be seen.
 * DRAGGED: the rotor is slow; the vector has its angle and its speed. TRACKED: the rotor is fast.
 * These three act from the next tick on. FAULT: a current does not decay.
 */
drive_event_t open_loop_flying_start(drive_t *drive, const drive_in_t *in, sample_t sample,
                                     drive_out_t *out, fault_t *fault);

/*
 * Each tick of ALIGN, HOLD, IF_RAMP, HANDOVER: sets the imposed current. Returns HELD at the end of
 * ALIGN, and SEARCH when the rotor moves while R and L are measured, or FAULT if that was the last
 * attempt.
 */
drive_event_t open_loop_step(drive_t *drive, const instant_t *now, fault_t *fault);

/* Sets the speed reference of the next slow period; not in ALIGN. */
void open_loop_plan(drive_t *drive, const drive_command_t *command);

/*
 * Sets the speed of the vector for the next slow period. Returns the event that follows from this
 * speed; not in ALIGN.
 */
drive_event_t open_loop_drag(drive_t *drive, fault_t *fault);

#endif
