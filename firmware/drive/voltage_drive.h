/*
 * Paper B's phase-compensated voltage drive: RUN without current regulators.
 *
 * The speed PI, (28)–(30), sets the magnitude U of the voltage, the phase compensator its angle (phase_compensator.h):
 *     U = K_p·e + K_i·∫e + ω*·φ, |U| within the voltage circle; its sign is the direction
 * The EMF at the speed asked for is fed forward, so that the PI has only what the load takes. Nothing limits the
 * current: the torque limits of derating do not act here, their faults do.
 *
 * RUN is entered with current control, or with an angle sensor at once with this. Where the configuration asks for it
 * the drive changes over when that is safe: a speed is commanded, the observer is in its range, and nothing of the
 * start-up's i_d is left. It changes back for a position and where the observer would hand back. Neither way jumps:
 * each begins with the voltage that acts.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VOLTAGE_DRIVE_H
#define VOLTAGE_DRIVE_H

#include "drive.h"

/* RUN begins at rest or in motion, without current: the voltage is the EMF. Needs an angle sensor. */
void voltage_drive_start(drive_t *drive);

/* Each tick: the voltage to apply, and the mean of the current in place of a reference of it. */
void voltage_drive_step(drive_t *drive);

/* Once a slow period: speed PI, or the change back. command: of the user; slow: the observer is to hand back. */
void voltage_drive_motion(drive_t *drive, const drive_command_t *command, bool slow);

/* Once a slow period under current control: whether it may be left, and the change. */
void voltage_drive_offer(drive_t *drive, const drive_command_t *command, bool slow);

#endif
