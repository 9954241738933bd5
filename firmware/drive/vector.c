/* SPDX-License-Identifier: MIT */
#include "vector.h"

#include "trig.h"

#define MEAN_SHIFT (5U) /* the mean of the measured current has a time constant of 2^5 ticks */

void vector_reset(current_vector_t *vector)
{
    *vector = (current_vector_t){.step = 0};
}

void vector_place(current_vector_t *vector, rotor_position_t position, step_t step, dq_t current)
{
    vector->position = position;
    vector->step = step;
    vector->current_mean = current;
}

void vector_draw_back(current_vector_t *vector, angle_t sweep, bool backwards)
{
    const int64_t way = (int64_t)sweep;

    rotor_position_reset(&vector->position, 0U);
    vector->position.turns_q32 -= backwards ? -way : way;
}

void vector_move(current_vector_t *vector, step_t step)
{
    vector->step = step;
}

dq_t vector_measure(current_vector_t *vector, sample_t sample)
{
    const angle_t frame = rotor_position_angle(&vector->position);
    /*@ assert SECTORS(frame); */
    dq_t *const mean = &vector->current_mean;
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    const dq_t current = transforms_park(current_ab, trig_sincos(frame));

    mean->d = fx_approach(mean->d, fx_sat15(current.d), MEAN_SHIFT);
    mean->q = fx_approach(mean->q, fx_sat15(current.q), MEAN_SHIFT);
    return current;
}

void vector_advance(current_vector_t *vector)
{
    rotor_position_step(&vector->position, vector->step);
}
