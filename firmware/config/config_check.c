/* SPDX-License-Identifier: MIT */
#include "config_check.h"

#include "fx.h"

#include <stddef.h>
#include <stdint.h>

/* Full scale of a phase current, Q15 of I_b. */
#define CURRENT_MAX (16384)

/* `bad` when something was wrong before, else `name` when value is outside lo…hi, else NULL. */
static const char *in_range(const char *bad, const char *name, int64_t value, int64_t lo,
                            int64_t hi)
{
    const char *result = bad;

    if ((bad == NULL) && ((value < lo) || (value > hi))) {
        result = name;
    }
    return result;
}

/* `bad` when something was wrong before, else `name` when lower is above upper, else NULL. */
static const char *in_order(const char *bad, const char *name, int64_t lower, int64_t upper)
{
    return in_range(bad, name, lower, INT64_MIN, upper);
}

/* The ranges of cfg.def. Straight statements: of a constant configuration the compiler computes them all. */
static const char *check_rows(const drive_cfg_t *cfg)
{
    const char *bad = NULL;
    const char *startup = NULL; /* of the rows that count with a start-up */
    const char *voltage = NULL; /* with a voltage drive */

    /* Of all rows of a kind the first that is wrong, by its path. */
    // cppcheck-suppress misra-c2012-20.7 ; D3: a path is a member, which no brackets may enclose
    // cppcheck-suppress misra-c2012-20.10 ; D4: what is returned is the row's own path
#define CHECK(found, path, lo, hi) found = in_range(found, #path, (int64_t)cfg->path, (lo), (hi));
#define CFG(path, when, lo, hi, quantity, meaning) CHECK(bad, path, lo, hi)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) CHECK(startup, path, lo, hi)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    CHECK(bad, path, lo, hi) CHECK(startup, path, lo_startup, hi)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) CHECK(voltage, path, lo, hi)
    // cppcheck-suppress misra-c2012-20.1 ; D5: the rows are the statements here
#include "cfg.def"

    if ((bad == NULL) && (cfg->startup.current_hold != 0)) {
        bad = startup;
    }
    if ((bad == NULL) && (cfg->voltage_drive.enabled != 0U)) {
        bad = voltage;
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
