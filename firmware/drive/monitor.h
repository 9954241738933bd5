/*
 * What is watched in the course of time: gathers the drive's signals for supervision, derating and the guard of the
 * configuration, and latches what they find.
 *
 * The slow period ends with five ticks that have work of their own, so that the longest tick is shorter:
 * left 4: phases; 3: one of the checks that take turns; 2: limits of the torque; 1: planning; 0: the speed PI.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "drive.h"

/* In each tick and state. left: slow ticks to the end of the slow period. A fault opens the gates in this tick. */
void monitor_step(drive_t *drive, const drive_in_t *in, uint32_t left);

#endif
