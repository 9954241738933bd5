/* SPDX-License-Identifier: MIT */
/*
 * Gives the signals of the drive to supervision, derating and the guard of the configuration.
 *
 * Part of the drive; called from drive_step only, in every state, once per slow period each. Faults as fault.h says.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "state.h"

/* The currents of the phases, where a current is controlled, and in RUN what swings. */
fault_id_t monitor_phases(drive_t *drive, fault_t *fault);

/*
 * The next of four checks that take turns: derating; late ticks and configuration; current, from ALIGN to RUN; speed, in
 * RUN.
 */
fault_id_t monitor_next_check(drive_t *drive, uint16_t adc_temperature, fault_t *fault);

/* The limits of the torque current in the next slow period. */
void monitor_limits(drive_t *drive);

#endif
