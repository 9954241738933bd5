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
#define ACCELERATION (30.0) /* of the rotor, steps a slow period for an LSB of current */

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

/* The end of the window at the lowest speed for a motion in that direction. */
static speed_end_t low_end(int32_t sign)
{
    return (sign > 0) ? SPEED_END_LOWER : SPEED_END_UPPER;
}

/* A free torque of 0, the end that decided last, and the speeds of rotor and reference. */
static void begin(speed_end_t end, step_t speed, step_t reference)
{
    torque_loop_start(&loop, FLUX, 0);
    loop.end = (uint8_t)end;
    in.speed = speed;
    in.reference = reference;
}

/* The speed reference of a slow period with a torque of so many LSB of current. */
static step_t plan(int32_t target)
{
    in.target_q28 = target * FLUX;
    return torque_loop_plan(&loop, &cfg, &in);
}

static void expect_planned(int32_t current)
{
    (void)torque_loop_plan(&loop, &cfg, &in);
    TEST_ASSERT_EQUAL_INT32(current, loop.current);
    TEST_ASSERT_EQUAL_INT32(current * in.flux_q13, loop.reference_q28);
}

static void expect_current(int32_t target, int32_t current)
{
    in.target_q28 = target * FLUX;
    expect_planned(current);
}

/* ---- the torque reference ---- */

TEST(test_a_start_is_free_at_its_current_and_knows_of_no_bridge_and_no_end)
{
    torque_loop_bridge(&loop);
    loop.bound = true;
    loop.end = (uint8_t)SPEED_END_UPPER;
    torque_loop_start(&loop, FLUX, -1234);
    TEST_ASSERT_EQUAL_INT32(-1234, loop.current);
    TEST_ASSERT_EQUAL_INT32(-1234 * FLUX, loop.reference_q28);
    TEST_ASSERT_FALSE(loop.bridging);
    TEST_ASSERT_FALSE(loop.bound);
    TEST_ASSERT_EQUAL_UINT8(SPEED_END_NONE, loop.end);
}

/* A free torque is nothing that a bridge has to lead to. */
TEST(test_the_torque_begins_with_the_one_that_acts_and_is_not_bridged)
{
    torque_loop_start(&loop, FLUX, -1234);
    TEST_ASSERT_EQUAL_INT32(in.speed, plan(-1234));
    TEST_ASSERT_EQUAL_INT32(-1234, loop.current);
    TEST_ASSERT_FALSE(loop.bound);
    TEST_ASSERT_FALSE(loop.bridging);
}

TEST(test_the_torque_follows_on_its_slope_in_the_fewest_periods)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, 0);
        expect_current(sign * 250, sign * 100);
        expect_current(sign * 250, sign * 200);
        expect_current(sign * 250, sign * 250);
    }
}

/* Else the way back from a torque that no motor has would take its time. */
TEST(test_a_torque_beyond_the_range_of_the_current_counts_as_its_end)
{
    cfg.slope = 0x20000000;
    in.target_q28 = INT32_MAX;
    expect_planned(RANGE_MAX);
    in.target_q28 = INT32_MIN;
    expect_planned(-RANGE_MAX);
}

TEST(test_each_end_of_the_range_counts_for_its_sign)
{
    cfg.slope = 0x20000000;
    in.range = (torque_range_t){.lower = -300, .upper = 700};
    expect_current(1000, 700);
    expect_current(-1000, -300);
}

/*
 * Derating and a weakened field take the reference along: away from them there is nothing to wait
 * for, and behind them no jump.
 */
TEST(test_a_range_that_narrows_takes_the_reference_along)
{
    static const torque_range_t narrow = {.lower = -500, .upper = 500};

    for (int32_t sign = -1; sign <= 1; sign += 2) {
        torque_loop_start(&loop, FLUX, sign * 2000);
        in.range = narrow;
        expect_current(sign * 2000, sign * 500);
        in.range = whole;
        expect_current(sign * 2000, sign * 600);
        in.range = narrow;
        expect_current(-sign * 2000, sign * (500 - 100));
    }
}

