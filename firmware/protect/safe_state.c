/* SPDX-License-Identifier: MIT */
#include "safe_state.h"

#include "fx.h"
#include "trig.h"

#define OPEN_SHARE_LOG2 (3U) /* opens at 7/8 of the speed up to which that is safe */

void safe_state_reset(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_OPEN};
}

/* As fast as a quarter of a turn in a tick until the current tells more. */
static void short_motor(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_SHORT, .speed = SAFE_STATE_TURN_MAX};
}

void safe_state_leave(safe_state_t *safe, const safe_state_cfg_t *cfg, step_t speed)
{
    if ((cfg->open_speed > 0) && (speed > cfg->open_speed)) {
        short_motor(safe);
    } else {
        safe_state_reset(safe);
    }
}

void safe_state_break(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_BROKEN};
}

/* Speed of the current vector. */
static void follow_current(safe_state_t *safe, ab_t current)
{
    const angle_t angle = trig_atan2((int16_t)current.beta, (int16_t)current.alpha);
    const int32_t turn =
        fx_clamp(fx_signed(angle - safe->angle), -SAFE_STATE_TURN_MAX, SAFE_STATE_TURN_MAX);

    safe->angle = angle;
    safe->speed += fx_asr(turn - safe->speed, SAFE_STATE_MEAN_LOG2);
}

/* The rotor turns slowly, or makes too little current to be fast. */
static bool allows_to_open(const safe_state_t *safe, const safe_state_cfg_t *cfg, ab_t current)
{
    const step_t limit = cfg->open_speed - fx_asr(cfg->open_speed, OPEN_SHARE_LOG2);
    const int32_t square = (current.alpha * current.alpha) + (current.beta * current.beta);

    return (fx_abs(safe->speed) < limit) || (square < (cfg->current_min * cfg->current_min));
}

static void judge_short(safe_state_t *safe, const safe_state_cfg_t *cfg, ab_t current, bool bus_high)
{
    follow_current(safe, current);
    if (bus_high || !allows_to_open(safe, cfg, current)) {
        safe->slow_ticks = 0U;
    } else if (safe->slow_ticks < cfg->settle_ticks) {
        safe->slow_ticks++;
    } else {
        safe_state_reset(safe);
    }
}

bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, ab_t current, bool bus_high)
{
    const bool may_short = cfg->open_speed > 0;

    if (safe->phase == SAFE_STATE_BROKEN) {
        /* until it is cleared */
    } else if (!may_short) {
        safe->phase = SAFE_STATE_OPEN;
    } else if (safe->phase == SAFE_STATE_SHORT) {
        judge_short(safe, cfg, current, bus_high);
    } else if (bus_high) {
        short_motor(safe);
    } else {
        /* open */
    }
    return safe_state_is_short(safe);
}
