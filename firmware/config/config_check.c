/* SPDX-License-Identifier: MIT */
#include "config_check.h"

#include "fx.h"
#include "words.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define Q16_MASK (0xFFFFU)
#define HALF_TURN_Q16 (0x8000)
/* Full scale of a phase current, Q15 of I_b. */
#define CURRENT_MAX (16384)

/* A setting is a word, whose lowest byte comes first in memory as in a block. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "words_get() reads the memory of the host");

/* Condition under which the range of a row is checked. */
typedef enum {
    CONFIG_USE_ALWAYS = 0,
    CONFIG_USE_STARTUP,      /* startup.current_hold is not 0 */
    CONFIG_USE_VOLTAGE_DRIVE /* voltage_drive.enabled is not 0 */
} config_use_t;

/* A row of cfg.def. */
typedef struct {
    const char *path; /* path of the setting in drive_cfg_t */
    /* An unsigned setting has both ends in 0…2^31 − 1: a larger value reads as a negative one. */
    int32_t lowest;
    int32_t highest;
    uint16_t offset; /* offset of the setting in drive_cfg_t, bytes */
    uint8_t use;     /* config_use_t */
} config_row_t;

/* Returns `bad` if it is not NULL; otherwise `name` if lower > upper, and NULL if not. */
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
    const uint8_t *const bytes = (const uint8_t *)cfg;
    const int32_t value = fx_signed(words_get(&bytes[row->offset]));

    return (value < row->lowest) || (value > row->highest);
}

/*
 * Returns the path of the first row of this use whose setting is out of its range, in the order of
 * cfg.def, or NULL. A row of CFG_BOTH becomes two here, the second one for the start-up.
 */
static const char *first_outside(const drive_cfg_t *cfg, config_use_t use)
{
    // cppcheck-suppress misra-c2012-20.10 ; D4: the name of a row is its own path
#define ROW(path, lo, hi, use) \
    {#path, (lo), (hi), (uint16_t)offsetof(drive_cfg_t, path), (uint8_t)(use)},
#define CFG(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, CONFIG_USE_ALWAYS)
#define CFG_STARTUP(path, when, lo, hi, quantity, meaning) ROW(path, lo, hi, CONFIG_USE_STARTUP)
#define CFG_BOTH(path, when, lo, lo_startup, hi, quantity, meaning) \
    ROW(path, lo, hi, CONFIG_USE_ALWAYS) \
    ROW(path, lo_startup, hi, CONFIG_USE_STARTUP)
#define CFG_VOLTAGE(path, when, lo, hi, quantity, meaning) \
    ROW(path, lo, hi, CONFIG_USE_VOLTAGE_DRIVE)
    static const config_row_t rows[] = {
    // cppcheck-suppress misra-c2012-20.1 ; D5: the rows of the table are those of the file
#include "cfg.def"
    };
    const char *bad = NULL;

    for (uint32_t k = 0U; (k < (uint32_t)(sizeof(rows) / sizeof(rows[0]))) && (bad == NULL); k++) {
        if ((rows[k].use == (uint8_t)use) && lies_outside(&rows[k], cfg)) {
            bad = rows[k].path;
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

/*
 * Checks the limits of bus and currents. With any allowed offset, a sample at an end of the
 * converter's range has to exceed the over-current limit, see protection.h.
 */
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

/* The sectors of Hall sensors: each begins ahead of the one before, less than half a turn. */
static const char *check_hall(const char *before, const hall_cfg_t *cfg)
{
    const char *bad = before;
    uint32_t turn = 0U;

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        const uint32_t next = cfg->edges_q16[(k + 1U) % HALL_SECTORS];
        const uint32_t width = (next - cfg->edges_q16[k]) & Q16_MASK;

        turn += width;
        bad = in_order(bad, "sensor.hall.edges_q16", 1, (int64_t)width);
        bad = in_order(bad, "sensor.hall.edges_q16", (int64_t)width, HALF_TURN_Q16 - 1);
    }
    bad = in_order(bad, "sensor.hall.edges_q16", (int64_t)turn, (int64_t)Q16_MASK + 1);
    return ((bad == NULL) && !hall_order_holds(cfg->patterns)) ? "sensor.hall.patterns" : bad;
}

/*
 * A sensor with an observer beside it needs a start-up: when the sensor fails, the observer holds
 * the motor only above the hand-over speed. Without an observer (eta is 0) there is none, so an
 * encoder needs an observer, to be aligned.
 */
static const char *check_sensor(const char *before, const drive_cfg_t *cfg)
{
    const sensor_cfg_t *const sensor = &cfg->sensor;
    const char *bad = before;

    if (cfg->observer.eta == 0) {
        bad = in_order(bad, "startup.current_hold", cfg->startup.current_hold, 0);
        bad = in_order(bad, "observer.kappa_p", cfg->observer.kappa_p, 0);
        bad = in_order(bad, "run.acceleration_q14", cfg->run.acceleration_q14, 0);
        bad = in_order(bad, "observer.momentum_q15", cfg->observer.momentum_q15, 0);
        bad = in_order(bad, "sensor.observer_above", sensor->observer_above, 0);
    } else {
        bad = in_order(bad, "startup.current_hold", 1, cfg->startup.current_hold);
    }
    if ((sensor->kind == (uint32_t)SENSOR_KIND_ENCODER) ||
        (sensor->kind == (uint32_t)SENSOR_KIND_ENCODER_INDEX)) {
        bad = in_order(bad, "startup.current_hold", 1, cfg->startup.current_hold);
    }
    if (sensor->kind == (uint32_t)SENSOR_KIND_HALL) {
        bad = check_hall(bad, &sensor->hall);
    }
    return in_order(bad, "sensor.sensor_below", sensor->sensor_below, sensor->observer_above);
}

/* The readings of an input are in order, and its times are not 0. */
static const char *check_input(const char *before, const input_cfg_t *cfg)
{
    const char *bad = before;

    bad = in_order(bad, "input.low", cfg->least, cfg->low);
    bad = in_order(bad, "input.middle", cfg->low, cfg->middle);
    bad = in_order(bad, "input.high", (int64_t)cfg->middle + 1, cfg->high);
    bad = in_order(bad, "input.most", cfg->high, cfg->most);
    bad = in_order(bad, "input.slope_q30", 1, cfg->slope_q30);
    bad = in_order(bad, "input.timeout_ticks", 1, (int64_t)cfg->timeout_ticks);
    return in_order(bad, "input.arm_ticks", 1, (int64_t)cfg->arm_ticks);
}

/* Rules between two settings. */
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
    if (cfg->input.kind != (uint32_t)INPUT_KIND_NONE) {
        bad = check_input(bad, &cfg->input);
    }
    return bad;
}

const char *config_check(const drive_cfg_t *cfg)
{
    const char *const bad = check_rows(cfg);

    return (bad == NULL) ? check_rules(cfg) : bad;
}
