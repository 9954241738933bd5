/* SPDX-License-Identifier: MIT */
/*
 * PROBE: the drive measures a motor that it knows nothing of. The command's words (probe.h) say
 * which current is imposed and what is summed up; protection, limits and the winding's heat are
 * watched as ever.
 *
 * Dead time is not compensated here: what the legs lose is to be measured.
 *
 * Part of the drive; its steps are called from drive_step only.
 */
#ifndef PROBING_H
#define PROBING_H

#include "io.h"
#include "state.h"

#include <stdbool.h>

/* Before the first tick of PROBE: no current, and no word in force. */
drive_event_t probing_start(drive_t *drive);

/*
 * One tick of PROBE: measures, takes the command's word, turns the vector, and gives compare
 * values.
 */
void probing_step(drive_t *drive, const drive_command_t *command, compare_t *out);

/*
 * Whether the bus is at most at the voltage from which on RUN derates braking: the rotor may give
 * power back.
 */
bool probing_may_brake(const drive_t *drive);

#endif
