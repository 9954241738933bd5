/* SPDX-License-Identifier: MIT */
/*
 * Speed and position loops: ramp, limits, feed-forward, and the promises of the position profile.
 */
#include "example_cfg.h"
#include "motion_loop.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define TURN_Q32 ((int64_t)1 << 32)
#define FAR_AWAY_Q32 ((int64_t)1 << 62)
#define RATIO_ONE_Q17 (131072)

static speed_loop_cfg_t speed_cfg;
static torque_range_t torque;
static speed_loop_t speed_loop;
static position_loop_cfg_t cfg;
static position_loop_t loop;
static uint32_t ticks; /* control ticks in a slow period */

void setUp(void)
{
    speed_cfg = example_speed_loop_cfg();
    torque = (torque_range_t){-8192, 8192};
    cfg = example_position_loop_cfg();
    speed_loop_init(&speed_loop);
    position_loop_reset(&loop, 0, 0);
    ticks = 10U;
}

static int64_t magnitude(int64_t x)
{
    return (x < 0) ? -x : x;
}

/* i_q* of a slow period. */
static int32_t demand(step_t reference, step_t measured)
{
    return speed_loop_step(&speed_loop, &speed_cfg, reference, measured, torque);
}

/* i_q for the change from standstill to that reference. */
static int32_t accelerate(step_t reference)
{
    speed_loop_reset(&speed_loop, 0);
    return speed_loop_accelerate(&speed_loop, &speed_cfg, reference, torque);
}

static void set_inertia(int32_t inertia, uint32_t shift, uint32_t lift)
{
    speed_cfg.inertia = inertia;
    speed_cfg.inertia_shift = shift;
    speed_cfg.inertia_lift = lift;
}

/* The speed reference of a slow period. */
static step_t lead(int64_t target_q32, int64_t measured_q32)
{
    return position_loop_step(&loop, &cfg, target_q32, measured_q32, ticks);
}

/* ---- speed ---- */

TEST(test_another_reference_leaves_the_torque)
{
    pi_reset(&speed_loop.pi, 1234);
    speed_loop_refer(&speed_loop, -7654321);
    TEST_ASSERT_EQUAL_INT32(-7654321, speed_loop.reference);
    TEST_ASSERT_EQUAL_INT32(1234, pi_output(&speed_loop.pi));
}

TEST(test_speed_reset_starts_at_the_present_speed_without_demand)
{
    speed_loop.pi.integral_q26 = 12345678;
    speed_loop_reset(&speed_loop, 1000000);
    TEST_ASSERT_EQUAL_INT32(1000000, speed_loop.reference);
    TEST_ASSERT_EQUAL_INT32(0, demand(1000000, 1000000));
}

TEST(test_ramp_reaches_the_target_exactly_and_in_the_fewest_periods)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const step_t target = sign * 10000001;
        const int32_t periods = (10000001 + speed_cfg.ramp - 1) / speed_cfg.ramp;

        speed_loop_reset(&speed_loop, 0);
        for (int32_t k = 0; k < periods; k++) {
            const step_t next = speed_loop_ramp(&speed_loop, &speed_cfg, target);

            TEST_ASSERT_TRUE(next != speed_loop.reference);
            TEST_ASSERT_TRUE(abs(next - speed_loop.reference) <= speed_cfg.ramp);
            speed_loop.reference = next;
        }
        TEST_ASSERT_EQUAL_INT32(target, speed_loop.reference);
        TEST_ASSERT_EQUAL_INT32(target, speed_loop_ramp(&speed_loop, &speed_cfg, target));
    }
}

TEST(test_ramp_never_goes_beyond_the_largest_speed_for_any_target)
{
    static const step_t targets[] = {INT32_MAX, INT32_MIN, 0x20000000, -0x20000000};

    speed_cfg.ramp = 0x20000000;
    for (uint32_t i = 0U; i < 4U; i++) {
        const step_t end = (targets[i] > 0) ? speed_cfg.speed_max : -speed_cfg.speed_max;

        TEST_ASSERT_EQUAL_INT32(end, speed_loop_ramp(&speed_loop, &speed_cfg, targets[i]));
    }
}

/*
 * Half of K_p and a quarter of K_i below the limit of the reference, whatever was measured; from
 * there on those of before.
 */
TEST(test_below_its_limit_the_loop_has_the_soft_gains)
{
    const step_t limit = 1000000;

    speed_cfg.inertia = 0;
    speed_cfg.soft = speed_cfg.pi;
    speed_cfg.soft.kp_shift++;
    speed_cfg.soft.ki_shift += 2U;
    speed_cfg.soft_speed = limit;
    for (int32_t k = 0; k < 4; k++) {
        const int32_t sign = (k < 2) ? -1 : 1;
        const step_t reference = sign * (limit - (k % 2));
        const step_t measured = reference - (sign * 300000);
        speed_loop_t expected = {.reference = reference};
        speed_loop_cfg_t one = speed_cfg;

        one.soft_speed = 0;
        one.pi = ((k % 2) != 0) ? speed_cfg.soft : speed_cfg.pi;
        speed_loop = expected;
        for (int32_t period = 0; period < 5; period++) {
            TEST_ASSERT_EQUAL_INT32(speed_loop_step(&expected, &one, reference, measured, torque),
                                    demand(reference, measured));
        }
        TEST_ASSERT_EQUAL_INT32(expected.pi.integral_q26, speed_loop.pi.integral_q26);
    }
}

/* 100000 · 32471 / 2^21 = 1548.3 */
TEST(test_acceleration_feed_forward_is_the_change_of_the_reference_times_the_inertia_in_force)
{
    speed_cfg.pi.kp = 0;
    speed_cfg.pi.ki = 0;
    TEST_ASSERT_EQUAL_INT32(1548, demand(100000, 0));
    TEST_ASSERT_EQUAL_INT32(0, demand(100000, 0));
    TEST_ASSERT_EQUAL_INT32(-1549, demand(0, 0));
    speed_loop.inertia_q17 = RATIO_ONE_Q17 / 4 * 7;
    TEST_ASSERT_EQUAL_INT32(1548 * 7 / 4, demand(100000, 0));
}

/*
 * Who compares the demand with its limit to tell whether there is torque to spare has to see the
 * limit itself. A demand has the 15 bits of a measured current.
 */
