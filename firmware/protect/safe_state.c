/* SPDX-License-Identifier: MIT */
#include "safe_state.h"

#include "fx.h"

void safe_state_reset(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_OPEN};
}

static void short_motor(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_SHORT};
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

/*
 * Whether the rotor is too fast for open gates: within a span the current has changed by change_min
 * or more. This is judged at the end of each span only.
 */
static bool is_fast(safe_state_t *safe, const safe_state_cfg_t *cfg, ab_t current)
{
    bool fast = false;

    safe->ticks++;
    if (safe->ticks >= cfg->span_ticks) {
        const int32_t alpha = fx_abs(current.alpha - safe->before.alpha);
        const int32_t beta = fx_abs(current.beta - safe->before.beta);

        fast = fx_max(alpha, beta) >= cfg->change_min;
        safe->before = current;
        safe->ticks = 0U;
    }
    return fast;
}

static bool is_overcharged(const safe_state_in_t *in)
{
    return in->bus > in->bus_max;
}

static void wait_for_slow_rotor(safe_state_t *safe, const safe_state_cfg_t *cfg,
                                const safe_state_in_t *in)
{
    const bool fast = is_fast(safe, cfg, in->current);

    if (fast || is_overcharged(in)) {
        safe->slow_ticks = 0U;
    } else if (safe->slow_ticks < cfg->settle_ticks) {
        safe->slow_ticks++;
    } else {
        safe_state_reset(safe);
    }
}

static void seek_safe_state(safe_state_t *safe, const safe_state_cfg_t *cfg,
                            const safe_state_in_t *in)
{
    if (cfg->open_speed == 0) {
        safe_state_reset(safe);
    } else if (safe->phase == SAFE_STATE_SHORT) {
        wait_for_slow_rotor(safe, cfg, in);
    } else if (is_overcharged(in)) {
        short_motor(safe);
    } else {
        /* the gates stay open */
    }
}

/* A broken power stage stays broken until safe_state_reset(). */
bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in)
{
    if (safe->phase != SAFE_STATE_BROKEN) {
        seek_safe_state(safe, cfg, in);
    }
    return safe_state_is_short(safe);
}