/* The torque is what was asked for: with another flux the current is another one. */
TEST(test_with_another_flux_the_torque_stays)
{
    torque_loop_start(&loop, FLUX, 1000);
    in.flux_q13 = FLUX / 2;
    expect_current(1000, 2000);
}

/* An end of the window holds the torque at 50, and the reference waits at `waiting`. */
static void wait_at_an_end(int32_t sign, int32_t waiting)
{
    torque_loop_start(&loop, FLUX, sign * waiting);
    loop.end = (uint8_t)low_end(-sign);
    in.speed = sign * 1000000;
    in.reference = in.speed;
    in.current = sign * 50;
}

/* What waits beyond an end of the window is not in the way of a torque that leads away from it. */
TEST(test_away_from_an_end_the_torque_begins_with_the_one_that_acts)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        wait_at_an_end(sign, 3000);
        expect_current(sign * 2000, sign * 2000);
        expect_current(-sign * 2000, sign * (50 - 100));
    }
}

/* An end of which the reference has less than it allows is in nobody's way. */
TEST(test_what_waits_short_of_an_end_goes_on_with_its_slope)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        wait_at_an_end(sign, 1000);
        expect_current(sign * 2000, sign * (1000 + 100));
    }
}

/* ---- the bridge ---- */

static torque_range_t expect_bridged(int32_t current, int32_t lower, int32_t upper)
{
    const torque_range_t range = torque_loop_bridged(&cfg, FLUX, current, whole);

    TEST_ASSERT_EQUAL_INT32(lower, range.lower);
    TEST_ASSERT_EQUAL_INT32(upper, range.upper);
    return range;
}

static void expect_arrival(int32_t current, torque_range_t range, bool arrives)
{
    torque_loop_bridge(&loop);
    torque_loop_arrive(&loop, current, range);
    TEST_ASSERT_EQUAL(!arrives, loop.bridging);
}

TEST(test_a_bridge_goes_by_the_slope_until_its_loop_is_within)
{
    const torque_range_t range = expect_bridged(1000, 900, 1100);

    expect_arrival(1100, range, false);
    expect_arrival(1099, range, true);
    expect_arrival(901, range, true);
    expect_arrival(900, range, false);
}

/* However small the slope is. */
TEST(test_a_bridge_stays_within_the_range_and_always_moves)
{
    (void)expect_bridged(RANGE_MAX + 500, RANGE_MAX - 100, RANGE_MAX);
    (void)expect_bridged(-RANGE_MAX - 500, -RANGE_MAX, -RANGE_MAX + 100);
    cfg.slope = 1;
    (void)expect_bridged(-5, -6, -4);
}

/* ---- low speed ---- */

TEST(test_a_torque_aims_at_the_end_of_the_window_on_its_side)
{
    TEST_ASSERT_EQUAL_INT32(FORWARD, torque_loop_aim(&cfg, 1));
    TEST_ASSERT_EQUAL_INT32(-BACKWARD, torque_loop_aim(&cfg, -1));
    TEST_ASSERT_EQUAL_INT32(0, torque_loop_aim(&cfg, 0));
}

static void expect_window(step_t reference, step_t lowest, step_t lower, step_t upper)
{
    const speed_window_t window = torque_loop_window(&cfg, reference, lowest);

    TEST_ASSERT_EQUAL_INT32(lower, window.lower);
    TEST_ASSERT_EQUAL_INT32(upper, window.upper);
    TEST_ASSERT_EQUAL_UINT32(4U, window.load_shift);
}

TEST(test_the_window_ends_at_the_lowest_speed_on_the_side_of_the_motion)
{
    expect_window(1000000, LOWEST, LOWEST, FORWARD);
    expect_window(-1000000, LOWEST, -BACKWARD, -LOWEST);
    expect_window(-1000000, 0, -BACKWARD, FORWARD);
    cfg.speed_forward = LOWEST / 2;
    cfg.speed_backward = LOWEST / 4;
    expect_window(0, LOWEST, LOWEST / 2, LOWEST / 2);
    expect_window(-1, LOWEST, -LOWEST / 4, -LOWEST / 4);
}

/*
 * Caught at the lowest speed: what brakes goes on with the slope of the imposed vector, to the
 * other side.
 */
