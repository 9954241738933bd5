/* SPDX-License-Identifier: MIT */
/*
 * The rotor angle from a sensor on the shaft.
 *
 * A second-order loop follows the sensor. It filters the steps and the noise of the sensor out of
 * speed and angle. With e = sensor − θ̂, per tick
 *     ω̂ += e/2^8,  θ̂ += ω̂ + e/2^3
 * It is critically damped at 1/16 per tick (625 rad/s at 10 kHz). With half of that bandwidth a
 * speed loop of 20 Hz would swing. At a constant acceleration the angle lags by 256 times the
 * change of speed per tick.
 *
 * The position may lead that of the loop at first, so that θ̂ does not jump when the sensor takes
 * over. The lead decays with a time constant of 64 ticks.
 *
 * Pure, total; call from the control interrupt.
 */
#ifndef ANGLE_SENSOR_H
#define ANGLE_SENSOR_H

#include "rotor_position.h"

#include <stdbool.h>

typedef struct {
    rotor_position_t position; /* of the loop at this instant */
    step_t speed;              /* ω̂ from this instant to the next, within ±speed_limit */
    angle_t zero;              /* electrical angle of the rotor where the sensor reads 0 */
    int32_t lead;              /* of θ̂ against the position of the loop */
    uint32_t check;            /* check word of the fields above, see angle_sensor_holds() */
} angle_sensor_t;

/* Start at this position, at rest. The sensor reads 0 at angle 0. */
void angle_sensor_start(angle_sensor_t *sensor, int64_t turns_q32);

/* The rotor rests at this position: moves the zero, so that the loop is there too. */
void angle_sensor_align(angle_sensor_t *sensor, rotor_position_t position);

/*
 * The rotor was taken to be at this position up to now. The loop goes on in the turn in which it is
 * nearest to it, and θ̂ begins there.
 */
void angle_sensor_meet(angle_sensor_t *sensor, rotor_position_t position);

/* Returns θ̂ and the whole turns. Pure. */
rotor_position_t angle_sensor_position(const angle_sensor_t *sensor);

/*
 * Whether the fields are as a function here has written them last. A bit that has flipped by itself
 * makes it false: half a turn more would reverse the torque for some ticks. A sensor whose words
 * are all zero holds.
 */
bool angle_sensor_holds(const angle_sensor_t *sensor);

/*
 * One tick of the loop. measured: electrical angle from the sensor's zero, any value. |ω̂| saturates
 * at speed_limit, 1…2^29, and its change in the tick at change_limit, 1…2^29: what a sensor
 * corrects at once, as Hall sensors do, is no motion. Returns e, how far the measured angle lies
 * ahead of the expected one.
 */
int32_t angle_sensor_step(angle_sensor_t *sensor, angle_t measured, step_t speed_limit,
                          step_t change_limit);

#endif
