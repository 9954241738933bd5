/* SPDX-License-Identifier: MIT */
/* Torque control: the slope, the bridge, the window of speeds, and the lowest speed of RUN. */
#include "torque_loop.h"

#include "example_cfg.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>

#define FLUX (7000)
#define LOWEST (100000)
#define RAMP (1000)
#define FORWARD (20000000)
#define BACKWARD (15000000)
#define SLOPE (100 * FLUX)
#define RANGE_MAX (8192)

static torque_loop_cfg_t cfg;
static torque_loop_t loop;
static torque_loop_in_t in;
static speed_loop_cfg_t speed_cfg;
static speed_loop_t speed_loop;
static const torque_range_t whole = {-RANGE_MAX, RANGE_MAX};

void setUp(void)
{
    cfg = (torque_loop_cfg_t){
        .slope = SLOPE, .speed_forward = FORWARD, .speed_backward = BACKWARD, .load_shift = 4U};
    in = (torque_loop_in_t){.flux_q13 = FLUX,
                            .range = whole,
                            .speed = 1000000,
                            .reference = 1000000,
                            .lowest = LOWEST,
                            .ramp = RAMP};
    torque_loop_start(&loop, FLUX, 0);
    speed_cfg = example_speed_loop_cfg();
    speed_loop_init(&speed_loop);
}

/* ---- the torque reference ---- */

TEST(test_the_torque_begins_with_the_one_that_acts)
{
    torque_loop_start(&loop, FLUX, -1234);
    in.target_q28 = -1234 * FLUX;
    TEST_ASSERT_EQUAL_INT32(in.speed, torque_loop_plan(&loop, &cfg, &in));
    TEST_ASSERT_EQUAL_INT32(-1234, loop.current);
    TEST_ASSERT_FALSE(loop.bound);
}

TEST(test_a_start_knows_of_no_end_of_the_window)
{
    loop.end = (uint8_t)SPEED_END_UPPER;
    torque_loop_start(&loop, FLUX, 0);
    TEST_ASSERT_EQUAL_UINT8(SPEED_END_NONE, loop.end);
}

TEST(test_the_torque_follows_on_its_slope_in_the_fewest_periods)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, 0);
        in.target_q28 = sign * 250 * FLUX;
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * 100, loop.current);
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * 200, loop.current);
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * 250, loop.current);
    }
}

/* Else the way back from a torque that no motor has would take its time. */
TEST(test_a_torque_beyond_the_range_of_the_current_counts_as_its_end)
{
    cfg.slope = 0x20000000;
    in.target_q28 = INT32_MAX;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(RANGE_MAX, loop.current);
    TEST_ASSERT_EQUAL_INT32(RANGE_MAX * FLUX, loop.reference_q28);
    in.target_q28 = INT32_MIN;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(-RANGE_MAX, loop.current);
}

TEST(test_each_end_of_the_range_counts_for_its_sign)
{
    cfg.slope = 0x20000000;
    in.range = (torque_range_t){.lower = -300, .upper = 700};
    in.target_q28 = 1000 * FLUX;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(700, loop.current);
    in.target_q28 = -1000 * FLUX;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(-300, loop.current);
}

/*
 * Derating and a weakened field take the reference along: away from them there is nothing to wait
 * for, and behind them no jump.
 */
TEST(test_a_range_that_narrows_takes_the_reference_along)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, sign * 2000);
        in.target_q28 = sign * 2000 * FLUX;
        in.range = (torque_range_t){.lower = -500, .upper = 500};
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * 500, loop.current);
        in.range = whole;
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * 600, loop.current);
        in.range = (torque_range_t){.lower = -500, .upper = 500};
        in.target_q28 = -in.target_q28;
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * (500 - 100), loop.current);
    }
}

/* The torque is what was asked for: with another flux the current is another one. */
TEST(test_with_another_flux_the_torque_stays)
{
    torque_loop_start(&loop, FLUX, 1000);
    in.target_q28 = 1000 * FLUX;
    in.flux_q13 = FLUX / 2;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(2000, loop.current);
}

/*
 * An end of the window holds the torque at 50, the reference waits at `waiting`, and 2000 is asked
 * for: one slow period of that.
 */
static void plan_at_an_end(int32_t sign, int32_t waiting)
{
    torque_loop_start(&loop, FLUX, sign * waiting);
    loop.end = (sign > 0) ? (uint8_t)SPEED_END_UPPER : (uint8_t)SPEED_END_LOWER;
    in.reference = sign * 1000000;
    in.speed = in.reference;
    in.current = sign * 50;
    in.target_q28 = sign * 2000 * FLUX;
    (void)torque_loop_plan(&loop, &cfg, &in);
}

