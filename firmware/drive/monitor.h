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

/*
 * Checks the phase currents while a current is controlled. In RUN also finds oscillations
 * (oscillation.h).
 */
fault_id_t monitor_phases(drive_t *drive, const sample_t *sample, fault_t *fault);

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

/* Sets the limits of the torque current in the next slow period. bus: Q15 of U_b. */
void monitor_limits(drive_t *drive, int32_t bus);

#endif
