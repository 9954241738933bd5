/* SPDX-License-Identifier: MIT */
#include "config_check.h"

#include "config_rows.h"
#include "fx.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Full scale of a phase current, Q15 of I_b. */
#define CURRENT_MAX (16384)

/* `bad` when something was wrong before, else `name` when lower is above upper, else NULL. */
static const char *in_order(const char *bad, const char *name, int64_t lower, int64_t upper)
{
    const char *result = bad;

    if ((bad == NULL) && (lower > upper)) {
        result = name;
    }
    return result;
}

static bool lies_outside(const config_row_t *row, const drive_cfg_t *cfg)
{
    const int32_t value = config_row_value(row, cfg);

    return (value < row->lowest) || (value > row->highest);
}

/* The path of the first row of this use whose setting is out of its range; NULL: none is. */
static const char *first_outside(const drive_cfg_t *cfg, config_use_t use)
{
    const config_row_t *rows = NULL;
    const uint32_t count = config_rows(&rows);
    const char *bad = NULL;

    for (uint32_t k = 0U; (k < count) && (bad == NULL); k++) {
        const config_row_t *const row = &rows[k];

        if ((row->use == (uint8_t)use) && lies_outside(row, cfg)) {
            bad = row->path;
        }
    }
    return bad;
}

static const char *check_rows(const drive_cfg_t *cfg)
{
    const char *bad = first_outside(cfg, CONFIG_USE_ALWAYS);

    if ((bad == NULL) && (cfg->startup.current_hold != 0)) {
        bad = first_outside(cfg, CONFIG_USE_STARTUP);
    }
    if ((bad == NULL) && (cfg->voltage_drive.enabled != 0U)) {
        bad = first_outside(cfg, CONFIG_USE_VOLTAGE_DRIVE);
    }
    return bad;
}

/* A sample at an end of the converter range exceeds the limit with any offset, see protection.h. */
static const char *check_limits(const char *before, const drive_cfg_t *cfg)
{
    const uint32_t lsb = (uint32_t)1U << cfg->sampling.current_shift;
    const int32_t offset_max = CURRENT_MAX - 1 - (int32_t)lsb - cfg->protection.current_max;
    const char *bad = before;

    bad = in_order(bad, "protection.bus_min", cfg->protection.bus_min, cfg->protection.bus_max);
    bad = in_order(bad, "protection.offset_max", cfg->protection.offset_max, offset_max);
    bad = in_order(bad, "derating.current_continuous", cfg->derating.current_continuous,
                   cfg->derating.current_max);
    return in_order(bad, "derating.current_max", cfg->derating.current_max,
                    cfg->protection.current_max);
}

static const char *check_speeds(const char *before, const drive_cfg_t *cfg)
{
    const int32_t speed_q15 = fx_asr(cfg->observer.speed_limit, cfg->speed_shift);
    const char *bad = before;

    bad = in_order(bad, "observer.speed_limit", speed_q15, FX_Q15_MAX);
    return in_order(bad, "speed_loop.speed_max", cfg->speed_loop.speed_max,
                    cfg->observer.speed_limit);
}

static const char *check_startup(const char *before, const startup_cfg_t *cfg, step_t speed_limit)
{
    const align_cfg_t *const align = &cfg->align;
    const char *bad = before;

    bad = in_order(bad, "startup.align.current_low", align->current_low,
                   (int64_t)align->current_high - 1);
    bad = in_order(bad, "startup.align.swing_max", align->swing_max, align->current_high);
    bad = in_order(bad, "startup.align.sweep_speed", align->sweep_speed, speed_limit);
    bad = in_order(bad, "startup.align.sweep_ticks", align->sweep_ticks, align->pull_ticks);
    bad = in_order(bad, "startup.current_move", cfg->current_hold, cfg->current_move);
    bad = in_order(bad, "startup.track_speed", cfg->track_speed, cfg->handover_speed);
    bad = in_order(bad, "startup.hold_speed", cfg->hold_speed, (int64_t)cfg->handover_speed - 1);
    bad = in_order(bad, "startup.loaded_speed", cfg->loaded_speed, cfg->hold_speed);
    bad = in_order(bad, "startup.settle_periods", cfg->settle_periods,
                   (int64_t)cfg->handover_periods - 1);
    return in_order(bad, "startup.residual_lost", cfg->residual_max, cfg->residual_lost);
}

/* With a sensor there is no start-up, and the observer has the speed of the sensor, so it must not be trained. */
static const char *check_sensor(const char *before, const drive_cfg_t *cfg)
{
    const char *bad = before;

    bad = in_order(bad, "startup.current_hold", cfg->startup.current_hold, 0);
    bad = in_order(bad, "observer.eta", cfg->observer.eta, 0);
    bad = in_order(bad, "observer.kappa_p", cfg->observer.kappa_p, 0);
    bad = in_order(bad, "run.acceleration_q14", cfg->run.acceleration_q14, 0);
    return in_order(bad, "observer.momentum_q15", cfg->observer.momentum_q15, 0);
}

/* What two settings have to have in common. */
static const char *check_rules(const drive_cfg_t *cfg)
{
    const char *bad = NULL;

    bad = check_limits(bad, cfg);
    bad = check_speeds(bad, cfg);
    if (cfg->startup.current_hold != 0) {
        bad = check_startup(bad, &cfg->startup, cfg->observer.speed_limit);
    }
    if (cfg->sampling.sensor_pole_pairs != 0U) {
        bad = check_sensor(bad, cfg);
    }
    return bad;
}

const char *config_check(const drive_cfg_t *cfg)
{
    const char *const bad = check_rows(cfg);

    return (bad == NULL) ? check_rules(cfg) : bad;
}
