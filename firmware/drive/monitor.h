/* SPDX-License-Identifier: MIT */
/*
 * Gives the signals of the drive to supervision, derating and the guard of the configuration.
 *
 * Part of the drive; called from drive_step only, in every state, once per slow period each. Faults
 * as fault.h says.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "io.h"
#include "state.h"

/* The currents of the phases, where a current is controlled, and in RUN what swings. */
fault_id_t monitor_phases(drive_t *drive, fault_t *fault);

/*
 * The next of four checks that take turns: derating; late ticks and configuration; current, from
 * ALIGN to RUN; speed, in RUN.
 */
fault_id_t monitor_next_check(drive_t *drive, const drive_in_t *in, fault_t *fault);

/*
 * Whether a current is at an end of its converter's range, which says nothing of how large it is.
 */
bool monitor_is_saturated(const drive_t *drive, const drive_in_t *in);

/* The limits of the torque current in the next slow period. */
void monitor_limits(drive_t *drive);

#endif
