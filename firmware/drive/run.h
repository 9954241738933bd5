/* SPDX-License-Identifier: MIT */
/*
 * RUN: closed loop on the angle of the observer or the sensor. Here are the parts of RUN that run
 * once per slow period.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef RUN_H
#define RUN_H

#include "instant.h"
#include "io.h"
#include "state.h"

/* Start with a rotor at rest at angle 0 and zero current. The model stays as it is. */
void run_reset(drive_t *drive);

/*
 * As run_reset(), but with the angle and the speed of the sensor. The zero of positions stays. If
 * the last run ended in position control, the drive stays in position control.
 */
void run_reset_sensed(drive_t *drive);

/*
 * Makes the present position the zero of positions; in position control the position of the
 * profile. Call only when drive_knows_rotor() is true.
 */
void run_set_zero(drive_t *drive);

/*
 * Computes the speed reference of the next slow period: a ramp, a position profile, or the speed to
 * which a torque leads. position: of the frame in which the currents are controlled.
 */
void run_plan(drive_t *drive, const drive_command_t *command, const rotor_position_t *position);

/*
 * Whether the drive is in torque control, and only the commanded torque or an end of the window of
 * speeds decides i_q*.
 */
static inline bool run_torque_is_free(const drive_t *drive)
{
    return (drive->motion.mode == (uint8_t)DRIVE_MODE_TORQUE) && !drive->motion.torque_loop.bound;
}

/*
 * Sets i_d* of the next slow period, and the range that it leaves to i_q*. Does nothing while the
 * voltage drive is active.
 */
void run_limit(drive_t *drive, const instant_t *now);

/*
 * Runs the speed PI or the voltage drive. HELD when the speed is low and i_d* has risen to the
 * imposed current: then the vector has the direction of the present current reference.
 */
drive_event_t run_control_speed(drive_t *drive, const drive_command_t *command,
                                const instant_t *now);

#endif
