/* SPDX-License-Identifier: MIT */
/*
 * Configuration of start-up and low speed, where the back-EMF is too small to find the rotor angle
 * (open_loop.h).
 */
#ifndef STARTUP_H
#define STARTUP_H

#include "align.h"
#include "flying_start.h"

#include <stdint.h>

typedef struct {
    flying_start_cfg_t flying_start;
    align_cfg_t align;
    /*
     * current imposed at standstill, Q15 of I_b, 1…16384. 0: no start-up; RUN begins and assumes
     * that the rotor is at rest at angle 0
     */
    int32_t current_hold;
    /* current imposed while the reference moves, Q15 of I_b, current_hold…16384 */
    int32_t current_move;
    int32_t current_slope; /* change of the imposed current per tick, Q15 of I_b, 1…16384 */
    /*
     * limits beyond which an imposed current is controlled firmly: along its vector and across it,
     * Q15 of I_b, 1…16384
     */
    int32_t along_max;
    int32_t across_max;
    step_t ramp; /* speed mode: largest change of the vector's speed per slow period, 1…2^29 */
    /*
     * at this speed of the vector and above, the observer is trained; below, it follows the vector,
     * 1…handover_speed
     */
    step_t track_speed;
    /*
     * the observer takes over from this speed on; at a start it takes over at once if the rotor
     * already turns so fast, 1…2^29
     */
    step_t handover_speed;
    /*
     * below this speed RUN fades the imposed current in. RUN hands back at 3/4 of it, in position
     * mode at 1/2 of it, 1…handover_speed − 1
     */
    step_t hold_speed;
    /*
     * replaces hold_speed in speed and torque mode while a load against the motion takes
     * load_current or more of i_q, 1…hold_speed
     */
    step_t loaded_speed;
    /* from this torque current on loaded_speed applies, Q15 of I_b, 1…16384 */
    int32_t load_current;
    /*
     * the observer takes over only while the residual (drive_t.residual, here |e'_q|) is below
     * this, Q15 of I_b, 1…16384
     */
    int32_t residual_max;
    /* a residual above this means that the rotor does not follow the vector, residual_max…16384 */
    int32_t residual_lost;
    /*
     * the start is repeated when the number of slow periods with a residual above residual_lost
     * exceeds the number of the others by this, 1…60000
     */
    uint32_t lost_periods;
    uint32_t settle_periods; /* slow periods that HANDOVER takes at least, 0…handover_periods − 1 */
    /* slow periods that HANDOVER may take; then the start is repeated, 1…60000 */
    uint32_t handover_periods;
    uint32_t attempts; /* failed starts until FAULT_STARTUP, 1…100 */
} startup_cfg_t;

#endif
