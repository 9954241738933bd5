/* SPDX-License-Identifier: MIT */
/*
 * Paper B's phase-compensated voltage drive: RUN without current regulators.
 *
 * The speed PI, (28)–(30), sets the magnitude U of the voltage, the phase compensator its angle (phase_compensator.h):
 *     U = K_p·e + K_i·∫e + ω*·φ, |U| within the voltage circle; its sign is the direction
 * The EMF at the speed asked for is fed forward, so that the PI has only what the load takes.
 *
 * RUN begins with current control, and the drive changes over when that is safe: a speed of at least speed_min is
 * commanded and reached to 1/16, the currents are where they are asked for, without i_d, and the voltage lies within
 * the compensator's leads, all that for settle_periods. Where dead time makes a least current necessary i_d has to stay
 * while i_q is less, so there the load has to have it. Nothing limits the current here, so the drive changes back at once
 * where it is more than current control would let flow, and for a position or a lower speed; and where lead or current
 * have been at their lower end for settle_periods. Neither way jumps: each begins with the voltage that acts.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VOLTAGE_DRIVE_H
#define VOLTAGE_DRIVE_H

#include "drive.h"

/* Each tick: the voltage to apply, and the mean of the current in place of a reference of it. */
void voltage_drive_step(drive_t *drive);

/* Once a slow period: speed PI, or the change back. command: of the user. */
void voltage_drive_motion(drive_t *drive, const drive_command_t *command);

/* Once a slow period under current control: whether it may be left, and the change. */
void voltage_drive_offer(drive_t *drive, const drive_command_t *command);

#endif
