/* SPDX-License-Identifier: MIT */
/*
 * Between the run of an experiment (identify.c) and those who plan them (identify_rest.c, identify_turn.c).
 *
 * A plan looks at the sums of the experiment that has ended, and aims the next one. It returns whether it did: if not, it
 * has changed the phase, and the plan of that phase is next.
 */
#ifndef IDENTIFY_PLAN_H
#define IDENTIFY_PLAN_H

#include "identify.h"

/* A rectified mains of 100 Hz has so many of its periods in it: its ripple does not count in a mean. */
#define IDENTIFY_WINDOW_MS (40U)

/* Continuous current of the name plate, Q15 of I_b. */
static inline int32_t identify_continuous(const identify_t *identify)
{
    return identify->app->drive.cfg->derating.current_continuous;
}

static inline const probe_sums_t *identify_sums(const identify_t *identify)
{
    return &identify->app->drive.probe.sums;
}

/* A word of the next experiment, or of the one that has ended. */
static inline int32_t *identify_word(identify_t *identify, probe_word_t which)
{
    return &identify->aim.words[(uint32_t)which - (uint32_t)PROBE_CURRENT];
}

/* The current of the next experiment, without pulses. */
void identify_aim_current(identify_t *identify, int32_t current);

/* Its record's first word, ticks to settle, and ticks of its window. */
void identify_aim_window(identify_t *identify, const char *kind, uint32_t settle, uint32_t ticks);

/* Gains of the current control for the measured L. soft: R alone damps the swings of a rotor at rest, as the current across is left to itself. */
void identify_aim_gains(identify_t *identify, bool soft);

void identify_next_phase(identify_t *identify, identify_phase_t phase);

/* Ends it, with the reason as text that outlives it. */
void identify_refuse(identify_t *identify, const char *why);

/* Largest current of STILL, current and highest speed of SPIN: known from the beginning. Q15 of I_b, steps per tick. */
int32_t identify_largest_still(const identify_t *identify);
int32_t identify_spin_current(const identify_t *identify);
step_t identify_top_speed(const identify_t *identify);

/* The plans, see above. */
bool identify_plan_pulse(identify_t *identify);
bool identify_plan_catch(identify_t *identify);
bool identify_plan_still(identify_t *identify);
bool identify_plan_spin(identify_t *identify);
bool identify_plan_ramp(identify_t *identify);
bool identify_plan_coast(identify_t *identify);

#endif
