/* SPDX-License-Identifier: MIT */
/*
 * Experiments on a rotor that does not turn: PULSE, CATCH, STILL.
 *
 * A plan looks at the sums of the experiment that has ended, and sets up the next one. It returns
 * true if it has set one up. Otherwise it has changed the phase, and the plan of the new phase has
 * to be called. Context: background.
 */
#ifndef IDENTIFY_REST_H
#define IDENTIFY_REST_H

#include "identify_state.h"

#include <stdbool.h>

/*
 * Returns the largest current of STILL, Q15 of I_b. It is known from the beginning; after the
 * pulses stiff_current may lower it.
 */
int32_t identify_rest_largest(const identify_t *identify);

/*
 * Ends the identification while a current is imposed along the axis of a phase. The reason is
 * `why`, a constant text. If a phase carries no current, the reason is that this phase is open.
 */
void identify_rest_refuse(identify_t *identify, const char *why);

bool identify_rest_plan_pulse(identify_t *identify);
bool identify_rest_plan_catch(identify_t *identify);
bool identify_rest_plan_still(identify_t *identify);

#endif