/* What waits beyond an end of the window is not in the way of a torque that leads away from it. */
TEST(test_away_from_an_end_the_torque_begins_with_the_one_that_acts)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        plan_at_an_end(sign, 3000);
        TEST_ASSERT_EQUAL_INT32(sign * 2000, loop.current);
        in.target_q28 = -sign * 2000 * FLUX;
        (void)torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_EQUAL_INT32(sign * (50 - 100), loop.current);
    }
}

TEST(test_a_start_has_its_current_at_once_and_no_bridge)
{
    torque_loop_bridge(&loop);
    loop.bound = true;
    torque_loop_start(&loop, FLUX, -1234);
    TEST_ASSERT_EQUAL_INT32(-1234, loop.current);
    TEST_ASSERT_EQUAL_INT32(-1234 * FLUX, loop.reference_q28);
    TEST_ASSERT_FALSE(loop.bridging);
    TEST_ASSERT_FALSE(loop.bound);
}

/* A free torque is nothing that a bridge has to lead to. */
TEST(test_a_free_torque_is_not_bridged)
{
    in.target_q28 = 500 * FLUX;
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_FALSE(loop.bound);
    TEST_ASSERT_FALSE(loop.bridging);
}

/*
 * An end of which the reference has less than it allows is in nobody's way: from 1000 on with the
 * slope of 100.
 */
TEST(test_what_waits_short_of_an_end_goes_on_with_its_slope)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        plan_at_an_end(sign, 1000);
        TEST_ASSERT_EQUAL_INT32(sign * 1100, loop.current);
        TEST_ASSERT_EQUAL_INT32(sign * 1100 * FLUX, loop.reference_q28);
    }
}

/* ---- the bridge ---- */

TEST(test_a_bridge_goes_by_the_slope_until_its_loop_is_within)
{
    torque_range_t range;

    torque_loop_bridge(&loop);
    range = torque_loop_bridged(&cfg, FLUX, 1000, whole);
    TEST_ASSERT_EQUAL_INT32(900, range.lower);
    TEST_ASSERT_EQUAL_INT32(1100, range.upper);
    torque_loop_arrive(&loop, 1100, range);
    TEST_ASSERT_TRUE(loop.bridging);
    torque_loop_arrive(&loop, 900, range);
    TEST_ASSERT_TRUE(loop.bridging);
    torque_loop_arrive(&loop, 901, range);
    TEST_ASSERT_FALSE(loop.bridging);
}

/* It keeps to the limits of the current, and it moves however small the slope is. */
TEST(test_a_bridge_stays_within_the_range_and_always_moves)
{
    torque_range_t range = torque_loop_bridged(&cfg, FLUX, RANGE_MAX + 500, whole);

    TEST_ASSERT_EQUAL_INT32(RANGE_MAX - 100, range.lower);
    TEST_ASSERT_EQUAL_INT32(RANGE_MAX, range.upper);
    cfg.slope = 1;
    range = torque_loop_bridged(&cfg, FLUX, -5, whole);
    TEST_ASSERT_EQUAL_INT32(-6, range.lower);
    TEST_ASSERT_EQUAL_INT32(-4, range.upper);
}

TEST(test_a_bridge_from_below_the_range_begins_at_its_lower_end)
{
    const torque_range_t range = torque_loop_bridged(&cfg, FLUX, -RANGE_MAX - 500, whole);

    TEST_ASSERT_EQUAL_INT32(-RANGE_MAX, range.lower);
    TEST_ASSERT_EQUAL_INT32(-RANGE_MAX + 100, range.upper);
}

/* ---- low speed ---- */

TEST(test_a_torque_aims_at_the_end_of_the_window_on_its_side)
{
    TEST_ASSERT_EQUAL_INT32(FORWARD, torque_loop_aim(&cfg, 1));
    TEST_ASSERT_EQUAL_INT32(-BACKWARD, torque_loop_aim(&cfg, -1));
    TEST_ASSERT_EQUAL_INT32(0, torque_loop_aim(&cfg, 0));
}

