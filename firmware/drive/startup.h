/* SPDX-License-Identifier: MIT */
/* Configuration of what happens below the speed at which the back-EMF tells the rotor's angle. */
#ifndef STARTUP_H
#define STARTUP_H

#include "align.h"
#include "catch_spin.h"

#include <stdint.h>

typedef struct {
    catch_spin_cfg_t catch_spin;
    align_cfg_t align;
    int32_t current_hold; /* imposed at standstill, Q15 of I_b, 1…16384; 0: no start-up at all, RUN
                                  begins with the rotor taken to be at rest at angle 0 */
    int32_t current_move;  /* imposed while the reference moves, Q15 of I_b, current_hold…16384 */
    int32_t current_slope; /* change of the imposed current in a tick, Q15 of I_b, 1…16384 */
    step_t ramp; /* in speed mode the vector's speed changes no faster in a slow period, 1…2^29 */
    step_t track_speed; /* the observer runs free from this speed of the vector on, else it follows
                                  the vector; 1…handover_speed */
    step_t handover_speed; /* the observer takes over from here on, 1…2^29 */
    step_t hold_speed;     /* and hands back below it, 1…handover_speed − 1 */
    int32_t
        residual_max; /* at hand-over the observer's |e'_q|, filtered, is below, Q15 of I_b, 1…16384 */
    int32_t
        residual_lost; /* while it is above, the vector does not have the rotor, residual_max…16384 … */
    uint32_t lost_periods;     /* … and the start is repeated after so many slow periods, 1…60000 */
    uint32_t handover_periods; /* slow periods within which it must fall below, 1…60000 */
    uint32_t attempts;         /* starts before it is a fault, 1…100 */
} startup_cfg_t;

#endif