TEST(test_both_ends_of_any_range_are_reached)
{
    static const torque_range_t ranges[] = {{-100, 3001}, {-101, 3000},    {-3001, 100},
                                            {-3000, 101}, {-1, 0},         {0, 1},
                                            {-100, 3000}, {-16384, 16383}, {-16384, 16384}};

    speed_cfg.pi = (pi_cfg_t){.kp = 32767, .kp_shift = 1U, .ki_shift = 1U};
    speed_cfg.speed_max = 0x20000000;
    for (uint32_t k = 0U; k < (sizeof(ranges) / sizeof(ranges[0])); k++) {
        torque = ranges[k];
        speed_loop_reset(&speed_loop, 0);
        TEST_ASSERT_EQUAL_INT32(fx_min(torque.upper, 16383), demand(0x20000000, -0x20000000));
        speed_loop_reset(&speed_loop, 0);
        TEST_ASSERT_EQUAL_INT32(torque.lower, demand(-0x20000000, 0x20000000));
    }
}

/*
 * The integral ends where the demand does: what lies beyond would have to be unwound before the
 * demand moves.
 */
TEST(test_an_integral_held_at_either_end_of_an_uneven_range_leaves_it_at_once)
{
    static const torque_range_t ranges[] = {{0, 1000}, {-1000, 0}, {200, 1000}};

    speed_cfg.pi = (pi_cfg_t){.ki = 32767, .kp_shift = 1U, .ki_shift = 14U};
    speed_cfg.speed_max = 0x20000000;
    for (uint32_t k = 0U; k < 6U; k++) {
        const bool up = (k % 2U) != 0U;
        const step_t far = up ? 0x1000000 : -0x1000000;
        const int32_t end = up ? ranges[k / 2U].upper : ranges[k / 2U].lower;

        torque = ranges[k / 2U];
        speed_loop_reset(&speed_loop, 0);
        for (uint32_t period = 0U; period < 1000U; period++) {
            (void)demand(far, -far);
        }
        TEST_ASSERT_EQUAL_INT32(end, demand(far, -far));
        TEST_ASSERT_TRUE(((up ? 1 : -1) * (end - demand(-far, far))) > 0);
    }
}

/*
 * 3 steps lifted by 2^14: 3·2^14·24576 / 2^16 = 18432 cut to the range; a step is 6144. From 2^16
 * steps on the lift ends.
 */
TEST(test_a_change_is_lifted_where_a_step_takes_more_than_half_an_lsb)
{
    static const step_t changes[] = {1, -1, 0, 3, -3, 65537, -65537, 0x20000000, -0x20000000};
    static const int32_t torques[] = {6144, -6144, 0, 8192, -8192, 8192, -8192, 8192, -8192};

    set_inertia(24576, 0U, 14U);
    speed_cfg.speed_max = 0x20000000;
    for (uint32_t i = 0U; i < (sizeof changes / sizeof changes[0]); i++) {
        TEST_ASSERT_EQUAL_INT32(torques[i], accelerate(changes[i]));
    }
    /* 2^30, at which a change ends, over 2^16: one step less would be 16383. */
    torque = (torque_range_t){-16384, 16384};
    set_inertia(1, 0U, 14U);
    TEST_ASSERT_EQUAL_INT32(16384, accelerate(0x10000));
}

/* Errors beyond ±1 count as that: 2^15·2^14 / 2^20 = 512, and 1 LSB less is rounded down. */
TEST(test_speed_error_saturates_to_16_bits_on_both_sides)
{
    speed_cfg.pi = (pi_cfg_t){.kp = 16384, .kp_shift = 20U, .ki = 0, .ki_shift = 1U};
    speed_cfg.inertia = 0;
    speed_cfg.error_shift = 1U;
    TEST_ASSERT_EQUAL_INT32(511, demand(0, -80000));
    TEST_ASSERT_EQUAL_INT32(-512, demand(0, 80000));
}

TEST(test_current_demand_stays_within_its_limit_for_any_speeds_and_gains)
{
    seeded_t seed = {0x5FEEDU};

    for (int32_t k = 0; k < 100000; k++) {
        const step_t reference = seeded_i32(&seed);
        const step_t measured = seeded_in(&seed, -0x20000000, 0x20000000);
        int32_t current;

        if ((k % 100) == 0) {
            speed_cfg.pi = (pi_cfg_t){32767, 32767, (uint32_t)seeded_in(&seed, 1, 30),
                                      (uint32_t)seeded_in(&seed, 1, 30)};
            speed_cfg.speed_max = ((k % 200) == 0) ? 0x20000000 : 28633115;
            set_inertia(32767, (uint32_t)seeded_in(&seed, 0, 30),
                        (uint32_t)seeded_in(&seed, 0, 14));
            speed_cfg.error_shift = (uint32_t)seeded_in(&seed, 1, 17);
            torque = (torque_range_t){seeded_in(&seed, -16384, 0), seeded_in(&seed, 0, 16384)};
            speed_loop_reset(&speed_loop, 0);
        }
        current = demand(reference, measured);
        TEST_ASSERT_TRUE((current >= torque.lower) && (current <= torque.upper));
    }
}

/*
 * The last of these references are beyond the largest speed. Unequal limits of the two directions
 * are no torque by themselves.
 */
TEST(test_acceleration_gives_the_feed_forward_alone_and_takes_the_reference_over)
{
    speed_loop_t alone = speed_loop;

    alone.pi.integral_q26 = 12345678;
    speed_cfg.pi.kp = 0;
    speed_cfg.pi.ki = 0;
    for (int32_t k = 1; k <= 20; k++) {
        const step_t reference = ((k % 3) - 1) * ((k < 17) ? (k * 10000) : INT32_MAX);
        const step_t taken = fx_clamp(reference, -speed_cfg.speed_max, speed_cfg.speed_max);

        torque = ((k % 2) == 0) ? (torque_range_t){-2000, 6000} : (torque_range_t){-6000, 2000};
        TEST_ASSERT_EQUAL_INT32(demand(reference, 0),
                                speed_loop_accelerate(&alone, &speed_cfg, reference, torque));
        TEST_ASSERT_EQUAL_INT32(taken, alone.reference);
        TEST_ASSERT_EQUAL_INT32(taken, speed_loop.reference);
    }
    TEST_ASSERT_EQUAL_INT32(12345678, alone.pi.integral_q26);
}

TEST(test_start_goes_on_with_the_given_current_at_a_steady_speed)
{
    static const int32_t currents[] = {0, 1, -1, 4321, -4321, 8192, -8192, 32767, -32767};

    for (uint32_t i = 0U; i < (sizeof currents / sizeof currents[0]); i++) {
        speed_loop.pi.integral_q26 = -999999;
        speed_loop_start(&speed_loop, 5000000, currents[i]);
        for (int32_t k = 0; k < 3; k++) {
            TEST_ASSERT_EQUAL_INT32(fx_clamp(currents[i], -8192, 8192), demand(5000000, 5000000));
        }
    }
}

/* ---- position ---- */

/*
 * Slow periods that the profile may need for a distance: full speed all the way, twice the time to
 * full speed, and the fade-out: time constant softness = 2cB/speed_max of 15 units in natural
 * logarithms.
 */
