/* SPDX-License-Identifier: MIT */
/*
 * PROBE: the drive measures an unknown motor. The command's words (probe.h) say which current is
 * imposed and when the sums are formed. Protection, limits and the heat of the winding are watched
 * as in any other state.
 *
 * The dead time is not compensated here, because the voltage that the legs lose is to be measured.
 *
 * Part of the drive; its steps are called from drive_step only.
 */
#ifndef PROBING_H
#define PROBING_H

#include "io.h"
#include "state.h"

#include <stdbool.h>

/*
 * One tick of PROBE: measures, takes the command's word, turns the vector, and writes the compare
 * values. Returns the measured current in the frame of the vector, Q15 of I_b, ±34400.
 */
dq_t probing_step(drive_t *drive, const drive_command_t *command, sample_t sample, compare_t *out);

/*
 * Whether the rotor may give power back: the bus is not above the voltage at which RUN begins to
 * derate the braking current.
 */
bool probing_may_brake(const drive_t *drive);

/* The current of the last tick of PROBE in the frame of the vector, Q15 of I_b, ±34400. */
dq_t probing_current(const drive_t *drive);

#endif
