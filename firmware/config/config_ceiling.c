/* SPDX-License-Identifier: MIT */
#include "config_ceiling.h"

#include "config_rule.h"

#define RATE_SHIFT_MAX (30U)
/*
 * A rate may be lower than the rate of the image by less than 1/1024, because it is rounded and its
 * mantissa has at least 14 bits.
 */
#define ROUNDING (1024U)

/*
 * Whether `fade` falls to 0 later than the fade of the image, or on the other side. A fade with
 * gain 0 never falls.
 */
static bool ends_later(const fade_t *image, const fade_t *fade)
{
    bool later = false;

    if (image->gain > 0) {
        later = (fade->gain <= 0) || (fade->zero > image->zero);
    } else if (image->gain < 0) {
        later = (fade->gain >= 0) || (fade->zero < image->zero);
    } else {
        /* the image has no such derating */
    }
    return later;
}

/*
 * Returns the heat rate per supervision period, scaled to a common exponent. The length of a period
 * depends on the tuning.
 */
static uint64_t rate_of(const drive_cfg_t *cfg)
{
    const derating_cfg_t *const heat = &cfg->derating;

    return (uint64_t)(uint32_t)heat->heat_rate << (RATE_SHIFT_MAX - heat->heat_rate_shift);
}

/*
 * Whether the heat of `cfg` rises more slowly than the heat of the image. The function compares
 * rate / slow_ticks, both sides multiplied by both slow_ticks.
 */
static bool warms_later(const drive_cfg_t *image, const drive_cfg_t *cfg)
{
    const uint64_t found = rate_of(cfg) * (uint64_t)image->slow_ticks;
    const uint64_t least = rate_of(image) * (uint64_t)cfg->slow_ticks;

    return (found * ROUNDING) < (least * (ROUNDING - 1U));
}

/*
 * Whether the power stage may be too hot for longer than in the image. Times are rounded up to
 * whole periods, so one period more is allowed.
 */
static bool waits_longer(const drive_cfg_t *image, const drive_cfg_t *cfg)
{
    const uint64_t found = (uint64_t)cfg->derating.temperature_periods * cfg->slow_ticks;
    const uint64_t most = ((uint64_t)image->derating.temperature_periods + 1U) * image->slow_ticks;

    return found > most;
}

static uint64_t heat_of(const derating_cfg_t *cfg)
{
    return (uint64_t)(uint32_t)cfg->heat_gain << cfg->heat_shift;
}

/*
 * Whether the drive uses an angle sensor, and sensor.kind names none. Then the angle comes from the
 * binding. Only the image's own configuration knows whether this binding has one.
 */
static bool believes_binding(const drive_cfg_t *cfg)
{
    return (cfg->sampling.sensor_pole_pairs != 0U) &&
           (cfg->sensor.kind == (uint32_t)SENSOR_KIND_NONE);
}

static const char *board_crossed(const drive_cfg_t *image, const drive_cfg_t *cfg)
{
    const protection_cfg_t *const limits = &image->protection;
    const derating_cfg_t *const hot = &image->derating;
    const derating_cfg_t *const derating = &cfg->derating;
    const config_rule_t rules[] = {
        {"protection.current_max", cfg->protection.current_max > limits->current_max},
        {"protection.bus_max", cfg->protection.bus_max > limits->bus_max},
        {"protection.offset_max", cfg->protection.offset_max > limits->offset_max},
        {"derating.temperature", ends_later(&hot->temperature, &derating->temperature)},
        {"derating.temperature_lowest", derating->temperature_lowest < hot->temperature_lowest},
        {"derating.temperature_highest", derating->temperature_highest > hot->temperature_highest},
        {"derating.temperature_periods", waits_longer(image, cfg)},
        {"sensor.kind", believes_binding(cfg) && !believes_binding(image)},
    };

    return config_rule_broken(rules, CONFIG_RULES(rules));
}

static const char *motor_crossed(const drive_cfg_t *image, const drive_cfg_t *cfg)
{
    const derating_cfg_t *const limits = &image->derating;
    const derating_cfg_t *const derating = &cfg->derating;
    const config_rule_t rules[] = {
        {"derating.current_max", derating->current_max > limits->current_max},
        {"derating.current_continuous", derating->current_continuous > limits->current_continuous},
        {"derating.heat_gain", heat_of(derating) < heat_of(limits)},
        {"derating.heat_rate", warms_later(image, cfg)},
        {"derating.heat_max_q14", derating->heat_max_q14 > limits->heat_max_q14},
        {"derating.heat", ends_later(&limits->heat, &derating->heat)},
    };

    return config_rule_broken(rules, CONFIG_RULES(rules));
}

const char *config_ceiling_crossed(const drive_cfg_t *image, const drive_cfg_t *cfg,
                                   bool with_motor)
{
    const char *path = board_crossed(image, cfg);

    if ((path == NULL) && with_motor) {
        path = motor_crossed(image, cfg);
    }
    return path;
}
