/* SPDX-License-Identifier: MIT */
/*
 * Torque control: a torque on a slope, within a window of speeds.
 *
 * The torque reference follows the torque asked for by at most `slope` a slow period. It begins
 * with the torque that acts, so the torque does not jump at a change of mode. The reference stays
 * within the range of i_q*: a torque that leads away from a limit acts at once, and when the limit
 * ends, the torque comes back on the slope. The current for it comes from current_reference.h. The
 * speed loop decides where the window ends (speed_loop_within).
 *
 * Low speed. Where the angle is found from the EMF, there is a lowest speed of RUN. Below it a
 * current is imposed. Its torque is the torque of the load, so only a speed can be asked for. So
 * the window ends at the lowest speed, in the direction in which the rotor turns:
 *     torque with the motion      a load that is larger slows the rotor down to the lowest speed,
 *                                 not further
 *     torque against it, or none  the speed follows the slope of the imposed vector from the lowest
 *                                 speed on: to the window's end on the other side, or to a
 *                                 standstill
 * There the speed loop decides the torque ("bound"), and the torque reference follows the torque
 * that acts. The torque is free again from the lowest speed on.
 *
 * Units: torque Q28 of T_b, flux Q13 of U_b/Ω_b (current_reference.h), currents Q15 of I_b, speeds
 * step_t. Pure, total within the ranges. Control interrupt, once per slow period.
 */
#ifndef TORQUE_LOOP_H
#define TORQUE_LOOP_H

#include "current_reference.h"
#include "fx.h"
#include "motion_loop.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t slope;         /* largest change of the torque reference in a slow period, 1…2^29 */
    step_t speed_forward;  /* end of the window, + turns α towards β, 0…2^29 */
    step_t speed_backward; /* the other end, as a magnitude, 0…2^29 */
    uint32_t load_shift;   /* see speed_window_t, 0…14 */
} torque_loop_cfg_t;

typedef struct {
    int32_t reference_q28; /* ±CURRENT_REFERENCE_TORQUE_MAX */
    int32_t current;       /* i_q* that makes it, ±16384 */
    uint8_t end;           /* speed_end_t: what decided i_q* in the last slow period */
    bool bound;            /* the speed loop decides the torque */
    bool bridging;         /* i_q* still moves on a slope from its value before a change of mode */
} torque_loop_t;

/* Input of a slow period. */
typedef struct {
    int32_t target_q28;   /* torque asked for */
    int32_t flux_q13;     /* ψ, 1…32767 */
    int32_t current;      /* i_q* in force, ±16384 */
    torque_range_t range; /* of i_q*, lower ≤ 0 ≤ upper; the reference stays within */
    step_t speed;         /* of the rotor, ±2^29 */
    step_t reference;     /* of the speed in the last slow period, ±2^29 */
    step_t lowest;        /* lowest speed of RUN, 0…2^29; 0: there is none */
    step_t ramp;          /* of the imposed vector, 1…2^29 */
} torque_loop_in_t;

/*
 * Start with the torque that acts: ψ and i_q* in force. The torque is free from now on, whatever it
 * was before.
 */
void torque_loop_start(torque_loop_t *loop, int32_t flux_q13, int32_t current);

/* From now on i_q* moves on a slope until it reaches the value of the loop in charge. */
void torque_loop_bridge(torque_loop_t *loop);

/*
 * For a slow period of a bridge. Returns the part of `range` that the slope leaves around the
 * present i_q*, lower ≤ upper; both may have the same sign. One division.
 */
torque_range_t torque_loop_bridged(const torque_loop_cfg_t *cfg, int32_t flux_q13, int32_t current,
                                   torque_range_t range);

/*
 * The loop in charge has chosen `current` in `range`, the range of the bridge. Strictly between its
 * ends the bridge is over.
 */
void torque_loop_arrive(torque_loop_t *loop, int32_t current, torque_range_t range);

/* The speed that a torque drives to: the end of the window in its direction; 0 for no torque. */
step_t torque_loop_aim(const torque_loop_cfg_t *cfg, int32_t target_q28);

/* One slow period: torque reference and its current. Returns the speed reference. One division. */
step_t torque_loop_plan(torque_loop_t *loop, const torque_loop_cfg_t *cfg,
                        const torque_loop_in_t *in);

/* The window of speeds in which the torque is free. reference, lowest: see torque_loop_in_t. */
speed_window_t torque_loop_window(const torque_loop_cfg_t *cfg, step_t reference, step_t lowest);

#endif
