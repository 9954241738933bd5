/* SPDX-License-Identifier: MIT */
/*
 * The motion loops at the ends of their ranges: towards standstill, on a ramp, with the torque at
 * its limit.
 */
#include "testing.h"

#include "placed_drive.h"

#include <math.h>

#define SHARE_STEPS (4) /* the product with the share has 14 bits behind the point */
#define ROOT_LSB (1)    /* it is rounded down */

/* ---- towards standstill ---- */

static step_t planned_from(step_t reference)
{
    stand_in(RUN, reference);
    in.command.target = 0;
    slot(SLOT_PLAN);
    return drive.motion.speed_reference;
}

TEST(test_below_the_hold_speed_run_follows_the_ramp_of_an_imposed_vector)
{
    const step_t hold = cfg.startup.hold_speed;
    const step_t gentle = cfg.startup.ramp;
    const step_t ramp = cfg.speed_loop.ramp;

    TEST_ASSERT_TRUE(gentle < ramp);
    TEST_ASSERT_EQUAL_INT32(hold - ramp, planned_from(hold));
    TEST_ASSERT_EQUAL_INT32(hold - 1 - gentle, planned_from(hold - 1));
    TEST_ASSERT_EQUAL_INT32(ramp - hold, planned_from(-hold));
    TEST_ASSERT_EQUAL_INT32(1 - hold + gentle, planned_from(1 - hold));
    cfg.startup.current_hold = 0; /* no start-up: nothing is imposed at standstill */
    TEST_ASSERT_EQUAL_INT32(hold - 1 - ramp, planned_from(hold - 1));
}

/*
 * A slow period in RUN with the imposed current, at this speed and under this load. The integral
 * changes by less than one LSB in it.
 */
static drive_state_t after_a_period_at(step_t reference, int32_t load)
{
    stand_in(RUN, reference);
    speed_loop_start(&drive.motion.speed_loop, reference, load);
    drive.control.current_ref = (dq_t){cfg.startup.current_hold, 0};
    slot(SLOT_LIMITS);
    slot(SLOT_SPEED);
    return drive.state;
}

/* Half of it, and half of that: rounded down, as hold_speed is no multiple of four. */
TEST(test_the_hand_back_waits_for_three_quarters_of_the_hold_speed)
{
    const step_t settled = (cfg.startup.hold_speed / 2) + (cfg.startup.hold_speed / 4);

    TEST_ASSERT_EQUAL_INT(RUN, after_a_period_at(settled + 1, 0));
    TEST_ASSERT_EQUAL_INT(RUN, after_a_period_at(-settled - 1, 0));
    TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(settled, 0));
    TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(-settled, 0));
}

TEST(test_with_a_load_run_goes_down_to_the_loaded_speed)
{
    const step_t loaded = cfg.startup.hold_speed / 4;
    const step_t settled = (loaded / 2) + (loaded / 4); /* loaded_speed is odd: rounded down */
    const int32_t load = cfg.startup.load_current;

    cfg.startup.loaded_speed = loaded;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL_INT(RUN, after_a_period_at(sign * loaded, sign * load));
        TEST_ASSERT_TRUE(drive.control.current_ref.d < cfg.startup.current_hold);
        /* A load that drives needs the imposed current. */
        TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(sign * loaded, -sign * 2 * load));
        TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(sign * settled, sign * load));
    }
    TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(loaded, load - 1));
    TEST_ASSERT_EQUAL_INT(RUN, after_a_period_at(settled + 1, load));
}

/*
 * A position profile still brakes at three quarters. Below half a load angle holds the position,
 * whatever the load.
 */
TEST(test_the_hand_back_of_a_position_profile_waits_for_half_of_the_hold_speed)
{
    const step_t half = cfg.startup.hold_speed / 2;

    cfg.startup.loaded_speed = half / 2;
    drive.motion.mode = (uint8_t)DRIVE_MODE_POSITION;
    TEST_ASSERT_EQUAL_INT(RUN, after_a_period_at(half + 1, 0));
    TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(half, 0));
    TEST_ASSERT_EQUAL_INT(HOLD, after_a_period_at(half, 2000));
}

/* ---- ramp, J and estimate ---- */

/*
 * A slow period in RUN with a reference from 0 on and a profile elsewhere. Returns whether they
 * wait for the torque, which is limited to lower…upper.
 */
