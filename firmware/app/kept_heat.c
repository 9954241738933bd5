/* SPDX-License-Identifier: MIT */
#include "kept_heat.h"

#include <stdbool.h>

#define GAIN_BITS (16U)
#define GAIN_MASK (0xFFFFU)
#define GAIN_MAX (0x7FFFU)
#define SHIFT_MAX (27U)

/* Words of a copy. */
#define HEAT (0U)
#define SCALE (1U) /* heat_gain in bits 0…15, heat_shift above them */
#define SEAL (2U)
#define COPY_WORDS (3U)

/* Two copies: a reset while one is written leaves the other. */
#define COPIES (HAL_KEPT_WORDS / COPY_WORDS)

/* Returns the check word of a copy. With it a copy whose words are all 0 or all 1 is not valid. */
static uint32_t seal_of(uint32_t heat, uint32_t scale)
{
    return ~(heat + scale);
}

static uint32_t scale_of(const derating_cfg_t *cfg)
{
    return (cfg->heat_shift << GAIN_BITS) | (uint32_t)cfg->heat_gain;
}

/* Converts a kept heat into the scale of `cfg`. */
static int32_t in_scale_of(uint32_t heat, uint32_t scale, const derating_cfg_t *cfg)
{
    const derating_cfg_t before = {.heat_shift = scale >> GAIN_BITS,
                                   .heat_gain = (int32_t)(uint32_t)(scale & GAIN_MASK)};
    derating_t kept = {.heat_q24 = (int32_t)heat};

    derating_change(&kept, &before, cfg);
    return kept.heat_q24;
}

/*
 * Reads the heat of a copy. If the copy is not valid, returns false and leaves *heat_q24 as it is.
 */
static bool copy_holds(const app_t *app, uint32_t first, int32_t *heat_q24)
{
    const uint32_t heat = hal_kept(app->hal, first + HEAT);
    const uint32_t scale = hal_kept(app->hal, first + SCALE);
    const uint32_t gain = scale & GAIN_MASK;
    const bool whole = hal_kept(app->hal, first + SEAL) == seal_of(heat, scale);
    const bool in_range = (heat <= (uint32_t)DERATING_HEAT_MAX_Q24) && (gain > 0U) &&
                          (gain <= GAIN_MAX) && ((scale >> GAIN_BITS) <= SHIFT_MAX);
    const bool holds = whole && in_range;

    if (holds) {
        *heat_q24 = in_scale_of(heat, scale, &app->drive.cfg->derating);
    }
    return holds;
}

void kept_heat_restore(app_t *app)
{
    int32_t heat_q24 = KEPT_HEAT_UNKNOWN_Q24;

    if (!copy_holds(app, 0U, &heat_q24)) {
        (void)copy_holds(app, COPY_WORDS, &heat_q24);
    }
    drive_warm(&app->drive, heat_q24);
    app->keeps_heat = true;
}

/*
 * While a change is posted, the tick may take it at any instruction, and with it another scale. So
 * the heat is not kept in this pass, but in a later one. Only the background posts changes, so the
 * configuration stays the same after this check.
 */
void kept_heat_step(app_t *app)
{
    if (app->keeps_heat && !app_changes(app)) {
        const uint32_t heat = fx_unsigned(app->drive.derating.heat_q24);
        const uint32_t scale = scale_of(&app->drive.cfg->derating);

        for (uint32_t copy = 0U; copy < COPIES; copy++) {
            const uint32_t first = copy * COPY_WORDS;

            hal_keep(app->hal, first + HEAT, heat);
            hal_keep(app->hal, first + SCALE, scale);
            hal_keep(app->hal, first + SEAL, seal_of(heat, scale));
        }
    }
}
