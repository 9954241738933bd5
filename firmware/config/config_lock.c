/* SPDX-License-Identifier: MIT */
#include "config_lock.h"

#include "config_ceiling.h"
#include "config_rule.h"
#include "fx.h"

/* Whether a limit has become higher or has been removed. 0 means that there is no limit. */
static bool is_lifted(uint32_t from, uint32_t to)
{
    return (from != 0U) && ((to == 0U) || (to > from));
}

/*
 * Whether a time has become longer. It is a number of periods, whose length depends on the tuning.
 * It is rounded up to whole periods, so a difference of less than one period does not count.
 */
static bool is_longer(const drive_cfg_t *from, uint32_t from_periods, const drive_cfg_t *to,
                      uint32_t to_periods)
{
    const uint64_t rounded = ((uint64_t)from_periods * from->slow_ticks) + to->slow_ticks;

    return ((uint64_t)to_periods * to->slow_ticks) >= rounded;
}

/*
 * Whether the threshold at which a check begins has fallen below half. With a threshold that is low
 * enough the check would never begin.
 */
static bool is_half(int32_t from, int32_t to)
{
    return to < (from / 2);
}

/*
 * Whether the gates may open at more than twice the open_speed of `from`. Above open_speed a stop
 * shorts the motor; with 0 it never does.
 */
static bool is_open_further(step_t from, step_t to)
{
    return (from != 0) && ((to == 0) || ((to / 2) > from));
}

/*
 * Returns the path of the first setting that protects less than the same setting of `from`, or
 * NULL.
 */
static const char *choice_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const supervision_cfg_t *const before = &from->supervision;
    const supervision_cfg_t *const after = &to->supervision;
    const derating_cfg_t *const supply = &from->derating;
    const config_rule_t rules[] = {
        {"oscillation.act", to->oscillation.act < from->oscillation.act},
        {"oscillation.halves_max", to->oscillation.halves_max > from->oscillation.halves_max},
        {"link.timeout_ticks", is_lifted(from->link.timeout_ticks, to->link.timeout_ticks)},
        {"console.timeout_ticks",
         is_lifted(from->console.timeout_ticks, to->console.timeout_ticks)},
        {"input.timeout_ticks", is_lifted(from->input.timeout_ticks, to->input.timeout_ticks)},
        {"input.arm_ticks", to->input.arm_ticks < from->input.arm_ticks},
        {"safe_state.open_speed",
         is_open_further(from->safe_state.open_speed, to->safe_state.open_speed)},
        {"oscillation.periods_max",
         is_half((int32_t)from->oscillation.periods_max, (int32_t)to->oscillation.periods_max)},
        {"supervision.stall_speed", is_half(before->stall_speed, after->stall_speed)},
        {"supervision.phase_zero_max", is_half(before->phase_zero_max, after->phase_zero_max)},
        {"supervision.phase_speed_max", is_half(before->phase_speed_max, after->phase_speed_max)},
        {"protection.bus_min", to->protection.bus_min < from->protection.bus_min},
        {"derating.bus_current_max",
         is_lifted((uint32_t)supply->bus_current_max, (uint32_t)to->derating.bus_current_max)},
        {"derating.bus_regeneration_max", is_lifted((uint32_t)supply->bus_regeneration_max,
                                                    (uint32_t)to->derating.bus_regeneration_max)},
        {"supervision.late_max", after->late_max > before->late_max},
        {"supervision.late_window", is_longer(to, after->late_window, from, before->late_window)},
        {"supervision.runaway_periods",
         is_longer(from, before->runaway_periods, to, after->runaway_periods)},
        {"supervision.overspeed_periods",
         is_longer(from, before->overspeed_periods, to, after->overspeed_periods)},
        {"supervision.stall_periods",
         is_longer(from, before->stall_periods, to, after->stall_periods)},
    };

    return config_rule_broken(rules, CONFIG_RULES(rules));
}

/*
 * The limits are in the order of `paths` below. Times are in ticks: 100 ticks · 10^6 periods = 10^8
 * fit into a word.
 */
void config_lock_keep(config_lock_t *lock, const drive_cfg_t *cfg)
{
    const supervision_cfg_t *const now = &cfg->supervision;

    *lock = (config_lock_t){
        {fx_unsigned(now->phase_range_min), now->swing_periods * cfg->slow_ticks,
         fx_unsigned(now->voltage_max), fx_unsigned(now->follow_error_max),
         fx_unsigned(now->residual_max), fx_unsigned(now->speed_error_max),
         now->speed_error_periods * cfg->slow_ticks, fx_unsigned(now->overspeed),
         fx_unsigned(now->stall_current), fx_unsigned(now->sum_max),
         fx_unsigned(now->sum_share_q15), fx_unsigned(cfg->oscillation.amplitude_max)}};
}

/*
 * Returns the path of the first limit that is more than twice as wide as the limit in `lock`, or
 * NULL.
 */
static const char *limit_refused(const config_lock_t *lock, const drive_cfg_t *to)
{
    static const char *const paths[CONFIG_LOCK_LIMITS] = {
        "supervision.phase_range_min",     "supervision.swing_periods",
        "supervision.voltage_max",         "supervision.follow_error_max",
        "supervision.residual_max",        "supervision.speed_error_max",
        "supervision.speed_error_periods", "supervision.overspeed",
        "supervision.stall_current",       "supervision.sum_max",
        "supervision.sum_share_q15",       "oscillation.amplitude_max"};
    const char *path = NULL;
    config_lock_t found;

    config_lock_keep(&found, to);
    for (uint32_t k = 0U; (k < CONFIG_LOCK_LIMITS) && (path == NULL); k++) {
        if ((found.limits[k] / 2U) > lock->limits[k]) {
            path = paths[k];
        }
    }
    return path;
}

const char *config_lock_refused(const config_lock_t *lock, const drive_cfg_t *from,
                                const drive_cfg_t *to)
{
    const char *path = config_ceiling_crossed(from, to, true);

    if (path == NULL) {
        path = choice_refused(from, to);
    }
    if (path == NULL) {
        path = limit_refused(lock, to);
    }
    return path;
}
