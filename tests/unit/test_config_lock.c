/* SPDX-License-Identifier: MIT */
/* What a configuration may not lessen while it is locked: each setting in both directions. */
#include "config_lock.h"
#include "example_cfg.h"
#include "testing.h"

static drive_cfg_t from;
static drive_cfg_t to;

void setUp(void)
{
    from = example_drive_cfg();
    from.derating.bus_current_max = 1000;
    from.derating.bus_regeneration_max = 500;
    from.link.timeout_ticks = 10000U;
    from.safe_state.open_speed = 100000;
    from.protection.bus_min = 100;
    from.oscillation.act = 2U;
    from.oscillation.amplitude_max = 1000;
    from.supervision.phase_range_min = 1000;
    from.supervision.voltage_max = 1000;
    from.supervision.follow_error_max = 1000;
    from.supervision.residual_max = 1000;
    from.supervision.speed_error_max = 1000;
    from.supervision.overspeed = 1000;
    from.supervision.stall_current = 1000;
    from.supervision.sum_max = 1000;
    from.supervision.sum_share_q15 = 1000;
    to = from;
}

/* `from` was there at the start. */
static const char *refused(void)
{
    config_lock_t lock;

    config_lock_keep(&lock, &from);
    return config_lock_refused(&lock, &from, &to);
}

static void assert_refused(const char *path)
{
    TEST_ASSERT_EQUAL_STRING(path, refused());
    to = from;
}

static void assert_free(void)
{
    TEST_ASSERT_NULL(refused());
    to = from;
}

typedef struct {
    const char *path;
    void *setting; /* a word of `to` */
} bound_t;

/* Up to `most` a setting is free, and one more is refused. A setting of `least` is free. */
static void assert_bound(const bound_t *bound, uint32_t most, uint32_t least)
{
    uint32_t *const setting = bound->setting;

    *setting = most;
    assert_free();
    *setting = most + 1U;
    assert_refused(bound->path);
    *setting = least;
    assert_free();
}

TEST(test_the_same_configuration_is_free)
{
    assert_free();
}

TEST(test_the_watch_for_swings_may_do_more_and_not_less)
{
    to.oscillation.act = 1U;
    assert_refused("oscillation.act");
    to.oscillation.act = 0U;
    assert_refused("oscillation.act");
    from.oscillation.act = 1U;
    to.oscillation.act = 2U;
    assert_free();
    to.oscillation.halves_max++;
    assert_refused("oscillation.halves_max");
    to.oscillation.halves_max--;
    assert_free();
}

/* 0 is no limit. */
TEST(test_a_limit_that_may_be_none_may_become_smaller_and_neither_larger_nor_none)
{
    to.link.timeout_ticks++;
    assert_refused("link.timeout_ticks");
    to.link.timeout_ticks = 0U;
    assert_refused("link.timeout_ticks");
    to.link.timeout_ticks--;
    assert_free();
    to.derating.bus_current_max++;
    assert_refused("derating.bus_current_max");
    to.derating.bus_current_max = 0;
    assert_refused("derating.bus_current_max");
    to.derating.bus_regeneration_max++;
    assert_refused("derating.bus_regeneration_max");
    to.derating.bus_regeneration_max = 1;
    assert_free();
    from.link.timeout_ticks = 0U;
    to.link.timeout_ticks = 5U;
    assert_free();
}

TEST(test_a_motor_that_is_shorted_at_a_stop_stays_so)
{
    to.safe_state.open_speed = 0;
    assert_refused("safe_state.open_speed");
    to.safe_state.open_speed = 1;
    assert_free();
    to.safe_state.open_speed = 200001;
    assert_free();
    to.safe_state.open_speed = 200002;
    assert_refused("safe_state.open_speed");
    from.safe_state.open_speed = 0;
    to.safe_state.open_speed = 1;
    assert_free();
    from.safe_state.open_speed = 0;
    to.safe_state.open_speed = 0;
    assert_free();
}

TEST(test_the_lowest_bus_does_not_sink)
{
    to.protection.bus_min--;
    assert_refused("protection.bus_min");
    to.protection.bus_min++;
    assert_free();
}

TEST(test_late_ticks_do_not_become_more_nor_their_window_shorter)
{
    to.supervision.late_max++;
    assert_refused("supervision.late_max");
    to.supervision.late_window -= 1U;
    assert_refused("supervision.late_window");
    to.supervision.late_window++;
    assert_free();
}

TEST(test_a_symptom_does_not_last_longer)
{
    static const bound_t times[] = {
        {"supervision.runaway_periods", &to.supervision.runaway_periods},
        {"supervision.overspeed_periods", &to.supervision.overspeed_periods},
        {"supervision.stall_periods", &to.supervision.stall_periods}};

    for (uint32_t k = 0U; k < (sizeof(times) / sizeof(times[0])); k++) {
        assert_bound(&times[k], *(const uint32_t *)times[k].setting, 0U);
    }
}

