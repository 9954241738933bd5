/* SPDX-License-Identifier: MIT */
#include "identify_heat.h"

#include "identify_aim.h"
#include "identify_rest.h"

/* time in which STILL imposes its largest currents, all axes together */
#define LARGEST_MS (8000U)
#define TENTH_Q24 (0x19999A)   /* 0.1 of the steady heat of the continuous current */
#define LEAST_Q24 (0x400000)   /* 0.25 of the steady heat of the continuous current */
#define RISE_MAX (0x40000000U) /* bound for the rise of the heat, above any limit */

/* Returns the steady heat of STILL's largest current, Q8. */
static uint64_t steady_q8(const identify_t *identify)
{
    const uint64_t largest = fx_unsigned(identify_rest_largest(identify));
    const uint64_t continuous = fx_unsigned(identify_aim_continuous(identify));

    return (largest * largest * 256U) / (continuous * continuous);
}

/*
 * Returns LARGEST_MS over the winding's time constant, Q16: the number of supervision periods times
 * the heat rate per period.
 */
static uint64_t share_q16(const identify_t *identify)
{
    const drive_cfg_t *const cfg = identify->app->drive.cfg;
    const uint64_t periods = ((uint64_t)LARGEST_MS * fx_unsigned(identify->ms_ticks)) /
                             ((uint64_t)cfg->slow_ticks * SUPERVISION_STEPS);

    return (periods * fx_unsigned(cfg->derating.heat_rate)) >> cfg->derating.heat_rate_shift;
}

int32_t identify_heat_most_q24(const identify_t *identify)
{
    const uint64_t rise = share_q16(identify) * steady_q8(identify);
    const int32_t bounded = (int32_t)((rise < RISE_MAX) ? rise : RISE_MAX);
    const int32_t limit = derating_limit_q24(&identify->app->drive.cfg->derating);

    return fx_max((limit - TENTH_Q24) - bounded, LEAST_Q24);
}
