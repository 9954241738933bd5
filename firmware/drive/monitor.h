/* SPDX-License-Identifier: MIT */
/*
 * Gives the signals of the drive to supervision, derating and the guard of the configuration, and latches the faults that
 * they find.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "drive.h"

/* In every state and tick. left: ticks to the end of the slow period. A fault opens the gates in this tick. */
void monitor_step(drive_t *drive, const drive_in_t *in, uint32_t left);

#endif
