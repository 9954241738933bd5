/* SPDX-License-Identifier: MIT */
/*
 * How warm the winding may be when an identification begins. STILL imposes the largest current, for
 * some seconds. A winding with a short time constant would end it by OVERLOAD if it were warm
 * already, or if it may be: after the supply was away nobody knows its heat (kept_heat.h).
 *
 * Part of the identification. Context: background.
 */
#ifndef IDENTIFY_HEAT_H
#define IDENTIFY_HEAT_H

#include "identify_state.h"

#include <stdint.h>

/*
 * Returns the heat up to which it may begin, Q24: 1 is the steady heat of the continuous current.
 * From there LARGEST_MS of the largest current end a tenth below the limit, without what cools
 * meanwhile. Never below 0.25: cooling from 0.9 to 0.25 takes 1.3 time constants. At that floor
 * OVERLOAD remains possible. Pure.
 */
int32_t identify_heat_most_q24(const identify_t *identify);

#endif
