/* SPDX-License-Identifier: MIT */
#include "angle_sensor.h"

#define ANGLE_SHIFT (3U)
#define SPEED_SHIFT (8U)

void angle_sensor_step(angle_sensor_t *sensor, angle_t measured, step_t speed_limit)
{
    angle_t ahead;
    int32_t error;

    rotor_position_step(&sensor->position, sensor->speed);
    ahead = measured - rotor_position_angle(&sensor->position);
    error = fx_signed(ahead);
    rotor_position_step(&sensor->position, fx_asr(error, ANGLE_SHIFT));
    sensor->speed = fx_clamp(sensor->speed + fx_asr(error, SPEED_SHIFT), -speed_limit, speed_limit);
}