TEST(test_the_window_ends_at_the_lowest_speed_on_the_side_of_the_motion)
{
    speed_window_t window = torque_loop_window(&cfg, 1000000, LOWEST);

    TEST_ASSERT_EQUAL_INT32(LOWEST, window.lower);
    TEST_ASSERT_EQUAL_INT32(FORWARD, window.upper);
    window = torque_loop_window(&cfg, -1000000, LOWEST);
    TEST_ASSERT_EQUAL_INT32(-BACKWARD, window.lower);
    TEST_ASSERT_EQUAL_INT32(-LOWEST, window.upper);
    window = torque_loop_window(&cfg, -1000000, 0);
    TEST_ASSERT_EQUAL_INT32(-BACKWARD, window.lower);
    TEST_ASSERT_EQUAL_INT32(FORWARD, window.upper);
    TEST_ASSERT_EQUAL_UINT32(4U, window.load_shift);
    cfg.speed_forward = LOWEST / 2;
    cfg.speed_backward = LOWEST / 4;
    window = torque_loop_window(&cfg, 0, LOWEST);
    TEST_ASSERT_EQUAL_INT32(LOWEST / 2, window.lower);
    window = torque_loop_window(&cfg, -1, LOWEST);
    TEST_ASSERT_EQUAL_INT32(-LOWEST / 4, window.upper);
}

/*
 * Caught at the lowest speed: what brakes goes on with the slope of the imposed vector, to the
 * other side.
 */
TEST(test_a_torque_against_the_motion_goes_down_the_slope_from_the_lowest_speed_on)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        step_t reference = 0;

        torque_loop_start(&loop, FLUX, 0);
        loop.end = (sign > 0) ? (uint8_t)SPEED_END_LOWER : (uint8_t)SPEED_END_UPPER;
        in.speed = sign * (LOWEST + 5000);
        in.reference = in.speed;
        in.target_q28 = -sign * 500 * FLUX;
        in.current = sign * 77;
        for (int32_t k = 1; k <= 250; k++) {
            reference = torque_loop_plan(&loop, &cfg, &in);
            TEST_ASSERT_EQUAL_INT32(sign * (LOWEST - (k * RAMP)),
                                    (k < 200) ? reference : sign * (LOWEST - (k * RAMP)));
            if (k < 200) {
                TEST_ASSERT_TRUE(loop.bound);
                TEST_ASSERT_FALSE(loop.bridging);
                TEST_ASSERT_EQUAL_INT32(sign * 77 * FLUX, loop.reference_q28);
                in.speed = reference;
            }
            in.reference = reference;
            if (k == 200) {
                TEST_ASSERT_EQUAL_INT32(-sign * LOWEST, reference);
                TEST_ASSERT_FALSE(loop.bound);
                in.speed = -sign * 300000;
            }
        }
        TEST_ASSERT_EQUAL_INT32(-sign * 300000, reference);
        TEST_ASSERT_EQUAL_INT32(-sign * 500, loop.current);
    }
}

TEST(test_without_a_torque_the_slope_ends_at_standstill)
{
    loop.end = (uint8_t)SPEED_END_LOWER;
    in.speed = LOWEST;
    in.reference = LOWEST;
    for (int32_t k = 0; k < 300; k++) {
        in.reference = torque_loop_plan(&loop, &cfg, &in);
        in.speed = in.reference;
    }
    TEST_ASSERT_EQUAL_INT32(0, in.reference);
    TEST_ASSERT_TRUE(loop.bound);
}

/*
 * A rotor that the end of the window holds just below the lowest speed, either way, and one at that
 * speed that nothing holds.
 */
TEST(test_without_a_torque_the_slope_begins_with_the_speed_of_the_rotor)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, 0);
        loop.end = (sign < 0) ? (uint8_t)SPEED_END_UPPER : (uint8_t)SPEED_END_LOWER;
        in.reference = sign * LOWEST;
        in.speed = sign * (LOWEST - 1);
        TEST_ASSERT_EQUAL_INT32(sign * (LOWEST - 1 - RAMP), torque_loop_plan(&loop, &cfg, &in));
        torque_loop_start(&loop, FLUX, 0);
        in.speed = sign * LOWEST;
        TEST_ASSERT_EQUAL_INT32(in.speed, torque_loop_plan(&loop, &cfg, &in));
    }
}

/* The load is larger than the torque: it goes no further down, and the torque stays free. */
TEST(test_a_torque_with_the_motion_stays_at_the_lowest_speed)
{
    loop.end = (uint8_t)SPEED_END_LOWER;
    in.speed = LOWEST + 10;
    in.reference = LOWEST + 10;
    in.target_q28 = 500 * FLUX;
    TEST_ASSERT_TRUE(torque_loop_plan(&loop, &cfg, &in) >= LOWEST);
    TEST_ASSERT_FALSE(loop.bound);
    TEST_ASSERT_EQUAL_INT32(100, loop.current);
}