static int32_t longest_time(int64_t distance_q32)
{
    const int64_t cruise = magnitude(distance_q32) / ((int64_t)cfg.speed_max * (int64_t)ticks);
    const int64_t ramp = 2 * (cfg.speed_max / cfg.ramp);
    const int64_t braking_q32 = (((int64_t)1 << 30) / cfg.braking_inverse) << cfg.distance_shift;
    const int64_t softness =
        2 * cfg.softness_q15 * (braking_q32 / 32768) / ((int64_t)cfg.speed_max * (int64_t)ticks);

    return (int32_t)(cruise + ramp + ((softness + 2) * 12) + 200);
}

/* position + way as the rotor position counts: modulo 2^64. */
static int64_t wrapped(int64_t position_q32, int64_t way)
{
    return (int64_t)((uint64_t)position_q32 + (uint64_t)way);
}

/* One slow period with the profile's promises: by its speed times the ticks, within its limits. */
static void step_profile(int64_t target_q32)
{
    const step_t before = loop.profile_speed;
    const int64_t before_q32 = loop.profile_q32;

    (void)lead(target_q32, before_q32);
    TEST_ASSERT_TRUE(
        (loop.profile_q32 == target_q32) ||
        (loop.profile_q32 == wrapped(before_q32, loop.profile_speed * (int64_t)ticks)));
    TEST_ASSERT_TRUE(abs(loop.profile_speed) <= cfg.speed_max);
    TEST_ASSERT_TRUE(abs(loop.profile_speed - before) <= cfg.ramp);
}

static void assert_profile(int64_t profile_q32, step_t speed)
{
    TEST_ASSERT_EQUAL_INT64(profile_q32, loop.profile_q32);
    TEST_ASSERT_EQUAL_INT32(speed, loop.profile_speed);
}

/* Runs the profile to the target; fails when it is not there in time, leaves it, or goes beyond. */
static void run_to_within(int64_t target_q32, int64_t beyond_q32)
{
    const int64_t distance = target_q32 - loop.profile_q32;
    const int32_t time = longest_time(distance);

    for (int32_t k = 0; k < time; k++) {
        step_profile(target_q32);
        TEST_ASSERT_TRUE((distance >= 0) ? (loop.profile_q32 <= (target_q32 + beyond_q32))
                                         : (loop.profile_q32 >= (target_q32 - beyond_q32)));
    }
    TEST_ASSERT_EQUAL_INT64(target_q32, loop.profile_q32);
}

static void run_to(int64_t target_q32)
{
    run_to_within(target_q32, 0);
    TEST_ASSERT_EQUAL_INT32(0, loop.profile_speed);
}

TEST(test_position_reset_starts_where_the_rotor_is_and_as_fast)
{
    loop.profile_speed = 5;
    position_loop_reset(&loop, -123456789012, 0);
    assert_profile(-123456789012, 0);
    TEST_ASSERT_EQUAL_INT32(0, lead(-123456789012, -123456789012));
    position_loop_reset(&loop, 123456789012, -7654321);
    assert_profile(123456789012, -7654321);
}

/* The configuration's acceleration is meant for 10 ticks: the same one for a period of `count`. */
static void use_slow_period(uint32_t count)
{
    ticks = count;
    cfg.ramp = (int32_t)(((int64_t)cfg.ramp * count) / 10);
}

TEST(test_profile_reaches_seeded_targets_exactly_without_overshoot)
{
    static const uint32_t periods[] = {2U, 10U, 37U};
    seeded_t seed = {0x7A46E7U};

    for (uint32_t i = 0U; i < 3U; i++) {
        setUp();
        use_slow_period(periods[i]);
        for (int32_t run = 0; run < ((periods[i] == 10U) ? 300 : 50); run++) {
            /* Up to 40 turns, many of them short. */
            const int64_t scale = (int64_t)1 << seeded_in(&seed, 0, 22);

            run_to(loop.profile_q32 + (seeded_in(&seed, -41000, 41000) * scale));
        }
    }
}

/* The last two have the softest stop, at either end of the units. */
TEST(test_profile_reaches_full_speed_on_a_long_way)
{
    static const struct {
        int32_t braking_inverse;
        uint32_t distance_shift;
        int32_t softness_q15;
    } cases[] = {{66754, 19U, 2503}, {0x10000, 19U, 12288}, {0x20000, 20U, 12288}};

    for (uint32_t i = 0U; i < 3U; i++) {
        step_t fastest = 0;

        cfg.braking_inverse = cases[i].braking_inverse;
        cfg.distance_shift = cases[i].distance_shift;
        cfg.softness_q15 = cases[i].softness_q15;
        position_loop_reset(&loop, 0, 0);
        for (int32_t k = 0; k < 1500; k++) {
            step_profile(20 * TURN_Q32);
            TEST_ASSERT_TRUE(loop.profile_q32 <= (20 * TURN_Q32));
            fastest = (loop.profile_speed > fastest) ? loop.profile_speed : fastest;
        }
        /* Full speed is 32767/32768 of the largest; of that, half is rounded down. */
        TEST_ASSERT_EQUAL_INT32(2 * (int32_t)(((int64_t)cfg.speed_max * 32767) >> 16U), fastest);
        TEST_ASSERT_EQUAL_INT64(20 * TURN_Q32, loop.profile_q32);
    }
}

TEST(test_profile_goes_both_ways_alike)
{
    position_loop_t other;

    position_loop_reset(&other, 0, 0);
    for (int32_t k = 0; k < 2000; k++) {
        step_profile(5 * TURN_Q32);
        (void)position_loop_step(&other, &cfg, -5 * TURN_Q32, other.profile_q32, ticks);
        assert_profile(-other.profile_q32, -other.profile_speed);
    }
}

TEST(test_profile_of_one_unit_or_less_jumps)
{
    const int64_t unit = (int64_t)1 << cfg.distance_shift;
    const int64_t ways[] = {unit - 1, 1 - unit, 1, -1};

    for (uint32_t i = 0U; i < 4U; i++) {
        position_loop_reset(&loop, 0, 0);
        (void)lead(ways[i], 0);
        assert_profile(ways[i], 0);
    }
}

TEST(test_profile_that_turns_round_stands_for_a_moment_and_does_not_jump)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        position_loop_reset(&loop, 0, -sign * cfg.ramp);
        (void)lead(sign * TURN_Q32, 0);
        assert_profile(0, 0);
    }
}

/*
 * Distance in which the profile stops from its present speed, generously: twice v²/2a and one
 * period.
 */
static int64_t stopping_distance(void)
{
    const int64_t v = loop.profile_speed;

    return ((v * v) / cfg.ramp * (int64_t)ticks) + (magnitude(v) * (int64_t)ticks);
}

