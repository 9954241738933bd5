/* SPDX-License-Identifier: MIT */
/*
 * The safe state: what the gates do while the drive drives nothing.
 *
 * Open gates are safe while the EMF stays below what the bus bears. Above that speed the diodes rectify into the bus, so
 * the motor is shorted by the three low sides instead. Its current is then φ/L at most in the end, and brakes little. The
 * gates open once the rotor is slow.
 *
 * The rotor's speed is that of the current vector in the short circuit: no observer takes part, as its loss may be the
 * fault. A component that does not turn decays with L/R. While it is the larger one, the vector does not go round zero and
 * seems to stand. Therefore what allows to open has to last for settle_ticks. Where the converter clips, the vector still
 * goes round once in an electrical turn.
 *
 * Called from drive_step in each tick that drives nothing. Pure, total. Angles are a turn of 2^32, speeds steps per tick,
 * currents Q15 of I_b.
 */
#ifndef SAFE_STATE_H
#define SAFE_STATE_H

#include "transforms.h"

#include <stdbool.h>
#include <stdint.h>

#define SAFE_STATE_MEAN_LOG2 (6U) /* the speed is a mean over some 64 ticks */
#define SAFE_STATE_TURN_MAX (0x3FFFFFFF)

typedef struct {
    /* opening the gates is safe up to this speed, 0…2^29; 0: always, the motor is never shorted */
    step_t open_speed;
    /* a smaller current in the short circuit is that of a slower rotor, 0…16384 */
    int32_t current_min;
    /* ticks for which the rotor has to be slow before the gates open, 0…2^20 */
    uint32_t settle_ticks;
} safe_state_cfg_t;

typedef enum {
    SAFE_STATE_OPEN = 0,
    SAFE_STATE_SHORT, /* gates on, all low sides */
    SAFE_STATE_BROKEN /* the power stage has opened the gates by itself: nothing closes them */
} safe_state_phase_t;

typedef struct {
    safe_state_phase_t phase;
    angle_t angle;       /* of the current vector at the last tick */
    step_t speed;        /* of the current vector, ±SAFE_STATE_TURN_MAX */
    uint32_t slow_ticks; /* ticks in a row that allow to open, 0…2^20 */
} safe_state_t;

/* Open, and nothing is broken. */
void safe_state_reset(safe_state_t *safe);

/* The drive stops to drive in this tick, at no more than this speed, 0…2^30. Faster than cfg->open_speed: short. */
void safe_state_leave(safe_state_t *safe, const safe_state_cfg_t *cfg, step_t speed);

/* The power stage has opened the gates by itself. They stay open until safe_state_reset(). */
void safe_state_break(safe_state_t *safe);

/*
 * One tick that drives nothing. bus_high: the bus is above its limit, so a motor that turns has to be shorted.
 * current: −16384…16383, −28379…28379. Returns whether all low sides are to be on, else the gates are to be open.
 */
bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, ab_t current, bool bus_high);

static inline bool safe_state_is_short(const safe_state_t *safe)
{
    return safe->phase == SAFE_STATE_SHORT;
}

#endif
