/* SPDX-License-Identifier: MIT */
#include "torque_loop.h"

/*
 * The estimated speed of a rotor that is held at the lowest speed may swing by 1/8 of that speed.
 */
#define SWING_SHARE (8)

void torque_loop_start(torque_loop_t *loop, int32_t flux_q13, int32_t current)
{
    loop->reference_q28 = current_reference_torque(current, flux_q13);
    loop->current = current;
    loop->end = (uint8_t)SPEED_END_NONE;
    loop->bound = false;
    loop->bridging = false;
}

void torque_loop_bridge(torque_loop_t *loop)
{
    loop->bridging = true;
}

/* A slope of less than an LSB of current counts as one LSB, because the bridge has to end. */
torque_range_t torque_loop_bridged(const torque_loop_cfg_t *cfg, int32_t flux_q13, int32_t current,
                                   torque_range_t range)
{
    const int32_t step = fx_max(current_reference_q(cfg->slope, flux_q13), 1);
    const int32_t from = fx_clamp(current, range.lower, range.upper);

    return (torque_range_t){.lower = fx_max(range.lower, from - step),
                            .upper = fx_min(range.upper, from + step)};
}

void torque_loop_arrive(torque_loop_t *loop, int32_t current, torque_range_t range)
{
    if ((current > range.lower) && (current < range.upper)) {
        loop->bridging = false;
    }
}

step_t torque_loop_aim(const torque_loop_cfg_t *cfg, int32_t target_q28)
{
    step_t aim = 0;

    if (target_q28 > 0) {
        aim = cfg->speed_forward;
    } else if (target_q28 < 0) {
        aim = -cfg->speed_backward;
    } else {
        /* a torque of 0 has no direction */
    }
    return aim;
}

/* Whether the end of the window at the lowest speed has decided i_q*. */
static bool is_caught(const torque_loop_t *loop, bool backwards)
{
    const speed_end_t there = backwards ? SPEED_END_UPPER : SPEED_END_LOWER;

    return loop->end == (uint8_t)there;
}

/*
 * Returns the next speed reference while the torque is free. With a torque in the direction of the
 * motion, the end of the window holds the rotor at the lowest speed. The estimate swings about that
 * speed by some percent, so the reference stays there, and only a rotor that is slower by more is
 * led back up the slope. With other torques the reference goes down the slope from the lowest speed
 * on.
 */
static step_t next_free_reference(const torque_loop_t *loop, const torque_loop_cfg_t *cfg,
                                  const torque_loop_in_t *in)
{
    const step_t aim = torque_loop_aim(cfg, in->target_q28);
    const bool backwards = in->reference < 0;
    const bool onwards = backwards ? (aim < 0) : (aim > 0);
    const step_t along = backwards ? -in->speed : in->speed;
    const bool low = (in->lowest != 0) && (is_caught(loop, backwards) || (along < in->lowest));
    const step_t least = in->lowest - (in->lowest / SWING_SHARE);
    step_t next = in->speed;

    if (low && onwards && (along >= least)) {
        next = backwards ? -in->lowest : in->lowest;
    } else if (low) {
        const step_t start = fx_clamp(along, 0, in->lowest);

        next = fx_towards(backwards ? -start : start, aim, in->ramp);
    } else {
        /* the torque alone decides the speed */
    }
    return fx_clamp(next, -cfg->speed_backward, cfg->speed_forward);
}

/*
 * Returns the next speed reference: on the slope of an imposed vector at low speed, else the
 * rotor's speed.
 */
static step_t next_reference(const torque_loop_t *loop, const torque_loop_cfg_t *cfg,
                             const torque_loop_in_t *in)
{
    const step_t aim = torque_loop_aim(cfg, in->target_q28);

    return loop->bound ? fx_towards(in->reference, aim, in->ramp)
                       : next_free_reference(loop, cfg, in);
}

/*
 * Sets whether the speed loop decides the torque. If no end of the window has held the rotor before
 * it became too slow, the speed loop begins with another i_q*, and a bridge leads to it.
 */
static void bind(torque_loop_t *loop, bool bound)
{
    if (bound && !loop->bound && (loop->end == (uint8_t)SPEED_END_NONE)) {
        loop->bridging = true;
    }
    loop->bound = bound;
}

/*
 * Returns the torque reference from which the slope goes on. While the upper end of the window
 * holds the torque back, the reference is at most the larger one of target and acting torque; at
 * the lower end it is at least the smaller one. So a torque that leads away from the end begins at
 * the acting torque.
 */
static int32_t held_back_q28(const torque_loop_t *loop, const torque_loop_in_t *in, int32_t target)
{
    const int32_t acting = current_reference_torque(in->current, in->flux_q13);
    int32_t from = loop->reference_q28;

    if (loop->end == (uint8_t)SPEED_END_UPPER) {
        from = fx_min(from, fx_max(target, acting));
    } else if (loop->end == (uint8_t)SPEED_END_LOWER) {
        from = fx_max(from, fx_min(target, acting));
    } else {
        /* no end of the window holds the torque back */
    }
    return from;
}

step_t torque_loop_plan(torque_loop_t *loop, const torque_loop_cfg_t *cfg,
                        const torque_loop_in_t *in)
{
    const step_t reference = next_reference(loop, cfg, in);

    bind(loop, fx_abs(reference) < in->lowest);
    if (loop->bound) {
        loop->reference_q28 = current_reference_torque(in->current, in->flux_q13);
        loop->current = in->current;
        loop->end = (uint8_t)SPEED_END_NONE;
    } else {
        const int32_t least = current_reference_torque(in->range.lower, in->flux_q13);
        const int32_t most = current_reference_torque(in->range.upper, in->flux_q13);
        const int32_t target = fx_clamp(in->target_q28, least, most);
        const int32_t from = fx_clamp(held_back_q28(loop, in, target), least, most);

        loop->reference_q28 = fx_towards(from, target, cfg->slope);
        loop->current = current_reference_q(loop->reference_q28, in->flux_q13);
    }
    return reference;
}

speed_window_t torque_loop_window(const torque_loop_cfg_t *cfg, step_t reference, step_t lowest)
{
    speed_window_t window = {
        .lower = -cfg->speed_backward, .upper = cfg->speed_forward, .load_shift = cfg->load_shift};

    if (lowest == 0) {
        /* there is no lowest speed */
    } else if (reference < 0) {
        window.upper = fx_max(-lowest, window.lower);
    } else {
        window.lower = fx_min(lowest, window.upper);
    }
    return window;
}