/*
 * The estimate swings there, caught by the end of the window or just above it: that binds nothing,
 * and raises no i_d*.
 */
TEST(test_a_torque_with_the_motion_stays_free_while_the_estimate_swings_about_the_lowest_speed)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const speed_end_t caught = (sign > 0) ? SPEED_END_LOWER : SPEED_END_UPPER;

        for (step_t swing = -LOWEST / 8; swing <= 0; swing += LOWEST / 100) {
            for (uint32_t k = 0U; k < 2U; k++) {
                torque_loop_start(&loop, FLUX, 0);
                loop.end = (uint8_t)((k == 0U) ? caught : SPEED_END_NONE);
                in.speed = sign * (LOWEST + swing);
                in.reference = sign * LOWEST;
                in.target_q28 = sign * 500 * FLUX;
                TEST_ASSERT_EQUAL_INT32(sign * LOWEST, torque_loop_plan(&loop, &cfg, &in));
                TEST_ASSERT_FALSE(loop.bound);
            }
        }
    }
}

/* The end of the window has it, and the rotor is slower all the same, by more than a swing. */
TEST(test_a_rotor_that_the_end_of_the_window_does_not_hold_is_led_up_the_slope)
{
    loop.end = (uint8_t)SPEED_END_LOWER;
    in.speed = LOWEST - (LOWEST / 8) - 1;
    in.reference = LOWEST;
    in.target_q28 = 500 * FLUX;
    TEST_ASSERT_EQUAL_INT32(in.speed + RAMP, torque_loop_plan(&loop, &cfg, &in));
    TEST_ASSERT_TRUE(loop.bound);
}

/*
 * Nothing has caught the rotor in time: the speed loop goes on from the torque that acts, on a
 * slope.
 */
TEST(test_a_rotor_that_is_suddenly_too_slow_is_bridged)
{
    in.speed = LOWEST / 2;
    in.target_q28 = 500 * FLUX;
    in.current = 300;
    TEST_ASSERT_EQUAL_INT32((LOWEST / 2) + RAMP, torque_loop_plan(&loop, &cfg, &in));
    TEST_ASSERT_TRUE(loop.bound);
    TEST_ASSERT_TRUE(loop.bridging);
    TEST_ASSERT_EQUAL_INT32(300, loop.current);
    setUp();
    in.speed = -3;
    in.target_q28 = -1;
    TEST_ASSERT_EQUAL_INT32(-RAMP, torque_loop_plan(&loop, &cfg, &in));
}

/* With a sensor, or where nothing is imposed. */
TEST(test_without_a_lowest_speed_the_torque_is_free_at_any_speed)
{
    static const step_t speeds[] = {-BACKWARD, -1, 0, 1, FORWARD};

    in.lowest = 0;
    loop.end = (uint8_t)SPEED_END_LOWER;
    for (uint32_t k = 0U; k < 5U; k++) {
        in.speed = speeds[k];
        in.reference = speeds[k];
        TEST_ASSERT_EQUAL_INT32(speeds[k], torque_loop_plan(&loop, &cfg, &in));
        TEST_ASSERT_FALSE(loop.bound);
    }
    in.speed = FORWARD + 1;
    TEST_ASSERT_EQUAL_INT32(FORWARD, torque_loop_plan(&loop, &cfg, &in));
    in.speed = -BACKWARD - 1;
    TEST_ASSERT_EQUAL_INT32(-BACKWARD, torque_loop_plan(&loop, &cfg, &in));
}

/* A window that ends below the lowest speed of RUN is a speed for the imposed vector. */
TEST(test_a_window_below_the_lowest_speed_binds)
{
    cfg.speed_forward = LOWEST / 2;
    in.speed = LOWEST;
    in.reference = LOWEST;
    in.target_q28 = 500 * FLUX;
    for (uint32_t k = 0U; k < 2U; k++) {
        torque_loop_start(&loop, FLUX, 0);
        loop.end = (uint8_t)((k == 0U) ? SPEED_END_NONE : SPEED_END_LOWER);
        TEST_ASSERT_EQUAL_INT32(LOWEST / 2, torque_loop_plan(&loop, &cfg, &in));
        TEST_ASSERT_TRUE(loop.bound);
    }
}

