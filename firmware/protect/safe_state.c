/* SPDX-License-Identifier: MIT */
#include "safe_state.h"

#include "fx.h"

#define RISE_LOG2 (6U) /* 1/64 of the bus: more than the windings give when the gates open */

void safe_state_reset(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_OPEN};
}

static void short_motor(safe_state_t *safe, safe_state_phase_t phase)
{
    *safe = (safe_state_t){.phase = phase};
}

void safe_state_leave(safe_state_t *safe, const safe_state_cfg_t *cfg, step_t speed)
{
    if ((cfg->open_speed > 0) && (speed > cfg->open_speed)) {
        short_motor(safe, SAFE_STATE_SHORT);
    } else {
        safe_state_reset(safe);
    }
}

void safe_state_break(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_BROKEN};
}

/* The rotor is too fast for open gates: the current has changed by more than that of a slow one. Looked at where a span ends. */
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

static void wait_for_slow_rotor(safe_state_t *safe, const safe_state_cfg_t *cfg,
                                const safe_state_in_t *in)
{
    if (is_fast(safe, cfg, in->current)) {
        safe->slow_ticks = 0U;
    } else if (safe->slow_ticks < cfg->settle_ticks) {
        safe->slow_ticks++;
    } else {
        safe_state_reset(safe);
        safe->bus_opened = (in->bus > in->bus_max) ? in->bus : 0;
    }
}

static void wait_for_bus(safe_state_t *safe, const safe_state_in_t *in)
{
    if (in->bus <= in->bus_max) {
        short_motor(safe, SAFE_STATE_SHORT);
    }
}

/* With open gates the diodes charge the bus: is it beyond what it bears? */
static bool is_overcharged(safe_state_t *safe, const safe_state_in_t *in)
{
    const int32_t opened = safe->bus_opened;

    if (in->bus <= in->bus_max) {
        safe->bus_opened = 0;
    }
    return in->bus > fx_max(in->bus_max, opened + fx_asr(opened, RISE_LOG2));
}

static void seek_safe_state(safe_state_t *safe, const safe_state_cfg_t *cfg,
                            const safe_state_in_t *in)
{
    if (cfg->open_speed == 0) {
        safe_state_reset(safe);
    } else if (safe->phase == SAFE_STATE_SHORT) {
        wait_for_slow_rotor(safe, cfg, in);
    } else if (safe->phase == SAFE_STATE_HELD) {
        wait_for_bus(safe, in);
    } else if (is_overcharged(safe, in)) {
        short_motor(safe, (safe->bus_opened > 0) ? SAFE_STATE_HELD : SAFE_STATE_SHORT);
    } else {
        /* open */
    }
}

/* What is broken stays so until it is cleared. */
bool safe_state_step(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in)
{
    if (safe->phase != SAFE_STATE_BROKEN) {
        seek_safe_state(safe, cfg, in);
    }
    return safe_state_is_short(safe);
}
