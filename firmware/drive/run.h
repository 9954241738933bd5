/* SPDX-License-Identifier: MIT */
/*
 * RUN: closed loop on the angle of the observer or the sensor. Its parts of a slow period.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef RUN_H
#define RUN_H

#include "io.h"
#include "state.h"

/* Start with a rotor at rest at angle 0 and zero current. The model stays as it is. */
void run_reset(drive_t *drive);

/*
 * The same at the angle and the speed that the sensor shows. The zero of positions stays, and
 * position control where the last run ended in it.
 */
void run_reset_sensed(drive_t *drive);

/* Positions count from here on. Call it where drive_knows_rotor(). */
void run_set_zero(drive_t *drive);

/*
 * Computes the speed reference of the next slow period: ramp, position profile, or what a torque
 * leads to. position: of the frame in which the currents are controlled.
 */
void run_plan(drive_t *drive, const drive_command_t *command, const rotor_position_t *position);

/* In torque control nothing but the torque decides i_q*, or an end of the window of speeds. */
static inline bool run_torque_is_free(const drive_t *drive)
{
    return (drive->mode == (uint8_t)DRIVE_MODE_TORQUE) && !drive->torque_loop.bound;
}

/* i_d* of the next slow period, and what it leaves to i_q*. Nothing with the voltage drive. */
void run_limit(drive_t *drive);

/*
 * Speed PI, or the voltage drive. HELD when the speed is low and i_d* has risen to the imposed
 * current: then it has set the vector on the present current.
 */
drive_event_t run_control_speed(drive_t *drive, const drive_command_t *command);

#endif
