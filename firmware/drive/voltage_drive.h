/* SPDX-License-Identifier: MIT */
/*
 * Paper B's phase-compensated voltage drive: RUN without current regulators.
 *
 * The speed PI, (28)–(30), sets the magnitude U of the voltage. The phase compensator sets its
 * angle (phase_compensator.h):
 *     U = K_p·e + K_i·∫e + ω*·φ, |U| within the voltage circle; the sign of U is the direction of
 *         rotation
 * The EMF at the commanded speed is fed forward, so the PI only has to supply the voltage that the
 * load needs.
 *
 * A virtual resistance damps the currents' own mode (virtual_resistance.h). Its voltage is part of
 * the demand, so the observer sees it. At the voltage limit U gives way to it: a vector that is cut
 * off would not damp. A change of more than the voltage limit divided by R_v, tens of amperes,
 * still goes beyond the circle.
 *
 * The dead time is compensated by the current of this tick (frame.c). A filtered current is late:
 * by 39° at 40 Hz and 32 ticks of 0.1 ms. Then the compensation feeds the mode that it should not
 * see.
 *
 * RUN begins with current control. The drive changes to voltage control when all of these hold for
 * settle_periods: the commanded speed is at least speed_min; the speed has reached it to 1/32; the
 * currents have reached their references and i_d is zero; the voltage lies within the range of the
 * compensator's lead. With dead-time compensation there is a least current, and i_d is not zero
 * while i_q is below it; then the change needs a load.
 *
 * Nothing limits the current here. So the drive changes back at once when the current exceeds the
 * limit of current control, and for a position command or a speed below speed_min. It also changes
 * back when lead or current have been at their lower limit for settle_periods. Both changes begin
 * with the voltage that acts, without its noise, so nothing jumps.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VOLTAGE_DRIVE_H
#define VOLTAGE_DRIVE_H

#include "io.h"
#include "state.h"

/*
 * Each tick: sets the voltage to apply. The mean of the virtual resistance stands for a current
 * reference.
 */
void voltage_drive_step(drive_t *drive);

/* Once per slow period: speed PI, or the change back to current control. */
void voltage_drive_motion(drive_t *drive, const drive_command_t *command);

/*
 * Changes back to current control: the integrals are set to the voltage less that of the model, the
 * torque current to the present one.
 */
void voltage_drive_end(drive_t *drive);

/*
 * Once per slow period under current control: checks the conditions above and changes to voltage
 * control.
 */
void voltage_drive_offer(drive_t *drive, const drive_command_t *command);

#endif
