/* SPDX-License-Identifier: MIT */
/*
 * Start-up and low speed, where the back-EMF is too small to find the rotor angle.
 *
 * The drive imposes a current vector at an angle of its own (open-loop I/f). The rotor follows it
 * as a synchronous machine follows its supply, displaced by the load angle. The current control is
 * soft, so that the resistance of the windings damps the swinging of the rotor, as a short circuit
 * would. Above track_speed the observer is trained and no longer follows the vector. Above
 * handover_speed the observer takes over when its residual is small enough, that is, when it has
 * found the rotor. Otherwise the start is repeated. These functions decide; entry.c sets what
 * the next state needs.
 *
 * Part of the drive; called from drive_step only. A function that returns an event writes `fault`
 * only when that event is DRIVE_EVENT_FAULT.
 */
#ifndef OPEN_LOOP_H
#define OPEN_LOOP_H

#include "instant.h"
#include "io.h"
#include "state.h"

/* The user asks to run: failed starts are forgotten. */
void open_loop_forget(start_t *start);

/* FLYING_START begins, the first time or once more. */
void open_loop_reset(start_t *start);

/*
 * Another configuration is in force. A measurement that is under way begins again at the present
 * vector, because its pulses or times may have changed.
 */
void open_loop_change(start_t *start, const drive_t *drive);

/*
 * Whether the rotor has to be brought to rest before another hand-over: a start has failed before R
 * was measured. The rotor has slipped, its load drives it, and an observer with a wrong R would
 * lose it.
 */
bool open_loop_has_to_stand(const drive_t *drive);

/*
 * One complete tick of FLYING_START. STANDS: the rotor stands, or turns too slowly to be seen.
 * DRAGGED: the rotor is slow. TRACKED: the rotor is fast. FAULT: a current does not decay.
 */
drive_event_t open_loop_search(start_t *start, const drive_t *drive, const drive_in_t *in,
                               sample_t sample, drive_out_t *out, fault_t *fault);

/*
 * Each tick of ALIGN; current: measured, in the frame of the vector. start->align holds the imposed
 * current and the speed of the vector. HELD: the end of ALIGN. SEARCH: the rotor moves while R and
 * L are measured; FAULT if that was the last attempt.
 */
drive_event_t open_loop_align(start_t *start, const drive_t *drive, dq_t current, fault_t *fault);

/*
 * Each tick of HOLD, IF_RAMP and HANDOVER: returns the next imposed current. It is larger while the
 * vector moves, because it has to accelerate the rotor too.
 */
int32_t open_loop_current(const drive_t *drive);

/* Returns the angle by which the vector is ahead of the rotor. */
angle_t open_loop_load_angle(const drive_t *drive);

/*
 * Once per slow period of HOLD, IF_RAMP and HANDOVER: returns the event that follows from the speed
 * of the vector and from what the observer has found.
 */
drive_event_t open_loop_judge(start_t *start, const drive_t *drive, fault_t *fault);

/*
 * Once per slow period of RUN: forgets failed starts when RUN has lasted long enough. So a rotor
 * that is lost again and again, each time soon after the start, leads to a fault.
 */
void open_loop_count_run(start_t *start, const startup_cfg_t *cfg);

#endif