static void step_profiles(int64_t target_q32, int32_t periods)
{
    for (int32_t k = 0; k < periods; k++) {
        step_profile(target_q32);
    }
}

TEST(test_profile_stops_without_overshoot_at_targets_changed_on_the_way)
{
    seeded_t seed = {0x2E7A46E7U};

    for (int32_t run = 0; run < 300; run++) {
        const int64_t first =
            loop.profile_q32 + (seeded_in(&seed, -40000, 40000) * (TURN_Q32 / 1000));
        int64_t ahead;

        step_profiles(first, seeded_in(&seed, 1, 400));
        /* Somewhere ahead, no nearer than the profile can stop. */
        ahead = stopping_distance() + seeded_in(&seed, 0, INT32_MAX) + ((int64_t)1 << 20);
        run_to(loop.profile_q32 + ((loop.profile_speed < 0) ? -ahead : ahead));
    }
}

TEST(test_profile_keeps_its_limits_and_arrives_for_targets_changed_to_anywhere)
{
    seeded_t seed = {0xA4A4A4A4U};

    for (int32_t run = 0; run < 300; run++) {
        const int64_t target = (int64_t)seeded_in(&seed, -20000, 20000) * (TURN_Q32 / 1000);

        step_profiles(target, seeded_in(&seed, 1, 400));
    }
    step_profiles(0, 3000);
    TEST_ASSERT_EQUAL_INT64(0, loop.profile_q32);
}

/*
 * As after a change of mode: 1800 rpm, twice the profile's own limit, and the target is where it
 * is.
 */
TEST(test_profile_started_too_fast_slows_by_one_ramp_a_period_and_comes_back)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const step_t speed = sign * 25769804;
        /* v²/2a to rest, with v·T/2 for the sum over whole periods instead of the integral. */
        const int64_t v = magnitude(speed);
        const int64_t stop = (((v * v) / cfg.ramp) + v) * ticks / 2;
        int64_t farthest = 0;

        position_loop_reset(&loop, 5 * TURN_Q32, speed);
        for (int32_t k = 0; k < 2000; k++) {
            const step_t before = loop.profile_speed;
            const int64_t away = magnitude(loop.profile_q32 - (5 * TURN_Q32));

            farthest = (away > farthest) ? away : farthest;
            (void)lead(5 * TURN_Q32, loop.profile_q32);
            TEST_ASSERT_TRUE(abs(loop.profile_speed - before) <= cfg.ramp);
        }
        TEST_ASSERT_TRUE((farthest <= stop) && (farthest >= (stop - (v * ticks))));
        assert_profile(5 * TURN_Q32, 0);
    }
}

TEST(test_profile_takes_the_shorter_way_across_the_wrap_both_ways)
{
    for (int64_t sign = -1; sign <= 1; sign += 2) {
        const int64_t start = wrapped(INT64_MIN, -sign * (TURN_Q32 + 12345));
        const int64_t target = wrapped(INT64_MIN, sign * TURN_Q32);
        const int32_t time = longest_time(3 * TURN_Q32);

        TEST_ASSERT_TRUE((start < 0) != (target < 0));
        position_loop_reset(&loop, start, 0);
        for (int32_t k = 0; k < time; k++) {
            step_profile(target);
            TEST_ASSERT_TRUE((sign * loop.profile_speed) >= 0);
        }
        assert_profile(target, 0);
    }
}

TEST(test_targets_half_the_range_away_are_allowed)
{
    static const int64_t starts[] = {0, INT64_MIN, INT64_MAX, -1};

    for (uint32_t i = 0U; i < 4U; i++) {
        const int64_t opposite = wrapped(starts[i], INT64_MIN);

        /* Both ways are equally long: either is right. */
        position_loop_reset(&loop, starts[i], 0);
        (void)lead(opposite, opposite);
        TEST_ASSERT_EQUAL_INT32(cfg.ramp, abs(loop.profile_speed));
    }
}

TEST(test_profile_works_at_the_ends_of_the_position_range)
{
    position_loop_reset(&loop, -FAR_AWAY_Q32, 0);
    run_to(-FAR_AWAY_Q32 + TURN_Q32);
    /* As far away as a command can be: the profile only has to go the right way. */
    step_profile(INT32_MAX * (int64_t)65536);
    TEST_ASSERT_TRUE(loop.profile_speed > 0);
    position_loop_reset(&loop, FAR_AWAY_Q32, 0);
    run_to(FAR_AWAY_Q32 - TURN_Q32);
    step_profile(INT32_MIN * (int64_t)65536);
    TEST_ASSERT_TRUE(loop.profile_speed < 0);
}

/* Lag 1/8 turn = 8192 in Q16: 8192·26354 / 2^7 = 1686656. */
TEST(test_speed_reference_leads_by_the_lag_up_to_half_a_turn_times_the_gain)
{
    const step_t most = (step_t)((32767LL * 26354LL) >> 7U);
    const int64_t before_wrap = wrapped(INT64_MIN, -TURN_Q32 / 8);
    const struct {
        const char *name;
        int64_t target;
        int64_t measured;
        step_t speed;
    } cases[] = {
        {"behind", 0, -TURN_Q32 / 8, 1686656},
        {"ahead", 0, TURN_Q32 / 8, -1686656},
        {"behind across the wrap", INT64_MIN, before_wrap, 1686656},
        {"ahead across the wrap", before_wrap, INT64_MIN, -1686656},
        {"half a turn behind", 0, -TURN_Q32 / 2, most},
        {"far behind", 0, -FAR_AWAY_Q32, most},
        {"half a turn ahead", 0, TURN_Q32 / 2, -6746624},
        {"far ahead", 0, FAR_AWAY_Q32, -6746624},
    };

    for (uint32_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        position_loop_reset(&loop, cases[i].target, 0);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(cases[i].speed, lead(cases[i].target, cases[i].measured),
                                        cases[i].name);
    }
}

/*
 * Gain 1. The lag is rounded down to 2^-16 turn; half a turn forwards is one LSB short of it, as
 * Q15 has no +1.
 */
TEST(test_lag_is_rounded_down_up_to_where_it_saturates)
{
    static const int64_t lags_q32[] = {
        32766LL * 65536,  (32767LL * 65536) - 1,  32767LL * 65536,  32768LL * 65536,
        -32767LL * 65536, (-32767LL * 65536) - 1, -32768LL * 65536, (-32768LL * 65536) - 1};
    static const int32_t lags[] = {32766, 32766, 32767, 32767, -32767, -32768, -32768, -32768};

    cfg.gain = 16384;
    cfg.gain_shift = 14U;
    for (uint32_t i = 0U; i < 8U; i++) {
        position_loop_reset(&loop, 0, 0);
        TEST_ASSERT_EQUAL_INT32(lags[i], lead(0, -lags_q32[i]));
    }
}

