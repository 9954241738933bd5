/* SPDX-License-Identifier: MIT */
#include "safe_state.h"

#include "fx.h"

#define RISE_LOG2 (8U)      /* 1/256 of the bus: above the noise of its sensor */
#define HIGH_BUS_SHIFT (3U) /* 1/8 of the current: 1/64 of the windings' energy */

void safe_state_reset(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_OPEN};
}

void safe_state_clear(safe_state_t *safe)
{
    safe->phase = SAFE_STATE_OPEN;
}

static void short_motor(safe_state_t *safe)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_SHORT};
}

/* What a dead sensor shows from now on is no change. */
static void hold_shorted(safe_state_t *safe, ab_t current)
{
    *safe = (safe_state_t){.phase = SAFE_STATE_HELD, .before = current};
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

static int32_t large_change(const safe_state_cfg_t *cfg, const safe_state_in_t *in)
{
    return (in->bus > in->bus_max) ? fx_max(fx_asr(cfg->change_min, HIGH_BUS_SHIFT), 1)
                                   : cfg->change_min;
}

/* The current has changed by more than that of a slow rotor. Looked at where a span ends. */
static bool is_fast(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in)
{
    const ab_t current = in->current;
    bool fast = false;

    safe->ticks++;
    if (safe->ticks >= cfg->span_ticks) {
        const int32_t alpha = fx_abs(current.alpha - safe->before.alpha);
        const int32_t beta = fx_abs(current.beta - safe->before.beta);

        fast = fx_max(alpha, beta) >= large_change(cfg, in);
        safe->before = current;
        safe->ticks = 0U;
    }
    return fast;
}

static void wait_for_slow_rotor(safe_state_t *safe, const safe_state_cfg_t *cfg,
                                const safe_state_in_t *in)
{
    if (is_fast(safe, cfg, in)) {
        safe->slow_ticks = 0U;
    } else if (safe->slow_ticks < cfg->settle_ticks) {
        safe->slow_ticks++;
    } else {
        safe_state_reset(safe);
        safe->bus_opened = (in->bus > in->bus_max) ? in->bus : 0;
    }
}

static void wait_for_bus(safe_state_t *safe, const safe_state_cfg_t *cfg, const safe_state_in_t *in)
{
    if (is_fast(safe, cfg, in) || (in->bus <= in->bus_max)) {
        short_motor(safe);
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
        wait_for_bus(safe, cfg, in);
    } else if (!is_overcharged(safe, in)) {
        /* open */
    } else if (safe->bus_opened > 0) {
        hold_shorted(safe, in->current);
    } else {
        short_motor(safe);
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