TEST(test_a_time_is_the_same_in_slow_periods_of_another_length)
{
    from.derating.heat_rate = 10000;
    from.derating.temperature_periods = 200U;
    from.supervision.late_window = 200U;
    from.supervision.runaway_periods = 200U;
    from.supervision.overspeed_periods = 200U;
    from.supervision.stall_periods = 200U;
    to = from;
    to.slow_ticks = 2U * from.slow_ticks;
    to.derating.heat_rate *= 2;
    to.derating.temperature_periods /= 2U;
    to.supervision.late_window /= 2U;
    to.supervision.runaway_periods /= 2U;
    to.supervision.overspeed_periods /= 2U;
    to.supervision.stall_periods /= 2U;
    assert_free();
}

/* 1000 ticks are 34 periods of 30. */
TEST(test_a_time_may_be_rounded_to_whole_periods)
{
    from.slow_ticks = 10U;
    from.derating.heat_rate = 10000;
    from.supervision.stall_periods = 100U;
    from.supervision.late_window = 100U;
    from.supervision.runaway_periods = 100U;
    from.supervision.overspeed_periods = 100U;
    from.supervision.swing_periods = 100U;
    from.supervision.speed_error_periods = 100U;
    to = from;
    to.slow_ticks = 30U;
    to.supervision.stall_periods = 34U;
    to.supervision.late_window = 34U;
    to.supervision.runaway_periods = 34U;
    to.supervision.overspeed_periods = 34U;
    to.supervision.swing_periods = 34U;
    to.supervision.speed_error_periods = 34U;
    to.derating.temperature_periods = 0U;
    to.derating.heat_rate *= 3;
    TEST_ASSERT_NULL(refused());
    to.supervision.stall_periods = 35U;
    TEST_ASSERT_EQUAL_STRING("supervision.stall_periods", refused());
}

TEST(test_a_watch_is_not_taken_away_by_where_it_begins)
{
    from.oscillation.periods_max = 1000U;
    from.supervision.stall_speed = 1000;
    from.supervision.phase_zero_max = 1000;
    from.supervision.phase_speed_max = 1000;
    to = from;
    to.oscillation.periods_max = 500U;
    to.supervision.stall_speed = 500;
    to.supervision.phase_zero_max = 500;
    to.supervision.phase_speed_max = 500;
    assert_free();
    to.oscillation.periods_max = 499U;
    assert_refused("oscillation.periods_max");
    to.supervision.stall_speed = 499;
    assert_refused("supervision.stall_speed");
    to.supervision.phase_zero_max = 499;
    assert_refused("supervision.phase_zero_max");
    to.supervision.phase_speed_max = 499;
    assert_refused("supervision.phase_speed_max");
}

TEST(test_what_has_a_ceiling_is_not_lifted_above_what_is_in_force_either)
{
    to.protection.current_max++;
    assert_refused("protection.current_max");
    to.derating.current_max++;
    assert_refused("derating.current_max");
    to.derating.current_max--;
    assert_free();
}

TEST(test_a_limit_that_follows_from_the_motor_may_be_twice_as_wide_and_not_wider)
{
    static const bound_t limits[] = {
        {"supervision.phase_range_min", &to.supervision.phase_range_min},
        {"supervision.voltage_max", &to.supervision.voltage_max},
        {"supervision.follow_error_max", &to.supervision.follow_error_max},
        {"supervision.residual_max", &to.supervision.residual_max},
        {"supervision.speed_error_max", &to.supervision.speed_error_max},
        {"supervision.overspeed", &to.supervision.overspeed},
        {"supervision.stall_current", &to.supervision.stall_current},
        {"supervision.sum_max", &to.supervision.sum_max},
        {"supervision.sum_share_q15", &to.supervision.sum_share_q15},
        {"oscillation.amplitude_max", &to.oscillation.amplitude_max}};

    for (uint32_t k = 0U; k < (sizeof(limits) / sizeof(limits[0])); k++) {
        assert_bound(&limits[k], 2001U, 1U); /* half of it is rounded down */
    }
}

TEST(test_a_time_that_follows_from_the_motor_may_be_twice_as_long_and_not_longer)
{
    static const bound_t times[] = {
        {"supervision.swing_periods", &to.supervision.swing_periods},
        {"supervision.speed_error_periods", &to.supervision.speed_error_periods}};

    from.supervision.swing_periods = 100U;
    from.supervision.speed_error_periods = 100U;
    to = from;
    for (uint32_t k = 0U; k < (sizeof(times) / sizeof(times[0])); k++) {
        assert_bound(&times[k], 200U, 0U);
    }
}

TEST(test_many_small_changes_lead_no_further_than_one)
{
    config_lock_t lock;

    config_lock_keep(&lock, &from);
    to.supervision.overspeed = 2000;
    TEST_ASSERT_NULL(config_lock_refused(&lock, &from, &to));
    from = to;
    to.supervision.overspeed = 2002;
    TEST_ASSERT_EQUAL_STRING("supervision.overspeed", config_lock_refused(&lock, &from, &to));
}