TEST(test_lag_adds_at_most_the_profile_speed_limit_to_the_profile)
{
    step_t speed;

    cfg.gain = 32767;
    cfg.gain_shift = 0U;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        position_loop_reset(&loop, 0, sign * 1000);
        speed = lead(0, -sign * TURN_Q32);
        TEST_ASSERT_EQUAL_INT32(sign * cfg.speed_max, speed - loop.profile_speed);
    }
    cfg.speed_max = 0x20000000;
    cfg.ramp = 0x20000000;
    position_loop_reset(&loop, 0, 0);
    speed = lead(FAR_AWAY_Q32, -FAR_AWAY_Q32);
    TEST_ASSERT_EQUAL_INT32(0x20000000, speed - loop.profile_speed);
}

/*
 * Without softness the braking curve ends vertically and the profile leaves it where a period costs
 * more than one ramp: it passes the target by less than the way of two ramps in a period.
 */
TEST(test_profile_without_softness_keeps_its_limits_and_passes_the_target_by_two_ramps_at_most)
{
    seeded_t seed = {0x50F7U};
    const int64_t allowed = 2 * (int64_t)cfg.ramp * (int64_t)ticks;

    cfg.softness_q15 = 0;
    for (int32_t run = 0; run < 200; run++) {
        const int64_t scale = (int64_t)1 << seeded_in(&seed, 8, 22);

        run_to_within(loop.profile_q32 + (seeded_in(&seed, -41000, 41000) * scale), allowed);
    }
}

/* i_q* of two periods from a zero integral: K_p·e + K_i·e, then K_p·e + 2·K_i·e. */
static void demand_twice(int32_t demands[2])
{
    speed_loop_reset(&speed_loop, 0);
    for (uint32_t k = 0U; k < 2U; k++) {
        demands[k] = demand(0, -1500000);
    }
}

/* Each part is rounded down. To lower it again changes nothing. */
TEST(test_the_bandwidth_is_halved_once_by_half_of_kp_and_a_quarter_of_ki_and_given_back_whole)
{
    int32_t whole[2];
    int32_t half[2];
    int32_t again[2];

    torque = (torque_range_t){-16384, 16384};
    demand_twice(whole);
    speed_loop_lower(&speed_loop);
    speed_loop_lower(&speed_loop);
    demand_twice(half);
    speed_loop_restore(&speed_loop);
    demand_twice(again);
    for (uint32_t k = 0U; k < 2U; k++) {
        const double ki = whole[1] - whole[0];
        const double kp = whole[0] - ki;

        TEST_ASSERT_DOUBLE_WITHIN(3.0, (kp / 2.0) + ((k + 1U) * ki / 4.0), half[k]);
        TEST_ASSERT_EQUAL_INT32(whole[k], again[k]);
    }
    TEST_ASSERT_TRUE(whole[1] - whole[0] > 40); /* ten times the roundings */
}

TEST(test_a_start_keeps_what_was_learned_and_half_the_bandwidth)
{
    speed_loop.inertia_q17 = 200000;
    speed_loop_lower(&speed_loop);
    speed_loop_reset(&speed_loop, 1000);
    speed_loop_start(&speed_loop, 1000, 100);
    TEST_ASSERT_EQUAL_UINT32(1U, speed_loop.halvings);
    speed_loop_restore(&speed_loop);
    TEST_ASSERT_EQUAL_INT32(200000, speed_loop.inertia_q17);
}

/* The finest gains: the shift of K_i ends, and what is left of it is less than one LSB. */
TEST(test_half_the_bandwidth_holds_for_the_finest_gains)
{
    torque = (torque_range_t){-16384, 16384};
    speed_cfg.pi.kp_shift = 30U;
    speed_cfg.pi.ki_shift = 30U;
    speed_loop_lower(&speed_loop);
    for (uint32_t k = 0U; k < 100U; k++) {
        TEST_ASSERT_INT32_WITHIN(1, 0, demand(0, -0x20000000));
    }
}

/* ---- J ---- */

/*
 * The ramp's torque is 0.0154835·143166 = 2216.7 LSB: 2^17/(2216.7·2^11) = 0.0288719, times 2^20.
 */
static void allow_learning(void)
{
    speed_cfg.inertia_rate = 30274;
    speed_cfg.inertia_rate_shift = 4U;
    speed_cfg.inertia_least_q13 = 4096;
    speed_cfg.inertia_most_q13 = 24576;
}

#define BEFORE_Q26 (100 * 2048)
#define TENTH_Q26 (222 * 2048) /* a tenth of the ramp's torque */

/* What the integral has taken over: as if a step had added it. */
static void learn(step_t change, int32_t added_q26)
{
    speed_loop.pi.integral_q26 = BEFORE_Q26 + added_q26;
    speed_loop_learn(&speed_loop, &speed_cfg, change, BEFORE_Q26);
}

static void assert_not_learned(step_t change, int32_t added_q26)
{
    const int32_t inertia = speed_loop.inertia_q17;

    learn(change, added_q26);
    TEST_ASSERT_EQUAL_INT32(inertia, speed_loop.inertia_q17);
    TEST_ASSERT_EQUAL_INT32(BEFORE_Q26 + added_q26, speed_loop.pi.integral_q26);
}

/* A tenth of the torque is a tenth of J. Mantissa of 15 bits, one rounding down. */
#define LEARNED_Q17 (2)

TEST(test_what_the_integral_takes_over_on_a_ramp_goes_to_the_inertia)
{
    allow_learning();
    learn(speed_cfg.ramp, TENTH_Q26);
    TEST_ASSERT_INT32_WITHIN(LEARNED_Q17, RATIO_ONE_Q17 + (int32_t)(RATIO_ONE_Q17 * 222.0 / 2216.7),
                             speed_loop.inertia_q17);
    TEST_ASSERT_EQUAL_INT32(BEFORE_Q26, speed_loop.pi.integral_q26);
    learn(-speed_cfg.ramp, TENTH_Q26); /* less braking: lighter */
    TEST_ASSERT_INT32_WITHIN(2 * LEARNED_Q17, RATIO_ONE_Q17, speed_loop.inertia_q17);
}

TEST(test_below_half_of_the_ramp_the_integral_keeps_it)
{
    allow_learning();
    assert_not_learned((speed_cfg.ramp / 2) - 1, TENTH_Q26);
    learn(speed_cfg.ramp / 2, TENTH_Q26);
    TEST_ASSERT_TRUE(speed_loop.inertia_q17 > RATIO_ONE_Q17);
}