static bool waits(step_t change, int32_t lower, int32_t upper, step_t estimate)
{
    bool waiting;

    stand_in(RUN, 0);
    position_loop_reset(&drive.motion.position_loop, 0, 0);
    drive.rotor.position.turns_q32 = QUARTER;
    drive.rotor.observer.speed = estimate;
    drive.motion.speed_reference = change;
    drive.motion.torque_range = (torque_range_t){lower, upper};
    slot(SLOT_SPEED);
    waiting = drive.motion.speed_loop.reference == 0;
    TEST_ASSERT_EQUAL_INT32(waiting ? 0 : change, drive.motion.speed_loop.reference);
    TEST_ASSERT_EQUAL_INT64(waiting ? QUARTER : 0, drive.motion.position_loop.profile_q32);
    return waiting;
}

TEST(test_ramp_and_profile_wait_at_the_end_of_a_narrowed_torque_and_only_there)
{
    const int32_t full = cfg.derating.current_max;
    const step_t ramp = cfg.speed_loop.ramp;
    const step_t beyond = cfg.speed_loop.speed_max; /* in one period: more than the whole torque */

    cfg.startup.current_hold = 0; /* no imposed current comes in */
    TEST_ASSERT_TRUE(waits(ramp, -full, 0, 0));
    TEST_ASSERT_TRUE(waits(-ramp, 0, full, 0));
    TEST_ASSERT_FALSE(waits(ramp, 0, full, 0));
    TEST_ASSERT_FALSE(waits(-ramp, -full, 0, 0));
    TEST_ASSERT_FALSE(waits(beyond, -full, full, 0));
    TEST_ASSERT_FALSE(waits(-beyond, -full, full, 0));
    TEST_ASSERT_EQUAL_INT32(-full, drive.control.current_ref.q);
}

/* The estimate lags the reference of a ramp. Returns the change of J. */
static int32_t learned_within(int32_t upper)
{
    (void)waits(cfg.speed_loop.ramp, -cfg.derating.current_max, upper,
                -cfg.startup.handover_speed / 16);
    return drive.motion.speed_loop.inertia_q17 - 131072;
}

TEST(test_j_is_learned_on_a_ramp_and_not_at_the_end_of_the_torque)
{
    cfg.startup.current_hold = 0;
    cfg.speed_loop.inertia_rate = 30274;
    cfg.speed_loop.inertia_rate_shift = 4U;
    cfg.speed_loop.inertia_most_q13 = 32767;
    TEST_ASSERT_EQUAL_INT32(0, learned_within(0));
    TEST_ASSERT_EQUAL_INT32(0, learned_within(100));
    TEST_ASSERT_TRUE(learned_within(cfg.derating.current_max) > 0);
}

static step_t estimate_after(step_t begun, step_t change, int32_t share_q14)
{
    cfg.run.acceleration_q14 = share_q14;
    (void)waits(change, -cfg.derating.current_max, cfg.derating.current_max, begun);
    return drive.rotor.observer.speed;
}

