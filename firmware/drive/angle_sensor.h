/* SPDX-License-Identifier: MIT */
/*
 * The rotor angle from a sensor on the shaft, in place of the observer's estimate.
 *
 * In every tick and every state a second-order loop follows the sensor. It filters the steps and the noise of the sensor
 * out of speed and angle. With e = sensor − θ̂, per tick
 *     ω̂ += e/2^8,  θ̂ += ω̂ + e/2^3
 * It is critically damped at 1/16 per tick (625 rad/s at 10 kHz). With half of that a speed loop of 20 Hz would swing. At
 * a constant acceleration the angle lags by 256 times the change of speed per tick.
 *
 * Angle and speed are stored in the fields of the observer. The network runs with this speed and is not trained. A
 * current error that it cannot explain means a wrong sensor (OBSERVER_LOST).
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef ANGLE_SENSOR_H
#define ANGLE_SENSOR_H

#include "drive.h"

/* One tick of the loop; call it first in the tick. count: angle of the shaft, 2^16 = one turn, any value. */
void angle_sensor_track(drive_t *drive, uint16_t count);

/* From READY: start the network at angle and speed of the rotor, with zero current. The model stays as it is. */
void angle_sensor_start(drive_t *drive);

#endif