/* Each limit belongs to the range, and the next LSB does not. */
TEST(test_beyond_the_limits_of_the_inertia_the_integral_keeps_it)
{
    allow_learning();
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t limit = (sign > 0) ? (3 * RATIO_ONE_Q17) : (RATIO_ONE_Q17 / 2);
        int32_t last;

        speed_loop.inertia_q17 = RATIO_ONE_Q17;
        learn(speed_cfg.ramp, sign * TENTH_Q26);
        last = limit - (speed_loop.inertia_q17 - RATIO_ONE_Q17);
        speed_loop.inertia_q17 = last;
        learn(speed_cfg.ramp, sign * TENTH_Q26);
        TEST_ASSERT_EQUAL_INT32(limit, speed_loop.inertia_q17);
        speed_loop.inertia_q17 = last + sign;
        assert_not_learned(speed_cfg.ramp, sign * TENTH_Q26);
        speed_loop.inertia_q17 = limit;
        assert_not_learned(speed_cfg.ramp, sign * TENTH_Q26);
    }
}

/* 10 of Q26 are 10·30274/2^20 = 0.3 of J's LSB. */
TEST(test_what_is_less_than_an_lsb_of_the_inertia_stays_with_the_integral)
{
    allow_learning();
    assert_not_learned(speed_cfg.ramp, 10);
}

/*
 * The smallest rate: 2^16 of Q26 are one of J's LSB. The smallest ramp: a change of one step is all
 * of it.
 */
TEST(test_the_smallest_rate_and_the_smallest_ramp_learn_too)
{
    allow_learning();
    speed_cfg.inertia_rate = 1;
    speed_cfg.inertia_rate_shift = 0U;
    speed_cfg.ramp = 1;
    learn(-1, 5 * 65536);
    TEST_ASSERT_EQUAL_INT32(RATIO_ONE_Q17 - 5, speed_loop.inertia_q17);
    learn(0, 5 * 65536);
    TEST_ASSERT_EQUAL_INT32(RATIO_ONE_Q17, speed_loop.inertia_q17);
}

TEST(test_without_limits_to_move_in_or_a_rate_nothing_is_learned)
{
    allow_learning();
    speed_cfg.inertia_rate = 0;
    assert_not_learned(speed_cfg.ramp, TENTH_Q26);
    allow_learning();
    speed_cfg.inertia_least_q13 = 8192;
    speed_cfg.inertia_most_q13 = 8192;
    assert_not_learned(speed_cfg.ramp, TENTH_Q26);
    assert_not_learned(speed_cfg.ramp, -TENTH_Q26);
}

TEST(test_from_one_and_a_half_of_the_inertia_on_half_of_the_integral_gain_acts)
{
    const int32_t heavy = RATIO_ONE_Q17 / 2 * 3;
    int32_t integral[2];

    for (int32_t k = 0; k < 2; k++) {
        speed_loop_reset(&speed_loop, 0);
        speed_loop.inertia_q17 = heavy - 1 + k;
        (void)demand(0, -400000);
        integral[k] = speed_loop.pi.integral_q26;
    }
    TEST_ASSERT_TRUE(integral[0] > 2048);
    TEST_ASSERT_INT32_WITHIN(1, integral[0] / 2, integral[1]);
}

/*
 * A rotor of `ratio` times the file's J on a ramp and behind it. Returns how far it overshoots,
 * steps.
 */
static step_t overshoot_behind_a_ramp(double ratio)
{
    const step_t target = 100 * speed_cfg.ramp;
    const double steps_per_lsb = speed_cfg.ramp / 2216.7 / ratio;
    double speed = 0.0;
    double highest = 0.0;

    speed_loop_reset(&speed_loop, 0);
    for (int32_t k = 0; k < 300; k++) {
        const step_t before = speed_loop.reference;
        const int32_t integral = speed_loop.pi.integral_q26;
        const step_t next = speed_loop_ramp(&speed_loop, &speed_cfg, target);

        speed += demand(next, (step_t)lround(speed)) * steps_per_lsb;
        speed_loop_learn(&speed_loop, &speed_cfg, speed_loop.reference - before, integral);
        highest = fmax(highest, speed);
    }
    return (step_t)lround(highest) - target;
}

/*
 * The speed of a period is measured before its torque acts. So without an error the rotor is a
 * period ahead on a ramp: one change of 100. More than 3 without a J that is learned.
 */
TEST(test_a_wrong_inertia_no_longer_overshoots_behind_a_ramp_once_it_is_learned)
{
    static const double ratios[] = {0.6, 2.5};

    for (uint32_t k = 0U; k < 2U; k++) {
        speed_loop_init(&speed_loop);
        allow_learning();
        (void)overshoot_behind_a_ramp(ratios[k]);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * ratios[k], ratios[k],
                                  speed_loop.inertia_q17 / (double)RATIO_ONE_Q17);
        TEST_ASSERT_INT32_WITHIN(speed_cfg.ramp / 10, speed_cfg.ramp,
                                 overshoot_behind_a_ramp(ratios[k]));
    }
    speed_loop_init(&speed_loop);
    speed_cfg.inertia_least_q13 = 8192;
    speed_cfg.inertia_most_q13 = 8192;
    (void)overshoot_behind_a_ramp(2.5);
    TEST_ASSERT_TRUE(overshoot_behind_a_ramp(2.5) > (3 * speed_cfg.ramp));
}

TEST(test_a_learned_inertia_stays_within_the_limits_of_another_configuration)
{
    speed_loop.inertia_q17 = 200000;
    speed_cfg.inertia_least_q13 = 4096;
    speed_cfg.inertia_most_q13 = 12500;
    speed_loop_change(&speed_loop, &speed_cfg);
    TEST_ASSERT_EQUAL_INT32(200000, speed_loop.inertia_q17); /* the most is as much */
    speed_cfg.inertia_most_q13 = 12000;
    speed_loop_change(&speed_loop, &speed_cfg);
    TEST_ASSERT_EQUAL_INT32(12000 * 16, speed_loop.inertia_q17);
    speed_loop.inertia_q17 = 40000;
    speed_loop_change(&speed_loop, &speed_cfg);
    TEST_ASSERT_EQUAL_INT32(4096 * 16, speed_loop.inertia_q17);
}

/* ---- within a window of speeds ---- */

#define LSB (4096)     /* steps of speed that are one LSB of the error */
#define LSB_Q26 (2048) /* one LSB of current in the integral */

static speed_window_t window;
static torque_range_t uneven;

/*
 * Both ends at `wide` LSB of the error. K_p = 1 and K_i·T = 1: i = error + I, and I grows by the
 * error. A change of the reference by 4 steps takes 1 LSB of current. The integral follows the load
 * by a quarter.
 */
