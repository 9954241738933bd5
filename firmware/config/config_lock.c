/* SPDX-License-Identifier: MIT */
#include "config_lock.h"

#include "config_rule.h"

/* A limit of 0 is none. */
static bool is_lifted(uint32_t from, uint32_t to)
{
    return (from != 0U) && ((to == 0U) || (to > from));
}

/* Of limits that follow from the motor's constants: both are at least 0. */
static bool is_twice(int32_t from, int32_t to)
{
    return (to / 2) > from;
}

static uint64_t ticks_of(const drive_cfg_t *cfg, uint32_t periods)
{
    return (uint64_t)periods * cfg->slow_ticks;
}

/* A time is rounded to whole periods, which are as long as the tuning makes them. */
static bool is_longer(const drive_cfg_t *from, uint32_t from_periods, const drive_cfg_t *to,
                      uint32_t to_periods)
{
    return ticks_of(to, to_periods) > ticks_of(from, from_periods + 1U);
}

/* What a file chooses. */
static const char *choice_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const supervision_cfg_t *const before = &from->supervision;
    const supervision_cfg_t *const after = &to->supervision;
    const derating_cfg_t *const supply = &from->derating;
    const config_rule_t rules[] = {
        {"oscillation.act", to->oscillation.act < from->oscillation.act},
        {"oscillation.halves_max", to->oscillation.halves_max > from->oscillation.halves_max},
        {"link.timeout_ticks", is_lifted(from->link.timeout_ticks, to->link.timeout_ticks)},
        {"safe_state.open_speed",
         (from->safe_state.open_speed != 0) && (to->safe_state.open_speed == 0)},
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

/* What follows from the motor's constants. */
static const char *limit_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const supervision_cfg_t *const before = &from->supervision;
    const supervision_cfg_t *const after = &to->supervision;
    const config_rule_t rules[] = {
        {"supervision.phase_range_min", is_twice(before->phase_range_min, after->phase_range_min)},
        {"supervision.swing_periods",
         ticks_of(to, after->swing_periods) > (2U * ticks_of(from, before->swing_periods + 1U))},
        {"supervision.voltage_max", is_twice(before->voltage_max, after->voltage_max)},
        {"supervision.follow_error_max",
         is_twice(before->follow_error_max, after->follow_error_max)},
        {"supervision.residual_max", is_twice(before->residual_max, after->residual_max)},
        {"supervision.speed_error_max", is_twice(before->speed_error_max, after->speed_error_max)},
        {"supervision.speed_error_periods",
         ticks_of(to, after->speed_error_periods) >
             (2U * ticks_of(from, before->speed_error_periods + 1U))},
        {"supervision.overspeed", is_twice(before->overspeed, after->overspeed)},
        {"supervision.stall_current", is_twice(before->stall_current, after->stall_current)},
        {"supervision.sum_max", is_twice(before->sum_max, after->sum_max)},
        {"supervision.sum_share_q15", is_twice(before->sum_share_q15, after->sum_share_q15)},
        {"oscillation.amplitude_max",
         is_twice(from->oscillation.amplitude_max, to->oscillation.amplitude_max)},
    };

    return config_rule_broken(rules, CONFIG_RULES(rules));
}

const char *config_lock_refused(const drive_cfg_t *from, const drive_cfg_t *to)
{
    const char *path = choice_refused(from, to);

    if (path == NULL) {
        path = limit_refused(from, to);
    }
    return path;
}
