/* SPDX-License-Identifier: MIT */
#include "current_sum.h"

#include "fx.h"

/* a window ends only with at least this many samples, because the mean of fewer would be rough */
#define SAMPLES_MIN (16U)
#define SHARE_SHIFT (15U)

void current_sum_begin(current_sum_t *state)
{
    state->samples = 0U;
    state->sum = 0U;
    state->flowing = 0U;
}

void current_sum_reset(current_sum_t *state)
{
    state->zero_sum = 0;
    state->zeros = 0;
    current_sum_begin(state);
}

void current_sum_zero(current_sum_t *state, int32_t sum)
{
    if (state->zeros < (int32_t)CURRENT_SUM_SAMPLES_MAX) {
        state->zero_sum += sum;
        state->zeros++;
    }
}

/*
 * Returns the sum of the three currents of this sample, corrected by its zero. If the zero is not
 * known, the sum counts as 0.
 */
static int32_t sum_of(const current_sum_t *state, const current_sum_in_t *in)
{
    int32_t sum = 0;

    if (state->zeros > 0) {
        sum = in->sum - (state->zero_sum / state->zeros);
    }
    return sum;
}

/* Returns the largest mean of |i_a + i_b + i_c| that is allowed at the currents of this window. */
static uint32_t largest_sum(const current_sum_t *state, const supervision_cfg_t *cfg)
{
    const uint64_t share = (uint64_t)state->flowing * fx_unsigned(cfg->sum_share_q15);
    const uint32_t mean = (uint32_t)(share >> SHARE_SHIFT) / state->samples;

    return fx_unsigned(cfg->sum_max) + mean;
}

static fault_id_t judge_window(const current_sum_t *state, const supervision_cfg_t *cfg,
                               fault_t *fault)
{
    const uint32_t mean = state->sum / state->samples;
    const uint32_t largest = largest_sum(state, cfg);
    fault_id_t id = FAULT_NONE;

    if (mean > largest) {
        id = FAULT_CURRENT_SUM;
        *fault = (fault_t){.id = id, .value = (int32_t)mean, .limit = (int32_t)largest};
    }
    return id;
}

fault_id_t current_sum_step(current_sum_t *state, const supervision_cfg_t *cfg,
                            const current_sum_in_t *in, bool ends, fault_t *fault)
{
    const int32_t sum = sum_of(state, in);
    const int32_t c = sum - in->a - in->b;
    fault_id_t id = FAULT_NONE;

    state->sum += fx_unsigned(fx_abs(sum));
    state->flowing += fx_unsigned(fx_abs(in->a) + fx_abs(in->b) + fx_abs(c));
    state->samples++;
    if ((state->samples >= CURRENT_SUM_SAMPLES_MAX) || (ends && (state->samples >= SAMPLES_MIN))) {
        id = judge_window(state, cfg, fault);
        current_sum_begin(state);
    }
    return id;
}
