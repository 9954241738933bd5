/* SPDX-License-Identifier: MIT */
/*
 * Where three Hall signals are high while the drive turns a current vector. The identification
 * learns the order and the edges of the signals from it.
 *
 * Over whole turns of the vector, the sum of (cos θ, sin θ) over the ticks in which a signal is
 * high points to the middle of its high part, and the share of these ticks is its width. So both
 * edges are known, and a signal that is disturbed at its edges does no harm.
 */
#ifndef HALL_SURVEY_H
#define HALL_SURVEY_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

#define HALL_SURVEY_SIGNALS (3U)
/* with as many ticks no sum overflows, whatever the vector does */
#define HALL_SURVEY_TICKS_MAX (65535)

/* Of a signal, over the ticks in which it is high. */
typedef struct {
    dq_t middle;  /* sums of cos θ (d) and sin θ (q), Q15; θ: angle of the vector */
    int32_t high; /* ticks */
} hall_survey_signal_t;

typedef struct {
    uint32_t ticks;    /* of the survey, 1…HALL_SURVEY_TICKS_MAX */
    uint32_t left;     /* ticks to come, and one that only notes the turn; 0: it is complete */
    int32_t start_q16; /* angle of the vector in its first tick, Q16 turns; wraps */
    int32_t turn_q16;  /* turned since then, until the tick after the last one */
    hall_survey_signal_t signals[HALL_SURVEY_SIGNALS];
} hall_survey_t;

/* A survey of zeros is complete. Begins a survey of so many ticks, 1…HALL_SURVEY_TICKS_MAX.
 * Context: background. */
void hall_survey_begin(hall_survey_t *survey, uint32_t ticks);

static inline bool hall_survey_is_done(const hall_survey_t *survey)
{
    return survey->left == 0U;
}

/*
 * A tick of a survey that is not complete. levels: bit 0 is signal 1. turns_q16: angle of the
 * vector in this tick, Q16 turns, wrapping. Context: control interrupt.
 */
void hall_survey_step(hall_survey_t *survey, uint32_t levels, int32_t turns_q16);

#endif
