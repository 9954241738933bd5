/* SPDX-License-Identifier: MIT */
#include "oscillation.h"

/*
 * a turning point is found when i_q* has come back from it by 1/4 of the last half-wave, or by
 * twice the amplitude limit if that is more
 */
#define BACK_SHIFT (2U)
/*
 * slow periods that a half-wave takes at least, so a swing is not faster than 1/4 of the slow rate
 */
#define PERIODS_LEAST (2U)
#define HIGHEST_SHIFT (1U) /* a half-wave lower than 1/2 of the highest one ends the run */

/* Clears word by word, because a library's memset takes five times as long. */
void oscillation_reset(oscillation_t *state)
{
    state->now = 0U;
    state->motion = 0;
    state->falls = false;
    state->extreme = 0;
    state->at = 0U;
    state->back = 0;
    state->turned = 0;
    state->since = 0U;
    state->periods_up = 0U;
    state->periods_down = 0U;
    state->highest = 0;
    state->halves = 0U;
    state->begun = 0U;
    state->span = 0U;
}

/* Forgets all half-waves of the run. The next half-wave begins here. */
static void forget_run(oscillation_t *state, const oscillation_cfg_t *cfg, int32_t current)
{
    state->extreme = current;
    state->at = state->now;
    state->back = 2 * cfg->amplitude_max;
    state->turned = current;
    state->since = state->now;
    state->halves = 0U;
}

/*
 * Whether a half-wave is half to twice as long as `before`, and at least two periods long, because
 * noise mostly turns after a single one.
 */
static bool is_as_long(uint32_t periods, uint32_t before)
{
    return (periods >= PERIODS_LEAST) && (periods <= (2U * before)) && (before <= (2U * periods));
}

/*
 * Counts the half-wave that led to the extreme: as the next one of the run, or as the first one of
 * a new run.
 */
static void count_half(oscillation_t *state, int32_t height)
{
    uint32_t *const before = state->falls ? &state->periods_down : &state->periods_up;
    const uint32_t periods = state->at - state->since;

    if ((state->halves > 0U) && is_as_long(periods, *before) &&
        (height >= fx_asr(state->highest, HIGHEST_SHIFT))) {
        state->halves++;
        state->highest = fx_max(state->highest, height);
    } else {
        state->halves = 1U;
        state->highest = height;
        state->begun = state->since;
    }
    *before = periods;
}

/* Ends a half-wave: i_q* has turned at its extreme, and has come back to `current`. */
static void end_half(oscillation_t *state, const oscillation_cfg_t *cfg, int32_t current)
{
    const int32_t height = fx_abs(state->extreme - state->turned);

    count_half(state, height);
    state->back = fx_max(2 * cfg->amplitude_max, fx_asr(height, BACK_SHIFT));
    state->turned = state->extreme;
    state->since = state->at;
    state->falls = !state->falls;
    state->extreme = current;
    state->at = state->now;
}

static fault_id_t end_swing(oscillation_t *state, const oscillation_cfg_t *cfg, int32_t current,
                            fault_t *fault)
{
    *fault = (fault_t){
        .id = FAULT_OSCILLATION, .value = fx_asr(state->highest, 1U), .limit = cfg->amplitude_max};
    state->span = state->since - state->begun;
    forget_run(state, cfg, current);
    return FAULT_OSCILLATION;
}

static fault_id_t follow_wave(oscillation_t *state, const oscillation_cfg_t *cfg, int32_t current,
                              fault_t *fault)
{
    const int32_t further = state->falls ? (state->extreme - current) : (current - state->extreme);
    fault_id_t id = FAULT_NONE;

    if (further >= 0) {
        state->extreme = current;
        state->at = state->now;
    } else if (-further >= state->back) {
        end_half(state, cfg, current);
        if (state->halves >= cfg->halves_max) {
            id = end_swing(state, cfg, current, fault);
        }
    } else {
        /* i_q* has turned but not come back far enough, or this is ripple */
    }
    if ((state->now - state->since) > cfg->periods_max) {
        forget_run(state, cfg, current);
    }
    return id;
}

fault_id_t oscillation_step(oscillation_t *state, const oscillation_cfg_t *cfg,
                            const oscillation_in_t *in, fault_t *fault)
{
    fault_id_t id = FAULT_NONE;

    state->now++;
    if (in->motion == state->motion) {
        id = follow_wave(state, cfg, in->current, fault);
    } else {
        state->motion = in->motion;
        forget_run(state, cfg, in->current);
    }
    return id;
}