TEST(test_a_torque_against_the_motion_goes_down_the_slope_from_the_lowest_speed_on)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin(low_end(sign), sign * (LOWEST + 5000), sign * (LOWEST + 5000));
        in.current = sign * 77;
        for (int32_t k = 1; k < 200; k++) {
            in.reference = plan(-sign * 500);
            in.speed = in.reference;
            TEST_ASSERT_EQUAL_INT32(sign * (LOWEST - (k * RAMP)), in.reference);
            TEST_ASSERT_TRUE(loop.bound);
            TEST_ASSERT_FALSE(loop.bridging);
            TEST_ASSERT_EQUAL_INT32(sign * 77 * FLUX, loop.reference_q28);
        }
        in.reference = plan(-sign * 500);
        TEST_ASSERT_EQUAL_INT32(-sign * LOWEST, in.reference);
        TEST_ASSERT_FALSE(loop.bound);
        in.speed = -sign * 300000;
        for (uint32_t k = 0U; k < 50U; k++) {
            in.reference = plan(-sign * 500);
        }
        TEST_ASSERT_EQUAL_INT32(-sign * 300000, in.reference);
        TEST_ASSERT_EQUAL_INT32(-sign * 500, loop.current);
    }
}

TEST(test_without_a_torque_the_slope_ends_at_standstill)
{
    begin(SPEED_END_LOWER, LOWEST, LOWEST);
    for (uint32_t k = 0U; k < 300U; k++) {
        in.reference = plan(0);
        in.speed = in.reference;
    }
    TEST_ASSERT_EQUAL_INT32(0, in.reference);
    TEST_ASSERT_TRUE(loop.bound);
}

/* Where the speed loop has the torque, no end of the window has it. */
static void assert_bound(bool bound, bool bridging, const char *name)
{
    TEST_ASSERT_EQUAL_MESSAGE(bound, loop.bound, name);
    TEST_ASSERT_EQUAL_MESSAGE(bridging, loop.bridging, name);
    TEST_ASSERT_TRUE_MESSAGE(!bound || (loop.end == (uint8_t)SPEED_END_NONE), name);
}

/*
 * A rotor that is slower than the lowest speed, or that the end of the window holds there, with an
 * i_q* of 300. A bound torque goes on from 300, over a bridge if no end has caught the rotor. A
 * free torque begins with 0, or with 300 where the end holds the rotor; its slope is 100.
 */
TEST(test_below_the_lowest_speed_the_torque_is_bound_unless_it_holds_the_rotor_there)
{
    static const struct {
        const char *name;
        bool held;
        step_t speed; /* forwards; all of it is mirrored */
        int32_t target;
        step_t next;
        bool bound;
        int32_t current;
    } rows[] = {
        {"no torque, held just below", true, LOWEST - 1, 0, LOWEST - 1 - RAMP, true, 300},
        {"no torque, not yet below", false, LOWEST, 0, LOWEST, false, 0},
        {"against the motion, held", true, LOWEST, -500, LOWEST - RAMP, true, 300},
        {"with the motion, held", true, LOWEST + 10, 500, LOWEST, false, 400},
        {"with it, slower by more than a swing", true, LOWEST - (LOWEST / 8) - 1, 500,
         LOWEST - (LOWEST / 8) - 1 + RAMP, true, 300},
        {"with it, suddenly too slow", false, LOWEST / 2, 500, (LOWEST / 2) + RAMP, true, 300},
        {"against it, suddenly turned round", false, -3, -500, -RAMP, true, 300},
    };

    for (uint32_t k = 0U; k < (2U * (sizeof rows / sizeof rows[0])); k++) {
        const int32_t sign = ((k % 2U) == 0U) ? 1 : -1;
        const uint32_t r = k / 2U;

        begin(rows[r].held ? low_end(sign) : SPEED_END_NONE, sign * rows[r].speed, sign * LOWEST);
        in.current = sign * 300;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(sign * rows[r].next, plan(sign * rows[r].target),
                                        rows[r].name);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(sign * rows[r].current, loop.current, rows[r].name);
        assert_bound(rows[r].bound, rows[r].bound && !rows[r].held, rows[r].name);
    }
}

/*
 * The estimate swings there, caught by the end of the window or just above it: that binds nothing,
 * and raises no i_d*.
 */
