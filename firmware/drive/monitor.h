/* SPDX-License-Identifier: MIT */
/*
 * What is watched in the course of time: gathers the drive's signals for supervision, derating and the guard of the
 * configuration, and latches what they find.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "drive.h"

/* In every state, the monitor's parts of a slow period that ends after `left` more ticks. A fault opens the gates in this tick. */
void monitor_step(drive_t *drive, const drive_in_t *in, uint32_t left);

#endif
