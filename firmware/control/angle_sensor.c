/* SPDX-License-Identifier: MIT */
#include "angle_sensor.h"

#define ANGLE_SHIFT (3U)
#define SPEED_SHIFT (8U)
#define LEAD_SHIFT (6U)

static uint32_t word_of_sensor(const angle_sensor_t *sensor)
{
    const uint64_t turns = fx_unsigned64(sensor->position.turns_q32);

    return (uint32_t)(turns >> 32U) ^ rotor_position_angle(&sensor->position) ^
           fx_unsigned(sensor->speed) ^ sensor->zero ^ fx_unsigned(sensor->lead);
}

void angle_sensor_start(angle_sensor_t *sensor, int64_t turns_q32)
{
    sensor->position.turns_q32 = turns_q32;
    sensor->speed = 0;
    sensor->zero = 0U;
    sensor->lead = 0;
    sensor->check = word_of_sensor(sensor);
}

void angle_sensor_align(angle_sensor_t *sensor, rotor_position_t position)
{
    sensor->zero += rotor_position_angle(&position) - rotor_position_angle(&sensor->position);
    sensor->position = position;
    sensor->lead = 0;
    sensor->check = word_of_sensor(sensor);
}

void angle_sensor_meet(angle_sensor_t *sensor, rotor_position_t position)
{
    const angle_t ahead = rotor_position_angle(&position) - rotor_position_angle(&sensor->position);

    sensor->lead = fx_signed(ahead);
    sensor->position = position;
    rotor_position_step(&sensor->position, fx_signed(0U - ahead));
    sensor->check = word_of_sensor(sensor);
}

rotor_position_t angle_sensor_position(const angle_sensor_t *sensor)
{
    rotor_position_t position = sensor->position;

    rotor_position_step(&position, sensor->lead);
    return position;
}

bool angle_sensor_holds(const angle_sensor_t *sensor)
{
    return word_of_sensor(sensor) == sensor->check;
}

int32_t angle_sensor_step(angle_sensor_t *sensor, angle_t measured, step_t speed_limit,
                          step_t change_limit)
{
    step_t change;
    angle_t ahead;
    int32_t error;

    rotor_position_step(&sensor->position, sensor->speed);
    ahead = (measured + sensor->zero) - rotor_position_angle(&sensor->position);
    error = fx_signed(ahead);
    rotor_position_step(&sensor->position, fx_asr(error, ANGLE_SHIFT));
    change = fx_clamp(fx_asr(error, SPEED_SHIFT), -change_limit, change_limit);
    sensor->speed = fx_clamp(sensor->speed + change, -speed_limit, speed_limit);
    sensor->lead =
        fx_signed(fx_unsigned(sensor->lead) - fx_unsigned(fx_asr(sensor->lead, LEAD_SHIFT)));
    sensor->check = word_of_sensor(sensor);
    return error;
}
