/* SPDX-License-Identifier: MIT */
/*
 * Torque control: the torque follows its target on a slope, while the speed is within a window.
 *
 * The torque reference moves towards the target by at most `slope` in a slow period. It begins with
 * the present torque, so the torque does not jump at a change of mode. The reference stays within
 * the range of i_q*: a torque that leads away from a limit acts at once, and when the limit ends,
 * the torque comes back on the slope. The current for it comes from current_reference.h. At the
 * ends of the window the speed loop decides i_q* (speed_loop_within()).
 *
 * Low speed. Where the angle is found from the EMF, there is a lowest speed of RUN. Below it a
 * current is imposed. Its torque follows the load, so only a speed can be commanded. So the window
 * ends at the lowest speed, in the direction in which the rotor turns:
 *     torque with the motion      a load that is larger slows the rotor down to the lowest speed,
 *                                 not further
 *     torque against it, or none  the speed follows the slope of the imposed vector from the lowest
 *                                 speed on: to the window's end on the other side, or to a
 *                                 standstill
 * On this slope the speed loop decides the torque (`bound`), and the torque reference follows the
 * present torque. The torque is free again from the lowest speed on.
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
    step_t speed_forward;  /* largest speed forwards (α towards β): one end of the window, 0…2^29 */
    step_t speed_backward; /* largest speed backwards, as a magnitude: the other end, 0…2^29 */
    uint32_t load_shift;   /* see speed_window_t, 0…14 */
} torque_loop_cfg_t;

typedef struct {
    int32_t reference_q28; /* torque reference, ±CURRENT_REFERENCE_TORQUE_MAX */
    int32_t current;       /* i_q* for reference_q28, ±16384 */
    uint8_t end;           /* speed_end_t: what decided i_q* in the last slow period */
    bool bound;            /* the speed loop decides the torque */
    bool bridging;         /* i_q* still moves on a slope from its value before a change of mode */
} torque_loop_t;

/* Input of a slow period. */
typedef struct {
    int32_t target_q28; /* torque asked for */
    int32_t flux_q13;   /* ψ, 1…32767 */
    int32_t current;    /* i_q* in force, ±16384 */
    /* allowed range of i_q*, lower ≤ 0 ≤ upper; limits the torque reference */
    torque_range_t range;
    step_t speed;     /* speed of the rotor, ±2^29 */
    step_t reference; /* speed reference of the last slow period, ±2^29 */
    step_t lowest;    /* lowest speed of RUN, 0…2^29; 0: there is none */
    step_t ramp;      /* change of the imposed vector's speed in a slow period, 1…2^29 */
} torque_loop_in_t;

/*
 * Starts with the present torque, the one of ψ and i_q* in force. From now on the torque is free,
 * even if it was bound before.
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
 * Ends the bridge if `current` lies strictly between the ends of `range`. current: chosen by the
 * loop in charge. range: the range of the bridge.
 */
void torque_loop_arrive(torque_loop_t *loop, int32_t current, torque_range_t range);

/*
 * Returns the speed to which a torque drives: the end of the window in its direction, 0 for no
 * torque.
 */
step_t torque_loop_aim(const torque_loop_cfg_t *cfg, int32_t target_q28);

/* One slow period: sets torque reference and current. Returns the speed reference. One division. */
step_t torque_loop_plan(torque_loop_t *loop, const torque_loop_cfg_t *cfg,
                        const torque_loop_in_t *in);

/*
 * Returns the window of speeds in which the torque is free. reference, lowest: see
 * torque_loop_in_t.
 */
speed_window_t torque_loop_window(const torque_loop_cfg_t *cfg, step_t reference, step_t lowest);

#endif
