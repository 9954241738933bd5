/* SPDX-License-Identifier: MIT */
#include "angle_sensor.h"

#define ANGLE_SHIFT (3U)
#define SPEED_SHIFT (8U)

static uint32_t word_of_sensor(const angle_sensor_t *sensor)
{
    const uint64_t turns = fx_unsigned64(sensor->position.turns_q32);

    return (uint32_t)(turns >> 32U) ^ rotor_position_angle(&sensor->position) ^
           fx_unsigned(sensor->speed);
}

void angle_sensor_start(angle_sensor_t *sensor, int64_t turns_q32)
{
    sensor->position.turns_q32 = turns_q32;
    sensor->speed = 0;
    sensor->check = word_of_sensor(sensor);
}

bool angle_sensor_holds(const angle_sensor_t *sensor)
{
    return word_of_sensor(sensor) == sensor->check;
}

void angle_sensor_step(angle_sensor_t *sensor, angle_t measured, step_t speed_limit)
{
    angle_t ahead;
    int32_t error;

    rotor_position_step(&sensor->position, sensor->speed);
    ahead = measured - rotor_position_angle(&sensor->position);
    error = fx_signed(ahead);
    rotor_position_step(&sensor->position, fx_asr(error, ANGLE_SHIFT));
    sensor->speed = fx_clamp(sensor->speed + fx_asr(error, SPEED_SHIFT), -speed_limit, speed_limit);
    sensor->check = word_of_sensor(sensor);
}
