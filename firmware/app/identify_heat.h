/* SPDX-License-Identifier: MIT */
/*
 * How warm the winding may be when an identification begins. STILL has the largest current, for some seconds: a winding with a short
 * time constant that is warm already, or may be after the supply was away (kept_heat.h), would end it by OVERLOAD.
 *
 * Part of the identification. Context: background.
 */
#ifndef IDENTIFY_HEAT_H
#define IDENTIFY_HEAT_H

#include "identify_state.h"

#include <stdint.h>

/*
 * Returns the heat up to which it may begin, Q24: 1 is the steady heat of the continuous current. It is a tenth below the limit after
 * LARGEST_MS of the largest current, without what cools meanwhile; at least 0.25, which takes 1.3 time constants from 0.9. Pure.
 */
int32_t identify_heat_most_q24(const identify_t *identify);

#endif
