/* SPDX-License-Identifier: MIT */
/*
 * What a plan of the identification asks for: current, window and gains of the next experiment, or
 * the end of its phase.
 */
#ifndef IDENTIFY_AIM_H
#define IDENTIFY_AIM_H

#include "identify_state.h"

/*
 * A rectified mains of 100 Hz has so many of its periods in it: its ripple does not count in a
 * mean.
 */
#define IDENTIFY_AIM_WINDOW_MS (40)

/*
 * Continuous current of the name plate, from the pulses on within what the saliency allows, Q15 of
 * I_b.
 */
static inline int32_t identify_aim_continuous(const identify_t *identify)
{
    const int32_t continuous = identify->app->drive.cfg->derating.current_continuous;
    const int32_t stiff = identify->rest.stiff_current;

    return ((stiff > 0) && (stiff < continuous)) ? stiff : continuous;
}

static inline const probe_sums_t *identify_aim_sums(const identify_t *identify)
{
    return &identify->app->drive.probe.sums;
}

/* value, limited to what it may be. */
static inline int32_t identify_aim_bounded(int64_t value, int32_t least, int32_t most)
{
    const int64_t above = (value > (int64_t)least) ? value : (int64_t)least;
    const int64_t bounded = (above < (int64_t)most) ? above : (int64_t)most;

    return (int32_t)bounded;
}

/* The current of the next experiment, or of the one that has ended. */
static inline int32_t identify_aim_asked_current(const identify_t *identify)
{
    return identify->aim.words[0];
}

/* A word of the next experiment, or of the one that has ended. */
static inline int32_t *identify_aim_word(identify_t *identify, probe_word_t which)
{
    return &identify->aim.words[(uint32_t)which - (uint32_t)PROBE_CURRENT];
}

/* The current of the next experiment, without pulses. */
void identify_aim_current(identify_t *identify, int32_t current);

/* Its record's first word, ticks to settle, and ticks of its window. */
void identify_aim_window(identify_t *identify, const char *kind, int32_t settle, int32_t ticks);

typedef enum {
    IDENTIFY_GAINS_FIRM = 0,
    /* weak across the current: the winding's resistance damps a rotor that swings */
    IDENTIFY_GAINS_SOFT,
    /* with a quick integral: the frame turns to a rotor that lags, and its EMF with it */
    IDENTIFY_GAINS_QUICK
} identify_gains_t;

/* Gains of the current control for the measured L. */
void identify_aim_gains(identify_t *identify, identify_gains_t gains);

void identify_aim_phase(identify_t *identify, identify_phase_t phase);

/*
 * Whether the sensors show enough of the continuous current. If not, the end: the reason as text
 * that outlives it, behind which the current is said that it takes.
 */
bool identify_aim_is_enough(identify_t *identify, const char *why);

/* Ends it, with the reason as text that outlives it. */
void identify_aim_refusal(identify_t *identify, const char *why);

/* The same, with the name of what it is about behind the reason. */
void identify_aim_refusal_of(identify_t *identify, const char *why, const char *detail);

#endif
