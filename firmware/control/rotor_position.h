/* SPDX-License-Identifier: MIT */
/*
 * Rotor position by integration of the speed, paper A (23). The paper prints θ̂(k+1) = θ̂(k) +
 * T·ω̂(k). The drive departs from it and advances θ̂ with ω̂(k+1), the result of the training of the
 * same tick. The observer needs this newer speed to be stable (nn_observer.h).
 *
 * The speed is a step_t (advance per tick), so T·ω̂ is the step itself and the integration is exact:
 * no rounding, no drift. Whole electrical turns are counted as well, ±2^31 of them.
 * Pure; call from the control interrupt.
 */
#ifndef ROTOR_POSITION_H
#define ROTOR_POSITION_H

#include "fx.h"

#include <stdint.h>

typedef struct {
    int64_t turns_q32; /* electrical turns since the reset, Q32; the lower word is the angle */
} rotor_position_t;

/* Set the position to `angle` within turn 0. */
static inline void rotor_position_reset(rotor_position_t *position, angle_t angle)
{
    position->turns_q32 = (int64_t)angle;
}

/*
 * Advances the position by one tick, (23). The turn count wraps after 2^31 turns (8 days at 3000
 * turns a second).
 */
static inline void rotor_position_step(rotor_position_t *position, step_t speed)
{
    const int64_t advance = speed;
    const uint64_t turns = fx_unsigned64(position->turns_q32) + fx_unsigned64(advance);

    position->turns_q32 = fx_signed64(turns);
}

/* Returns θ̂ within its turn. */
static inline angle_t rotor_position_angle(const rotor_position_t *position)
{
    return (angle_t)(fx_unsigned64(position->turns_q32) & 0xFFFFFFFFU);
}

/* Returns the position in Q16 electrical turns; it wraps after 2^15 turns. */
static inline int32_t rotor_position_turns_q16(const rotor_position_t *position)
{
    const uint64_t turns_q16 = fx_unsigned64(position->turns_q32) >> 16U;

    return fx_signed((uint32_t)(turns_q16 & 0xFFFFFFFFU));
}

#endif