/* Within a quarter of the hand-over speed of the reference the rotor follows it. */
TEST(test_the_estimate_takes_on_its_share_of_a_ramp_that_its_rotor_follows)
{
    const step_t near = cfg.startup.handover_speed / 4;
    const step_t ramp = 4 * (cfg.speed_loop.ramp / 4);

    TEST_ASSERT_EQUAL_INT32(near + ramp, estimate_after(near, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(near + 1, estimate_after(near + 1, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(ramp - near, estimate_after(-near, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(-near - 1, estimate_after(-near - 1, ramp, 16384));
    TEST_ASSERT_EQUAL_INT32(near - ramp, estimate_after(near, -ramp, 16384));
    TEST_ASSERT_INT32_WITHIN(SHARE_STEPS, near + (ramp / 4), estimate_after(near, ramp, 4096));
    TEST_ASSERT_EQUAL_INT32(near, estimate_after(near, ramp, 0));
    TEST_ASSERT_EQUAL_INT32(near, estimate_after(near, -ramp, 0));
}

TEST(test_the_estimate_waits_with_a_ramp_that_waits)
{
    cfg.run.acceleration_q14 = 16384;
    TEST_ASSERT_TRUE(waits(cfg.speed_loop.ramp, -cfg.derating.current_max, 0, 0));
    TEST_ASSERT_EQUAL_INT32(0, drive.rotor.observer.speed);
}

/* ---- i_d* and what it leaves of the torque ---- */

/* i_d* after one slow period in RUN at the speed of the hand-over. */
static int32_t current_d_after(int32_t d, int32_t q)
{
    stand_in(RUN, cfg.startup.handover_speed);
    cfg.current_reference.floor = 4000;
    cfg.current_reference.slope = 64;
    cfg.current_reference.slope_down = 2;
    drive.control.current_ref = (dq_t){d, q};
    slot(SLOT_LIMITS);
    return drive.control.current_ref.d;
}

TEST(test_the_least_current_comes_with_its_slope_and_goes_with_its_own)
{
    const int32_t slope = 64 * (int32_t)cfg.slow_ticks;
    const int32_t fall = 2 * (int32_t)cfg.slow_ticks;

    TEST_ASSERT_EQUAL_INT32(slope, current_d_after(0, 0));
    TEST_ASSERT_EQUAL_INT32(4000, current_d_after(4000 - slope + 1, 0));
    TEST_ASSERT_EQUAL_INT32(4000 - fall, current_d_after(4000, 8000));
    TEST_ASSERT_EQUAL_INT32(2000 - fall, current_d_after(2000, -8000));
    TEST_ASSERT_EQUAL_INT32(3000, current_d_after(3000, 2000));
    /* What was imposed is above the least current, and of no use: it goes as it came. */
    TEST_ASSERT_EQUAL_INT32(8000 - slope, current_d_after(8000, 8000));
}

/* Which has neither i_d* nor a range. */
TEST(test_the_voltage_drive_leaves_the_current_reference_alone)
{
    drive.voltage_drive.active = true;
    TEST_ASSERT_EQUAL_INT32(0, current_d_after(0, 0));
    TEST_ASSERT_EQUAL_INT32(-8000, current_d_after(-8000, 0));
    TEST_ASSERT_EQUAL_INT32(8192, drive.motion.torque_range.upper);
}

/* i_d* after one slow period at a speed whose EMF is a sixteenth above the bus, with this demand.
 */
static int32_t current_d_beyond_base_speed(dq_t demand)
{
    const int32_t limit = modulator_limit(&cfg.modulator, drive.bus);
    const int32_t speed_q15 = ((limit + (limit / 16)) * 8192) / cfg.current_loop.emf_q13;

    weakening_reset(&drive.motion.weakening);
    (void)current_d_after(0, 0);
    stand_in(RUN, speed_q15 * 2048); /* 2^speed_shift */
    drive.control.current_ref = (dq_t){0, 0};
    drive.control.voltage = demand;
    slot(SLOT_LIMITS);
    return drive.control.current_ref.d;
}

TEST(test_the_least_current_gives_way_to_a_weakened_field_where_the_voltage_ends)
{
    const int32_t near = (15 * modulator_limit(&cfg.modulator, drive.bus)) / 16;

    TEST_ASSERT_EQUAL_INT32(64 * (int32_t)cfg.slow_ticks,
                            current_d_beyond_base_speed((dq_t){0, near}));
    TEST_ASSERT_LESS_THAN_INT32(0, current_d_beyond_base_speed((dq_t){0, near + 2}));
    TEST_ASSERT_LESS_THAN_INT32(0, current_d_beyond_base_speed((dq_t){-near - 2, 0}));
}

/* i_q* after a slow period with a large error of the speed, beside i_d*. */
static int32_t torque_beside(int32_t current_d, int32_t sign)
{
    const step_t speed = 2 * cfg.startup.handover_speed;

    stand_in(RUN, speed);
    speed_loop_start(&drive.motion.speed_loop, speed, sign * cfg.derating.current_max);
    drive.rotor.observer.speed -= sign * (speed / 2);
    drive.control.current_ref = (dq_t){current_d, 0};
    slot(SLOT_LIMITS);
    slot(SLOT_SPEED);
    return drive.control.current_ref.q;
}

TEST(test_the_torque_leaves_an_imposed_current_its_part_of_the_largest_one)
{
    const int32_t most = cfg.derating.current_max;
    const int32_t d = (most * 3) / 5;
    const int32_t slope = (int32_t)cfg.slow_ticks;
    const double room = sqrt(((double)most * most) - ((double)(d - slope) * (d - slope)));

    cfg.current_reference.floor = 1000;
    cfg.current_reference.slope = 1;
    cfg.current_reference.slope_down = 1;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_INT32_WITHIN(ROOT_LSB, sign * (int32_t)room, torque_beside(d, sign));
        TEST_ASSERT_EQUAL_INT32(0, torque_beside(most + slope, sign));
        TEST_ASSERT_EQUAL_INT32(sign * most, torque_beside(1000, sign));
    }
}

/* A bus at which nothing may be braked. */
TEST(test_the_torques_limits_follow_the_rotor_where_it_runs_and_the_vector_where_it_is_dragged)
{
    const step_t fast = 2 * cfg.derating.regeneration_speed;

    cfg.startup.current_hold = 0; /* no imposed current comes in */
    now.sample.bus = cfg.derating.bus_high.zero;
    stand_in(RUN, -fast);
    drive.rotor.observer.speed = fast;
    slot(SLOT_LIMITS);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_range.lower);
    TEST_ASSERT_EQUAL_INT32(8192, drive.motion.torque_range.upper);
    drive.state = IF_RAMP;
    slot(SLOT_LIMITS);
    TEST_ASSERT_EQUAL_INT32(-8192, drive.motion.torque_range.lower);
    TEST_ASSERT_EQUAL_INT32(0, drive.motion.torque_range.upper);
}

/* ---- the torque filter ---- */

/* A speed loop that asks for `current` within ± `limit`, and a filter that begins at `begun`. */
static void filter_torque(torque_filter_cfg_t filter, int32_t current, int32_t begun, int32_t limit)
{
    cfg.torque_filter = filter;
    stand_in(RUN, 0);
    speed_loop_start(&drive.motion.speed_loop, 0, current);
    torque_filter_start(&drive.motion.torque_filter, begun);
    drive.motion.torque_range = (torque_range_t){-limit, limit};
}

/* Takes over half of a change in a period. */
static const torque_filter_cfg_t HALF = {.smooth_rate_q15 = 16384};
static const torque_filter_cfg_t NO_FILTER = {.smooth_rate_q15 = 0};

TEST(test_the_torque_filter_stands_behind_the_speed_loop)
{
    filter_torque(HALF, 4000, 1000, 6000);
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(2500, drive.control.current_ref.q);
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(3250, drive.control.current_ref.q);
    cfg.torque_filter = NO_FILTER;
    slot(SLOT_SPEED);
    TEST_ASSERT_EQUAL_INT32(4000, drive.control.current_ref.q);
}

/* A low-pass that is still above a range that has just become narrow. */
TEST(test_behind_the_torque_filter_the_torque_keeps_its_limits)
{
    static const int32_t asked[] = {6000, 2000, -6000, -2000}; /* half of the way is 4000 or more */

    for (uint32_t k = 0U; k < COUNT(asked); k++) {
        const int32_t sign = (asked[k] > 0) ? 1 : -1;

        filter_torque(HALF, asked[k], sign * 6000, 3001);
        slot(SLOT_SPEED);
        TEST_ASSERT_EQUAL_INT32(sign * 3001, drive.control.current_ref.q);
    }
}

/* However long a rotor is too slow for the whole torque. */
TEST(test_at_the_end_of_its_range_the_torque_winds_up_no_more_than_without_a_filter)
{
    int32_t integral[2];

    for (uint32_t k = 0U; k < 2U; k++) {
        filter_torque((k == 0U) ? NO_FILTER : HALF, 5000, 5000, 6000);
        drive.rotor.observer.speed = -cfg.startup.handover_speed;
        slots(SLOT_SPEED, 500U);
        TEST_ASSERT_EQUAL_INT32(6000, drive.control.current_ref.q);
        integral[k] = drive.motion.speed_loop.pi.integral_q26;
    }
    TEST_ASSERT_EQUAL_INT32(integral[0], integral[1]);
}

/* Sine and cosine are rounded, so the gain of a notch at rest is not quite 1. */
TEST(test_behind_a_notch_the_limit_of_the_torque_is_reached_in_the_end)
{
    static const double notches_hz[] = {4.0, 10.0, 23.4, 120.0, 495.0}; /* at 1 kHz */

    for (uint32_t k = 0U; k < (2U * COUNT(notches_hz)); k++) {
        const int32_t sign = ((k % 2U) == 0U) ? 1 : -1;
        const double turn = 2.0 * EXAMPLE_PI * notches_hz[k / 2U] / 1000.0;
        const torque_filter_cfg_t notch = {
            .notch_share_q15 = 1000,
            .notch_turn = {.sin = (int16_t)lround(32767.0 * sin(turn)),
                           .cos = (int16_t)lround(32767.0 * cos(turn))},
        };

        filter_torque(notch, sign * 12002, 0, 6001);
        drive.rotor.observer.speed = -sign * cfg.startup.handover_speed;
        slots(SLOT_SPEED, 3000U);
        TEST_ASSERT_EQUAL_INT32(sign * 6001, drive.control.current_ref.q);
    }
}
