/* SPDX-License-Identifier: MIT */
/*
 * Experiments on a rotor that turns: SPIN, RAMP, COAST, HALL.
 *
 * A plan looks at the sums of the experiment that has ended, and sets up the next one. It returns
 * true if it has set one up. Otherwise it has changed the phase, and the plan of the new phase has
 * to be called. Context: background.
 */
#ifndef IDENTIFY_TURN_H
#define IDENTIFY_TURN_H

#include "identify_state.h"

#include <stdbool.h>

/*
 * identify_turn_current() returns the current of SPIN, Q15 of I_b; under load the continuous
 * current replaces it. identify_turn_speed() returns the highest speed of the vector in steps per
 * tick, before the bus voltage limits it.
 */
int32_t identify_turn_current(const identify_t *identify);
step_t identify_turn_speed(const identify_t *identify);

/* Whether SPIN is on the way to its first speed, or measures there. */
bool identify_turn_seeks_speed(const identify_t *identify);

/*
 * Whether SPIN already needs all of the voltage for its first speed: then current and rotor are
 * about to be lost.
 */
bool identify_turn_lacks_voltage(const identify_t *identify);

/*
 * Both end the identification. Reason of identify_turn_refuse_voltage(): the voltage is too low.
 * Reason of identify_turn_refuse_lost(): the rotor falls out of step again and again.
 */
void identify_turn_refuse_voltage(identify_t *identify);
void identify_turn_refuse_lost(identify_t *identify);

/*
 * Catches a rotor that has fallen out of step, for a slower attempt. The third call ends the
 * identification.
 */
void identify_turn_catch_again(identify_t *identify);

bool identify_turn_plan_spin(identify_t *identify);
bool identify_turn_plan_ramp(identify_t *identify);
bool identify_turn_plan_coast(identify_t *identify);
bool identify_turn_plan_hall(identify_t *identify);

#endif