/* A reference of 0 counts as forwards, one of −1 as backwards. */
TEST(test_a_rotor_on_the_side_of_its_reference_is_free_from_the_lowest_speed_on)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, 0);
        in.reference = (sign > 0) ? 0 : -1;
        in.speed = sign * (LOWEST + 5);
        in.target_q28 = sign * 500 * FLUX;
        TEST_ASSERT_EQUAL_INT32(in.speed, torque_loop_plan(&loop, &cfg, &in));
        TEST_ASSERT_FALSE(loop.bound);
    }
}

/* What decided i_q* before says nothing about the speed loop's own torque. */
TEST(test_where_the_speed_loop_has_the_torque_no_end_of_the_window_has_it)
{
    loop.end = (uint8_t)SPEED_END_LOWER;
    in.speed = LOWEST;
    in.reference = LOWEST;
    in.target_q28 = -500 * FLUX;
    TEST_ASSERT_EQUAL_INT32(LOWEST - RAMP, torque_loop_plan(&loop, &cfg, &in));
    TEST_ASSERT_TRUE(loop.bound);
    TEST_ASSERT_EQUAL_UINT8(SPEED_END_NONE, loop.end);
}

TEST(test_whatever_comes_stays_within_what_is_stated)
{
    seeded_t seed = {0x70E9EU};

    for (uint32_t k = 0U; k < 200000U; k++) {
        step_t reference;

        cfg = (torque_loop_cfg_t){.slope = seeded_in(&seed, 1, 0x20000000),
                                  .speed_forward = seeded_in(&seed, 0, 0x20000000),
                                  .speed_backward = seeded_in(&seed, 0, 0x20000000)};
        in = (torque_loop_in_t){.target_q28 = seeded_i32(&seed),
                                .flux_q13 = seeded_in(&seed, 1, 32767),
                                .current = seeded_in(&seed, -16384, 16384),
                                .range = {seeded_in(&seed, -16384, 0), seeded_in(&seed, 0, 16384)},
                                .speed = seeded_in(&seed, -0x20000000, 0x20000000),
                                .reference = seeded_in(&seed, -0x20000000, 0x20000000),
                                .lowest = seeded_in(&seed, 0, 0x20000000),
                                .ramp = seeded_in(&seed, 1, 0x20000000)};
        loop.end = (uint8_t)seeded_in(&seed, 0, 2);
        loop.bound = seeded_in(&seed, 0, 1) != 0;
        reference = torque_loop_plan(&loop, &cfg, &in);
        TEST_ASSERT_TRUE(abs(reference) <= 0x40000000);
        TEST_ASSERT_TRUE(abs(loop.reference_q28) <= CURRENT_REFERENCE_TORQUE_MAX);
        if (!loop.bound) {
            TEST_ASSERT_TRUE(loop.current >= in.range.lower);
            TEST_ASSERT_TRUE(loop.current <= in.range.upper);
        }
    }
}

/* ---- the ends of the window ---- */

static int32_t within(step_t speed, int32_t wanted, speed_end_t *end)
{
    const speed_window_t window = torque_loop_window(&cfg, speed, 0);

    return speed_loop_within(&speed_loop, &speed_cfg, &window, speed, speed, wanted, whole, end);
}

TEST(test_between_the_ends_the_current_is_what_was_wanted)
{
    speed_end_t end;

    TEST_ASSERT_EQUAL_INT32(3000, within(0, 3000, &end));
    TEST_ASSERT_EQUAL_INT(SPEED_END_NONE, end);
    TEST_ASSERT_EQUAL_INT32(RANGE_MAX, within(0, 16384, &end));
    TEST_ASSERT_EQUAL_INT32(-RANGE_MAX, within(0, -16384, &end));
    TEST_ASSERT_EQUAL_INT32(0, speed_loop.reference);
}

/*
 * A rotor J·dω/dt = i − load (in LSB of current and steps of speed) under a torque that it cannot
 * keep: it comes to rest at the end of the window, and from one period to the next the current
 * changes no more than the PI about that end can.
 */
