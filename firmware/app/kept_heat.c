/* SPDX-License-Identifier: MIT */
#include "kept_heat.h"

#include <stddef.h>

#define HEAT_MAX_Q24 (0x40000000U)
#define GAIN_BITS (16U)
#define GAIN_MASK (0xFFFFU)
#define GAIN_MAX (0x7FFFU)
#define SHIFT_MAX (27U)

/* Indices of the words. */
#define HEAT (0U)
#define SCALE (1U) /* heat_gain, and heat_shift above it */
#define CHECK (2U)

/* Words that are all 0, or all 1, are none. */
static uint32_t seal_of(uint32_t heat, uint32_t scale)
{
    return ~(heat + scale);
}

static uint32_t scale_of(const derating_cfg_t *cfg)
{
    return (cfg->heat_shift << GAIN_BITS) | (uint32_t)cfg->heat_gain;
}

/* In the scale of `cfg`. */
static int32_t in_scale_of(uint32_t heat, uint32_t scale, const derating_cfg_t *cfg)
{
    const derating_cfg_t before = {.heat_shift = scale >> GAIN_BITS,
                                   .heat_gain = (int32_t)(uint32_t)(scale & GAIN_MASK)};
    derating_t kept = {.heat_q24 = (int32_t)heat};

    derating_change(&kept, &before, cfg);
    return kept.heat_q24;
}

void kept_heat_restore(app_t *app)
{
    const uint32_t heat = hal_kept(app->hal, HEAT);
    const uint32_t scale = hal_kept(app->hal, SCALE);
    const uint32_t gain = scale & GAIN_MASK;
    const bool whole = hal_kept(app->hal, CHECK) == seal_of(heat, scale);
    const bool in_range = (heat <= HEAT_MAX_Q24) && (gain > 0U) && (gain <= GAIN_MAX) &&
                          ((scale >> GAIN_BITS) <= SHIFT_MAX);
    int32_t heat_q24 = KEPT_HEAT_UNKNOWN_Q24;

    if (whole && in_range) {
        heat_q24 = in_scale_of(heat, scale, &app->drive.cfg->derating);
    }
    drive_warm(&app->drive, heat_q24);
}

/* A change that is posted may come in between, with another scale: then it is kept in the next pass. Nobody else posts one. */
void kept_heat_step(app_t *app)
{
    const drive_cfg_t *const cfg = app->drive.cfg;

    if ((cfg != NULL) && !app_changes(app)) {
        const uint32_t heat = fx_unsigned(app->drive.derating.heat_q24);
        const uint32_t scale = scale_of(&cfg->derating);

        hal_keep(app->hal, HEAT, heat);
        hal_keep(app->hal, SCALE, scale);
        hal_keep(app->hal, CHECK, seal_of(heat, scale));
    }
}
