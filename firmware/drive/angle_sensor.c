/* SPDX-License-Identifier: MIT */
#include "angle_sensor.h"

#include "vector_control.h"

#define COUNT_TO_ANGLE (65536U)
#define ANGLE_SHIFT (3U)
#define SPEED_SHIFT (8U)

void angle_sensor_track(drive_t *drive, uint16_t count)
{
    const step_t limit = drive->model.observer.speed_limit;
    const angle_t shaft = (angle_t)count * COUNT_TO_ANGLE;
    const angle_t measured = shaft * drive->cfg->sampling.sensor_pole_pairs;
    angle_t ahead;
    int32_t error;
    step_t speed;

    if (drive->state != DRIVE_STATE_RUN) { /* there the tick before has done so */
        rotor_position_step(&drive->position, drive->observer.speed);
    }
    ahead = measured - rotor_position_angle(&drive->position);
    error = fx_signed(ahead);
    speed = fx_clamp(drive->observer.speed + fx_asr(error, SPEED_SHIFT), -limit, limit);
    rotor_position_step(&drive->position, fx_asr(error, ANGLE_SHIFT));
    nn_observer_follow(&drive->observer, speed);
    drive->frame_speed = speed;
}

void angle_sensor_start(drive_t *drive)
{
    const step_t speed = drive->observer.speed;
    rotor_position_t position = drive->position;

    vector_control_reset(drive);
    rotor_position_step(&position, speed); /* this tick controls nothing, so it ends with this */
    drive->position = position;
    nn_observer_start(&drive->observer, &drive->model.observer, speed, (dq_t){0, 0},
                      trig_sincos(rotor_position_angle(&position)));
    drive->frame_speed = speed;
    drive->speed_reference = speed;
    speed_loop_reset(&drive->speed_loop, speed);
}
