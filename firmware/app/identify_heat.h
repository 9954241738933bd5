/* SPDX-License-Identifier: MIT */
/*
 * How warm the winding may be when an identification begins. STILL imposes the largest current, for
 * some seconds. If a winding with a short time constant were already warm, OVERLOAD would end the
 * identification. After a loss of supply the heat is unknown, so the winding may be warm
 * (kept_heat.h).
 *
 * Part of the identification. Context: background.
 */
#ifndef IDENTIFY_HEAT_H
#define IDENTIFY_HEAT_H

#include "identify_state.h"

#include <stdint.h>

/*
 * Returns the largest heat at which an identification may begin, Q24: 1 is the steady heat of the
 * continuous current. From this heat, the largest current during LARGEST_MS leads to 0.1 below the
 * limit, if cooling is not counted. The result is at least 0.25, because cooling from 0.9 to 0.25
 * already takes 1.3 time constants. If 0.25 is more than the heat computed in this way, OVERLOAD
 * remains possible. Pure.
 */
int32_t identify_heat_most_q24(const identify_t *identify);

#endif