static void open_window(int32_t wide)
{
    speed_cfg = (speed_loop_cfg_t){
        .pi = {.kp = 16384, .ki = 4096, .kp_shift = 14U, .ki_shift = 1U},
        .ramp = 1000,
        .speed_max = 0x20000000,
        .inertia = 16384,
        .inertia_least_q13 = 8192,
        .inertia_most_q13 = 8192,
        .error_shift = 12U,
    };
    window = (speed_window_t){.lower = -wide * LSB, .upper = wide * LSB, .load_shift = 2U};
    uneven = (torque_range_t){-3000, 2500};
}

/* Takes that integral and speed, in LSB of the current and of the error. */
static void expect_within(int32_t integral, int32_t speed, int32_t wanted, int32_t current,
                          speed_end_t decides)
{
    speed_end_t end = (decides == SPEED_END_NONE) ? SPEED_END_UPPER : SPEED_END_NONE;

    speed_loop.pi.integral_q26 = integral * LSB_Q26;
    TEST_ASSERT_EQUAL_INT32(current, speed_loop_within(&speed_loop, &speed_cfg, &window,
                                                       speed_loop.reference, speed * LSB, wanted,
                                                       uneven, &end));
    TEST_ASSERT_EQUAL_INT(decides, end);
}

/* Error 1000 − 400 = 600, I = 100: up to 700 is free. Beyond, I grows by 600: 600 + 700 = 1300. */
TEST(test_each_end_decides_beyond_its_sum_and_not_at_it)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const speed_end_t end = (sign > 0) ? SPEED_END_UPPER : SPEED_END_LOWER;

        open_window(1000);
        expect_within(sign * 100, sign * 400, sign * 700, sign * 700, SPEED_END_NONE);
        expect_within(sign * 100, sign * 400, sign * 701, sign * 701, end);
        expect_within(sign * 100, sign * 400, sign * 2000, sign * 1300, end);
        TEST_ASSERT_EQUAL_INT32(sign * 700 * LSB_Q26, speed_loop.pi.integral_q26);
    }
}

/*
 * No end has to hold back what the range cuts off anyway: the ends allow ±4000, the range
 * −3000…2500.
 */
TEST(test_what_is_beyond_the_range_is_cut_before_an_end_decides)
{
    open_window(4000);
    expect_within(0, 0, 5000, 2500, SPEED_END_NONE);
    expect_within(0, 0, -5000, -3000, SPEED_END_NONE);
}

/* Ends at ±3000 LSB, the largest speed at 1000: from there on K_p·1000 and as much of I. */
TEST(test_the_ends_of_a_window_are_within_the_largest_speed)
{
    open_window(3000);
    speed_cfg.speed_max = 1000 * LSB;
    expect_within(0, 0, 2400, 2000, SPEED_END_UPPER);
    expect_within(0, 0, -2400, -2000, SPEED_END_LOWER);
}

/*
 * A change of 400 takes 100 of 500: the load is 400, and a quarter of it is 100; then 300 of 100
 * are missing: 175.
 */
TEST(test_between_the_ends_the_integral_follows_the_current_less_the_inertia)
{
    speed_end_t end = SPEED_END_UPPER;

    open_window(1000);
    for (int32_t k = 1; k <= 2; k++) {
        TEST_ASSERT_EQUAL_INT32(500, speed_loop_within(&speed_loop, &speed_cfg, &window, k * 400, 0,
                                                       500, uneven, &end));
        TEST_ASSERT_EQUAL_INT(SPEED_END_NONE, end);
        TEST_ASSERT_EQUAL_INT32(k * 400, speed_loop.reference);
        TEST_ASSERT_EQUAL_INT32(((k == 1) ? 100 : 175) * LSB_Q26, speed_loop.pi.integral_q26);
    }
}

/* Without a current. */
static void expect_integral(step_t wanted, step_t reference, int32_t integral_q26)
{
    speed_end_t end;

    speed_loop.pi.integral_q26 = 0;
    (void)speed_loop_within(&speed_loop, &speed_cfg, &window, wanted, 0, 0, uneven, &end);
    TEST_ASSERT_EQUAL_INT32(reference, speed_loop.reference);
    TEST_ASSERT_EQUAL_INT32(integral_q26, speed_loop.pi.integral_q26);
}

/* Four times the inertia of the largest change: 4·32767 or 4·32768, beyond ±1 of the integral. */
TEST(test_a_load_beyond_the_integral_ends_at_it)
{
    open_window(1000);
    window.load_shift = 0U;
    speed_loop.inertia_q17 = 524288;
    expect_integral(0x20000000, 0x20000000, -67108864);
    expect_integral(-0x20000000, -0x20000000, 67108863);
}

/* And the inertia counts the limited change: 4000 of 4004, 8000 of 8004. */
TEST(test_within_a_window_the_reference_is_limited_to_the_largest_speed)
{
    open_window(1000);
    window.load_shift = 0U;
    speed_cfg.speed_max = 4000;
    expect_integral(4004, 4000, -1000 * LSB_Q26);
    expect_integral(-4004, -4000, 2000 * LSB_Q26);
}

/* Ends so far away that they allow all of ±16384. */
TEST(test_between_the_ends_the_largest_current_has_15_bits)
{
    open_window(20000);
    uneven = (torque_range_t){-16384, 16384};
    expect_within(0, 0, 16384, 16383, SPEED_END_NONE);
    expect_within(0, 0, -16384, -16384, SPEED_END_NONE);
}

/* ---- what a torque makes of the speed ---- */

static step_t response(int32_t current)
{
    return speed_loop_response(&speed_loop, &speed_cfg, current);
}

/*
 * The currents that accelerate() returns are rounded down: a change is found again within what an
 * LSB of current is.
 */
TEST(test_the_response_to_a_torque_is_the_change_that_asks_for_it)
{
    static const int32_t ratios_q17[] = {32768, 131072, 200000, 524288};
    static const struct {
        int32_t inertia;
        uint32_t shift;
        uint32_t lift;
    } scales[] = {{16384, 8U, 0U}, {32767, 3U, 0U}, {20000, 0U, 0U}, {30000, 0U, 5U}};

    torque = (torque_range_t){-16384, 16384};
    for (uint32_t k = 0U; k < 16U; k++) {
        const int32_t ratio_q17 = ratios_q17[k / 4U];
        const int32_t share = ratio_q17 / 32768; /* of J, in quarters */

        set_inertia(scales[k % 4U].inertia, scales[k % 4U].shift, scales[k % 4U].lift);
        speed_loop.inertia_q17 = ratio_q17;
        for (int32_t size = 40; size <= 4000; size *= 10) {
            const double lsb =
                ldexp(65536.0, (int)scales[k % 4U].shift - (int)scales[k % 4U].lift) /
                speed_cfg.inertia / (ratio_q17 / 131072.0);
            const double tolerance = ((2.0 + (size / 1000.0)) * lsb) + 2.0 + share;
            const step_t change = (step_t)lround(size * lsb); /* takes about `size` of current */
            const int32_t current = accelerate(change);

            speed_loop_start(&speed_loop, 0, 500);
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, change, response(500 + current));
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, -change, response(500 - current));
        }
    }
}