static void land(int32_t wanted, int32_t load, step_t end_of_window, speed_end_t expected)
{
    const double acceleration = 30.0; /* steps a slow period for an LSB */
    const double kp = ldexp(speed_cfg.pi.kp, -(int)speed_cfg.pi.kp_shift);
    const double ki = ldexp(speed_cfg.pi.ki, -(int)speed_cfg.pi.ki_shift - 11);
    double speed = 0.0;
    const double excess = abs(wanted - load);
    /* of a change of the speed by K_p, and of what K_p makes of the error by K_i; and roundings */
    const double most = (kp * excess * acceleration / 4096.0) + (2.0 * excess * ki / kp) + 40.0;
    int32_t before = wanted;
    step_t furthest = 0;
    speed_end_t end = SPEED_END_NONE;

    speed_loop_reset(&speed_loop, 0);
    speed_cfg.inertia = (int32_t)lround(65536.0 / acceleration);
    speed_cfg.inertia_shift = 0U;
    speed_cfg.inertia_lift = 0U;
    for (uint32_t k = 0U; k < 3000U; k++) {
        const int32_t current = within((step_t)lround(speed), wanted, &end);

        speed += acceleration * (current - load);
        TEST_ASSERT_TRUE((k == 0U) || (abs(current - before) <= most));
        before = current;
        furthest = (abs((int32_t)lround(speed)) > abs(furthest)) ? (step_t)lround(speed) : furthest;
    }
    TEST_ASSERT_EQUAL_INT(expected, end);
    TEST_ASSERT_INT32_WITHIN(abs(end_of_window) / 1000, end_of_window, (step_t)lround(speed));
    TEST_ASSERT_INT32_WITHIN(20, load, before);
    /* 5 % beyond at most */
    TEST_ASSERT_TRUE((20 * abs(furthest)) <= (21 * abs(end_of_window)));
}

TEST(test_an_end_of_the_window_takes_the_torque_over_without_a_jump)
{
    land(3000, 0, FORWARD, SPEED_END_UPPER);
    land(3000, 2000, FORWARD, SPEED_END_UPPER);
    land(-3000, 0, -BACKWARD, SPEED_END_LOWER);
    land(-3000, 500, -BACKWARD, SPEED_END_LOWER);
    land(100, -2000, FORWARD, SPEED_END_UPPER);
    land(0, 2000, -BACKWARD, SPEED_END_LOWER);
}

/*
 * Whatever torque is wanted, and it does not wind up meanwhile: what lowers the torque again acts
 * at once.
 */
TEST(test_back_from_an_end_the_torque_acts_at_once)
{
    speed_end_t end;

    land(3000, 0, FORWARD, SPEED_END_UPPER);
    TEST_ASSERT_EQUAL_INT32(-2000, within(FORWARD, -2000, &end));
    TEST_ASSERT_EQUAL_INT(SPEED_END_NONE, end);
}

/* The integral is the load, whatever the torque: so a change to speed control begins with it. */
TEST(test_between_the_ends_the_integral_finds_the_load)
{
    const double acceleration = 30.0;
    double speed = -500000.0;
    speed_end_t end = SPEED_END_NONE;

    speed_cfg.inertia = (int32_t)lround(65536.0 / acceleration);
    speed_cfg.inertia_shift = 0U;
    speed_cfg.inertia_lift = 0U;
    speed_loop_reset(&speed_loop, (step_t)speed);
    for (uint32_t k = 0U; k < 200U; k++) {
        const int32_t current = within((step_t)lround(speed), 1500, &end);

        speed += acceleration * (current - 1300);
    }
    TEST_ASSERT_EQUAL_INT(SPEED_END_NONE, end);
    TEST_ASSERT_INT32_WITHIN(20, 1300, pi_output(&speed_loop.pi));
}

/* A window of no width is a speed. */
TEST(test_in_a_window_of_no_width_the_speed_loop_has_the_torque)
{
    speed_end_t end;

    cfg.speed_forward = 0;
    cfg.speed_backward = 0;
    TEST_ASSERT_TRUE(within(-100000, -3000, &end) > 0);
    TEST_ASSERT_EQUAL_INT(SPEED_END_LOWER, end);
    TEST_ASSERT_TRUE(within(100000, 3000, &end) < 0);
    TEST_ASSERT_EQUAL_INT(SPEED_END_UPPER, end);
}

TEST(test_the_window_is_no_wider_than_the_speed_loop)
{
    speed_end_t end;

    cfg.speed_forward = 0x20000000;
    cfg.speed_backward = 0x20000000;
    TEST_ASSERT_TRUE(within(speed_cfg.speed_max + 1000000, 3000, &end) < 3000);
    TEST_ASSERT_EQUAL_INT(SPEED_END_UPPER, end);
    TEST_ASSERT_EQUAL_INT32(speed_cfg.speed_max, speed_loop.reference);
    speed_loop_reset(&speed_loop, 0);
    TEST_ASSERT_TRUE(within(-speed_cfg.speed_max - 1000000, -3000, &end) > -3000);
    TEST_ASSERT_EQUAL_INT(SPEED_END_LOWER, end);
}
