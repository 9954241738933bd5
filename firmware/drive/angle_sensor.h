/* SPDX-License-Identifier: MIT */
/*
 * The rotor's angle from a sensor on the shaft, in place of the observer's estimate.
 *
 * In every tick and every state a second-order loop follows the sensor, so that neither its steps nor its noise reach
 * speed and angle: with e = sensor − θ̂, per tick
 *     ω̂ += e/2^8,  θ̂ += ω̂ + e/2^3
 * which is critically damped with 1/16 a tick (625 rad/s at 10 kHz): half as fast, and a speed loop of 20 Hz would sway
 * on it. At a constant acceleration it lags by 256 times what the speed changes in a tick. Angle and speed are where
 * those of the observer are; its network goes with them untrained, and what it cannot explain is a wrong sensor
 * (OBSERVER_LOST).
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef ANGLE_SENSOR_H
#define ANGLE_SENSOR_H

#include "drive.h"

/* First in a tick. count: of the shaft, 2^16 = one turn, any value. */
void angle_sensor_track(drive_t *drive, uint16_t count);

/* From READY: the network starts with the rotor as it turns, nothing flows. The model stays as it is. */
void angle_sensor_start(drive_t *drive);

#endif
