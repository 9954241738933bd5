/* SPDX-License-Identifier: MIT */
/*
 * The current vector that the drive imposes below RUN: its angle, its speed, and the mean of the
 * measured current in its frame.
 *
 * Part of the drive; called from drive_step only.
 */
#ifndef VECTOR_H
#define VECTOR_H

#include "state.h"

/* The vector lies at angle 0, at rest, without a current. */
void vector_reset(current_vector_t *vector);

/* Place the vector: at this position, with this speed, and with this measured current. */
void vector_place(current_vector_t *vector, rotor_position_t position, step_t step, dq_t current);

/*
 * After vector_reset(): place the vector one sweep away from angle 0, so that a sweep of the
 * alignment ends at angle 0. sweep: 2^32 = one turn; backwards: the sweep turns backwards.
 */
void vector_draw_back(current_vector_t *vector, angle_t sweep, bool backwards);

/* Set the turn of the vector per tick. */
void vector_move(current_vector_t *vector, step_t step);

/*
 * Each tick: returns the measured current in the frame of the vector, Q15 of I_b, ±34400, and
 * filters it into current_mean. The dead-time compensation must not use the measured current of a
 * leg that the dead time itself holds at zero; so the sign comes from the filtered vector.
 */
dq_t vector_measure(current_vector_t *vector, sample_t sample);

/* Last in a tick: turns the vector to its angle at the next instant. */
void vector_advance(current_vector_t *vector);

#endif