TEST(test_the_response_is_exact_and_ends_with_the_largest_current_and_the_largest_change)
{
    static const struct {
        const char *name;
        int32_t inertia;
        uint32_t shift;
        uint32_t lift;
        int32_t load;
        int32_t current;
        step_t response;
    } rows[] = {
        {"what holds the load", 32471, 5U, 0U, -700, -700, 0},
        {"no inertia", 0, 5U, 0U, 0, 16384, 0},
        {"least inertia", 1, 0U, 0U, 0, 3, 3 * 65536},
        {"least inertia backwards", 1, 0U, 0U, 0, -5, -5 * 65536},
        /* 2^17 · 32767/32768, and 2^17 */
        {"beyond 16 bits from the load", 16384, 0U, 0U, -32767, 32767, 131068},
        {"beyond 16 bits backwards", 16384, 0U, 0U, 32767, -32768, -131072},
        {"a step in a coarse scale", 32767, 29U, 14U, 0, 16384, 1 << 30},
        {"a step in a coarse scale backwards", 32767, 29U, 14U, 0, -16384, -(1 << 30)},
        {"a step in the coarsest scale", 32767, 30U, 14U, 0, 16384, 1 << 30},
        {"a step in the coarsest scale backwards", 32767, 30U, 14U, 0, -16384, -(1 << 30)},
    };

    for (uint32_t k = 0U; k < (sizeof rows / sizeof rows[0]); k++) {
        set_inertia(rows[k].inertia, rows[k].shift, rows[k].lift);
        speed_loop_start(&speed_loop, 0, rows[k].load);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(rows[k].response, response(rows[k].current), rows[k].name);
    }
    for (uint32_t shift = 16U; shift <= 30U; shift++) { /* 2^30, whatever the scale */
        speed_loop_start(&speed_loop, 0, 0);
        set_inertia(16384, shift, 0U);
        TEST_ASSERT_EQUAL_INT32(1 << 30, response(32767));
        TEST_ASSERT_EQUAL_INT32(-(1 << 30), response(-32768));
    }
}

/* ---- where positions count from ---- */

TEST(test_a_recount_moves_the_zero_by_whole_turns_to_within_half_a_turn_of_the_position)
{
    seeded_t seed = {0x2E20U};

    for (uint32_t pole_pairs = 1U; pole_pairs <= 50U; pole_pairs++) {
        const int64_t turn_q32 = (int64_t)pole_pairs * TURN_Q32;

        cfg.pole_pairs = pole_pairs;
        for (uint32_t k = 0U; k < 200U; k++) {
            const int64_t whole = (int64_t)seeded_in(&seed, -1000000000, 1000000000) * TURN_Q32;
            const int64_t position_q32 = whole + seeded_in(&seed, 0, INT32_MAX);
            const int64_t zero_q32 = (int64_t)seeded_in(&seed, -1000000000, 1000000000) * 65536;

            loop.zero_q32 = zero_q32;
            position_loop_recount(&loop, &cfg, position_q32);
            TEST_ASSERT_EQUAL_INT64(0, (loop.zero_q32 - zero_q32) % turn_q32);
            TEST_ASSERT_TRUE((2 * (position_q32 - loop.zero_q32)) >= -turn_q32);
            TEST_ASSERT_TRUE((2 * (position_q32 - loop.zero_q32)) < turn_q32);
        }
    }
}

TEST(test_a_recount_ends_at_half_a_turn_and_goes_on_where_the_position_wraps)
{
    static const struct {
        int64_t before_q32;
        int64_t position_q32; /* with 3 pole pairs half a turn is 1.5 electrical ones */
        int64_t zero_q32;
    } cases[] = {
        {0, 0, 0},
        {0, (3 * TURN_Q32 / 2) - 1, 0},
        {0, 3 * TURN_Q32 / 2, 3 * TURN_Q32},
        {0, -3 * TURN_Q32 / 2, 0},
        {0, (-3 * TURN_Q32 / 2) - 1, -3 * TURN_Q32},
        /* the count of the rotor has wrapped in between */
        {INT64_MAX - TURN_Q32, INT64_MIN + (3 * TURN_Q32), INT64_MIN + ((2 * TURN_Q32) - 1)},
    };

    cfg.pole_pairs = 3U;
    for (uint32_t k = 0U; k < (sizeof cases / sizeof cases[0]); k++) {
        loop.zero_q32 = cases[k].before_q32;
        position_loop_recount(&loop, &cfg, cases[k].position_q32);
        TEST_ASSERT_EQUAL_INT64(cases[k].zero_q32, loop.zero_q32);
    }
}

TEST(test_a_target_counts_from_the_zero_and_goes_on_where_the_position_wraps)
{
    static const struct {
        int64_t zero_q32;
        int32_t target_q16;
        int64_t position_q32;
    } rows[] = {
        {7, INT32_MAX, ((int64_t)INT32_MAX * 65536) + 7},
        {7, INT32_MIN, ((int64_t)INT32_MIN * 65536) + 7},
        {INT64_MAX - TURN_Q32, 2 * 65536, INT64_MIN + (TURN_Q32 - 1)},
        {INT64_MAX - TURN_Q32, -65536, INT64_MAX - (2 * TURN_Q32)},
    };

    for (uint32_t k = 0U; k < (sizeof rows / sizeof rows[0]); k++) {
        loop.zero_q32 = rows[k].zero_q32;
        TEST_ASSERT_EQUAL_INT64(rows[k].position_q32,
                                position_loop_target(&loop, rows[k].target_q16));
    }
}

/* All that writes them. */
static void move_profile(void)
{
    position_loop_set_zero(&loop, 12345678901);
    position_loop_reset(&loop, -987654321, 1234);
    position_loop_recount(&loop, &cfg, 55 * TURN_Q32);
    for (uint32_t k = 0U; k < 20U; k++) {
        (void)position_loop_step(&loop, &cfg, 9 * TURN_Q32, 4 * TURN_Q32, 10U);
    }
}

TEST(test_each_flip_of_profile_and_zero_is_seen_and_stays_seen)
{
    uint8_t *const bytes = (uint8_t *)&loop;

    for (uint32_t bit = 0U; bit < (8U * sizeof loop); bit++) {
        loop = (position_loop_t){0};
        TEST_ASSERT_TRUE(position_loop_holds(&loop));
        move_profile();
        TEST_ASSERT_TRUE(position_loop_holds(&loop));
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_FALSE(position_loop_holds(&loop));
        move_profile();
        TEST_ASSERT_FALSE(position_loop_holds(&loop));
    }
}
