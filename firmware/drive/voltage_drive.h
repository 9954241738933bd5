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
 * A virtual resistance damps the natural oscillation of the currents (virtual_resistance.h). Its
 * voltage is part of the demand, so the observer sees it. At the voltage limit U is reduced to make
 * room for it, because a vector that is cut off would not damp. If the current changes by more than
 * the voltage limit divided by R_v, tens of amperes, the sum still exceeds the circle.
 *
 * The dead time is compensated with the current of this tick (frame.c). A current filtered over
 * 32 ticks of 0.1 ms would be 39° late at 40 Hz. The compensation would then excite the oscillation
 * instead of leaving it alone.
 *
 * RUN begins with current control. The drive changes to voltage control when all of these hold for
 * settle_periods: the commanded speed is at least speed_min; the speed is within 1/32 of it; the
 * currents have reached their references and i_d* is zero; the lead of the voltage is within the
 * range of the compensator. With dead-time compensation the current has a lower limit, and i_d* is
 * not zero while i_q* is below it; then the change needs a load.
 *
 * Nothing limits the current here. So the drive changes back at once when the current exceeds the
 * limit of current control, when the command is not a speed, or when the speed is below 3/4 of
 * speed_min. It also changes back when lead or current has been at its lower limit for
 * settle_periods. Both changes begin with the voltage that acts, without its noise, so nothing
 * jumps. schedule.c makes them.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VOLTAGE_DRIVE_H
#define VOLTAGE_DRIVE_H

#include "io.h"
#include "state.h"

/* Current control, until the conditions above have held anew. */
void voltage_drive_reset(voltage_drive_t *vd);

/*
 * Each tick: returns the voltage to apply, Q15 of U_b. There is no current reference; the mean
 * current of the virtual resistance takes its place. current: measured current in the frame of θ̂.
 */
dq_t voltage_drive_step(voltage_drive_t *vd, const drive_t *drive, dq_t current, int32_t bus);

/*
 * Once per slow period under current control: counts the periods in which the conditions above
 * hold. Returns whether the drive changes to voltage control.
 */
bool voltage_drive_count_calm(voltage_drive_t *vd, const drive_t *drive,
                              const drive_command_t *command, dq_t current);

/* Begins with the voltage that acts, without its noise, and with the present speed reference. */
void voltage_drive_begin(voltage_drive_t *vd, const drive_t *drive);

/*
 * Once per slow period: counts the periods at a lower limit. Returns whether the drive changes back
 * to current control.
 */
bool voltage_drive_count_end(voltage_drive_t *vd, const drive_t *drive,
                             const drive_command_t *command);

/* Once per slow period that does not end it: the speed PI. bus: Q15 of U_b. */
void voltage_drive_set_magnitude(voltage_drive_t *vd, const drive_t *drive, int32_t bus);

#endif
