/* SPDX-License-Identifier: MIT */
/*
 * Experiments on a rotor that turns: SPIN, RAMP, COAST.
 *
 * A plan looks at the sums of the experiment that has ended, and aims the next one. It returns whether it did: if not, it has
 * changed the phase, and the plan of that phase is next. Context: background.
 */
#ifndef IDENTIFY_TURN_H
#define IDENTIFY_TURN_H

#include "identify_state.h"

#include <stdbool.h>

/* Current and highest speed of SPIN, Q15 of I_b and steps per tick: known from the beginning. */
int32_t identify_turn_current(const identify_t *identify);
step_t identify_turn_speed(const identify_t *identify);

/* Whether the way to the first speed takes all of the voltage: then current and rotor are about to be lost. */
bool identify_turn_lacks_voltage(const identify_t *identify);

/* Ends it for that, and for a rotor that falls out of step again and again. */
void identify_turn_refuse_voltage(identify_t *identify);
void identify_turn_refuse_lost(identify_t *identify);

bool identify_turn_plan_spin(identify_t *identify);
bool identify_turn_plan_ramp(identify_t *identify);
bool identify_turn_plan_coast(identify_t *identify);

#endif
