/* SPDX-License-Identifier: MIT */
/*
 * With these functions a plan of the identification sets current, window and gains of the next
 * experiment, or ends its phase.
 */
#ifndef IDENTIFY_AIM_H
#define IDENTIFY_AIM_H

#include "identify_state.h"

/*
 * Length of a window: four periods of the 100 Hz ripple of a rectified mains, so that the ripple
 * does not change a mean.
 */
#define IDENTIFY_AIM_WINDOW_MS (40)

/*
 * Returns the continuous current of the name plate, Q15 of I_b. After the pulses it is limited to
 * stiff_current, because of the rotor's saliency.
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

/* Returns `value`, limited to least…most. */
static inline int32_t identify_aim_bounded(int64_t value, int32_t least, int32_t most)
{
    const int64_t above = (value > (int64_t)least) ? value : (int64_t)least;
    const int64_t bounded = (above < (int64_t)most) ? above : (int64_t)most;

    return (int32_t)bounded;
}

/* Sets a word of the next experiment. A word that no plan sets keeps its last value. */
static inline void identify_aim_set(identify_t *identify, probe_word_t which, int32_t value)
{
    identify->aim.words[(uint32_t)which - (uint32_t)PROBE_CURRENT] = value;
}

/* Returns a word as it was set last: until the plan sets it anew, it is of the last experiment. */
static inline int32_t identify_aim_word(const identify_t *identify, probe_word_t which)
{
    return identify->aim.words[(uint32_t)which - (uint32_t)PROBE_CURRENT];
}

static inline int32_t identify_aim_asked_current(const identify_t *identify)
{
    return identify_aim_word(identify, PROBE_CURRENT);
}

/* Sets the current of the next experiment, without pulses. */
void identify_aim_current(identify_t *identify, int32_t current);

/*
 * Sets the first word of the next experiment's record, its ticks to settle, and the ticks of its
 * window.
 */
void identify_aim_window(identify_t *identify, const char *kind, int32_t settle, int32_t ticks);

typedef enum {
    IDENTIFY_GAINS_FIRM = 0,
    /* weak across the current, so that the winding's resistance damps a rotor that swings */
    IDENTIFY_GAINS_SOFT,
    /*
     * with a quick integral, because the EMF changes in the frame while the frame turns towards a
     * rotor that lags
     */
    IDENTIFY_GAINS_QUICK
} identify_gains_t;

/* Sets the gains of the current control for the measured L. */
void identify_aim_gains(identify_t *identify, identify_gains_t gains);

void identify_aim_phase(identify_t *identify, identify_phase_t phase);

/*
 * Returns whether the continuous current is large enough for the sensors. If it is not, ends the
 * identification. why: the reason, a constant text; the last line adds the current that is needed.
 */
bool identify_aim_is_enough(identify_t *identify, const char *why);

/*
 * Ends the identification. why: the reason, a constant text. In HALL all else is measured already,
 * so it ends well there; the records then lack a direction.
 */
void identify_aim_refusal(identify_t *identify, const char *why);

/*
 * Ends the identification; after the reason the last line says `detail`, the name of a phase or a
 * fault.
 */
void identify_aim_refusal_of(identify_t *identify, const char *why, const char *detail);

#endif