TEST(test_a_torque_with_the_motion_stays_free_while_the_estimate_swings_about_the_lowest_speed)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        for (step_t swing = -LOWEST / 8; swing <= 0; swing += LOWEST / 100) {
            for (uint32_t k = 0U; k < 2U; k++) {
                begin((k == 0U) ? low_end(sign) : SPEED_END_NONE, sign * (LOWEST + swing),
                      sign * LOWEST);
                TEST_ASSERT_EQUAL_INT32(sign * LOWEST, plan(sign * 500));
                TEST_ASSERT_FALSE(loop.bound);
            }
        }
    }
}

/* With a sensor, or where nothing is imposed. */
TEST(test_without_a_lowest_speed_the_torque_is_free_at_any_speed)
{
    static const step_t speeds[] = {-BACKWARD - 1, -BACKWARD, -1, 0, 1, FORWARD, FORWARD + 1};

    in.lowest = 0;
    for (uint32_t k = 0U; k < (sizeof speeds / sizeof speeds[0]); k++) {
        begin(SPEED_END_LOWER, speeds[k], speeds[k]);
        TEST_ASSERT_EQUAL_INT32(fx_clamp(speeds[k], -BACKWARD, FORWARD), plan(0));
        TEST_ASSERT_FALSE(loop.bound);
    }
}

/* A window that ends below the lowest speed of RUN is a speed for the imposed vector. */
TEST(test_a_window_below_the_lowest_speed_binds)
{
    cfg.speed_forward = LOWEST / 2;
    for (uint32_t k = 0U; k < 2U; k++) {
        begin((k == 0U) ? SPEED_END_NONE : SPEED_END_LOWER, LOWEST, LOWEST);
        TEST_ASSERT_EQUAL_INT32(LOWEST / 2, plan(500));
        TEST_ASSERT_TRUE(loop.bound);
    }
}

/* A reference of 0 counts as forwards, one of −1 as backwards. */
TEST(test_a_rotor_on_the_side_of_its_reference_is_free_from_the_lowest_speed_on)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        begin(SPEED_END_NONE, sign * (LOWEST + 5), (sign > 0) ? 0 : -1);
        TEST_ASSERT_EQUAL_INT32(in.speed, plan(sign * 500));
        TEST_ASSERT_FALSE(loop.bound);
    }
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

static void use_acceleration(void)
{
    speed_cfg.inertia = (int32_t)lround(65536.0 / ACCELERATION);
    speed_cfg.inertia_shift = 0U;
    speed_cfg.inertia_lift = 0U;
}

/*
 * A rotor J·dω/dt = i − load (in LSB of current and steps of speed) under a torque that it cannot
 * keep: it comes to rest at the end of the window, and from one period to the next the current
 * changes no more than the PI about that end can.
 */
static void land(int32_t wanted, int32_t load, step_t end_of_window, speed_end_t expected)
{
    const double kp = ldexp(speed_cfg.pi.kp, -(int)speed_cfg.pi.kp_shift);
    const double ki = ldexp(speed_cfg.pi.ki, -(int)speed_cfg.pi.ki_shift - 11);
    double speed = 0.0;
    const double excess = abs(wanted - load);
    /* of a change of the speed by K_p, and of what K_p makes of the error by K_i; and roundings */
    const double most = (kp * excess * ACCELERATION / 4096.0) + (2.0 * excess * ki / kp) + 40.0;
    int32_t before = wanted;
    step_t furthest = 0;
    speed_end_t end = SPEED_END_NONE;

    speed_loop_reset(&speed_loop, 0);
    use_acceleration();
    for (uint32_t k = 0U; k < 3000U; k++) {
        const int32_t current = within((step_t)lround(speed), wanted, &end);

        speed += ACCELERATION * (current - load);
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
    double speed = -500000.0;
    speed_end_t end = SPEED_END_NONE;

    use_acceleration();
    speed_loop_reset(&speed_loop, (step_t)speed);
    for (uint32_t k = 0U; k < 200U; k++) {
        const int32_t current = within((step_t)lround(speed), 1500, &end);

        speed += ACCELERATION * (current - 1300);
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
