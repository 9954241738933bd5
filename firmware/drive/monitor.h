/* SPDX-License-Identifier: MIT */
/*
 * Runs supervision, derating, and the guards of configuration and state, with the values that they
 * check.
 *
 * Part of the drive; called from drive_step only, in every state, each function once per slow
 * period. Faults as fault.h says.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "instant.h"
#include "io.h"
#include "state.h"

/* Checks the phase currents while a current is controlled. */
fault_id_t monitor_phases(watch_t *watch, const drive_t *drive, const sample_t *sample,
                          fault_t *fault);

/* In RUN, if configured: finds oscillations of the motion (oscillation.h). */
fault_id_t monitor_swing(watch_t *watch, const drive_t *drive, fault_t *fault);

/*
 * Whether an oscillation lowers the bandwidth of the speed loop instead of ending the run: that is
 * configured and has not been done since the start. Not in the voltage drive, which has another
 * speed loop.
 */
bool monitor_may_lower(const drive_t *drive);

/*
 * Runs the next of four checks that take turns: derating; late ticks, configuration and state;
 * current, from PROBE to RUN; speed and flux, in RUN.
 */
fault_id_t monitor_next_check(drive_t *drive, const drive_in_t *in, const instant_t *now,
                              fault_t *fault);

/*
 * Whether a current sample is at an end of the converter's range. The current may then be of any
 * size beyond it.
 */
bool monitor_is_saturated(const drive_t *drive, const drive_in_t *in);

/* Returns the limits of the torque current in the next slow period. bus: Q15 of U_b. */
torque_range_t monitor_derate(derating_t *derating, const drive_t *drive, int32_t bus);

/* Counts a late tick; a fault when they are too many. */
fault_id_t monitor_late(watch_t *watch, const drive_t *drive, fault_t *fault);

/* The user asks to run: the counts and means of the checks begin anew. */
void monitor_reset(watch_t *watch);

/* Call when an imposed current follows RUN. */
void monitor_forget_imposed(watch_t *watch);

/* Call when another configuration is in force. */
void monitor_forget_flux(watch_t *watch);

#endif
