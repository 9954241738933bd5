/* SPDX-License-Identifier: MIT */
/*
 * What the drive knows of the rotor: its angle θ̂ in `position` and its speed ω̂ in `observer.speed`.
 *
 * The network of the observer runs in every tick that controls a current. Its weight W2 is the
 * speed, and there are three sources for it:
 *     observer   in RUN, and above track_speed: the network is trained (22)
 *     sensor     when the board has one: the network is given the speed of the sensor. config_check
 *                asks for rates of 0 then, so that the training leaves that speed as it is. A
 *                current error that the network cannot explain means that the sensor is wrong
 *                (OBSERVER_LOST)
 *     vector     at low speed: the network is given the speed of the imposed vector, and θ̂
 *                approaches its angle
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef ESTIMATE_H
#define ESTIMATE_H

#include "state.h"

/* Start at this speed and this current (Q15 of I_b, in the frame of θ̂). θ̂ stays. */
void estimate_start(drive_t *drive, step_t speed, dq_t current);

/*
 * Sets θ̂ and ω̂ to the angle and the speed of the sensor. Call it first in each tick of a drive with
 * a sensor, in every state. count: 2^16 = one turn of the shaft.
 */
void estimate_sense(drive_t *drive, uint16_t count);

/*
 * From READY with a sensor: start with the angle and the speed of the rotor, and without current.
 */
void estimate_start_sensed(drive_t *drive);

/* Whether the network is trained in this tick. */
bool estimate_is_trained(const drive_t *drive);

/*
 * Returns the voltage that acted since the last instant, Q15 of U_b, saturated to 16 bits: the
 * ratio (Q15 of the bus) that acted, times the mean of the bus voltages at both instants. Pure.
 */
ab_t estimate_applied_voltage(ab_t ratio, int32_t bus_before, int32_t bus_now);

/*
 * In a tick that controls a current: runs the network. Returns the measured current in the frame of
 * θ̂, Q15 of I_b, ±34400.
 */
dq_t estimate_step(drive_t *drive, sample_t sample, bool trained);

/*
 * Call last in a tick that controls a current: advances θ̂ to the next instant (23). If the network
 * is not trained, θ̂ also approaches the angle of the vector.
 */
void estimate_advance(drive_t *drive, bool trained);

/*
 * Once per slow period: updates the residual and the flux correction, and calls
 * nn_observer_refresh().
 */
void estimate_refine(drive_t *drive);

#endif
