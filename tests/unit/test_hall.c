/* SPDX-License-Identifier: MIT */
/*
 * Hall sensors: angle at rest, in steady rotation and on a ramp, both ways; disturbances, jumps, a
 * signal that stands still.
 */
#include "hall.h"
#include "testing.h"

#include <stdint.h>

#define DEGREE (11930465) /* 2^32 / 360 */
#define SECTOR (0x2AAAAAABU)
#define TICKS_PER_TURN (250) /* 40 Hz at 10 kHz: motor B at 1200 rpm */
#define STEP (17179869)      /* 2^32 / 250 */

static const hall_cfg_t CFG = {
    .patterns = 05U | (01U << 3U) | (03U << 6U) | (02U << 9U) | (06U << 12U) | (04U << 15U),
    .edges_q16 = {0U, 10923U, 21845U, 32768U, 43691U, 54613U},
    .fast_speed = 0x20000000,
};

static hall_cfg_t cfg;
static hall_t hall;
static angle_t rotor;
static uint32_t stuck_high; /* signals that read 1, whatever the rotor */
static uint32_t stuck_low;
static bool timed;      /* the age of an edge is known */
static uint32_t age_q8; /* of the last edge */
static uint32_t before; /* pattern of the tick before */

void setUp(void)
{
    cfg = CFG;
    hall_start(&hall);
    rotor = 0U;
    stuck_high = 0U;
    stuck_low = 0U;
    timed = false;
    age_q8 = 1U;
    before = 0U;
}

static uint32_t true_pattern(void)
{
    uint32_t sector = 5U;

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        const angle_t begin = (angle_t)cfg.edges_q16[k] << 16U;
        const angle_t end = (angle_t)cfg.edges_q16[(k + 1U) % HALL_SECTORS] << 16U;

        sector = ((rotor - begin) < (end - begin)) ? k : sector;
    }
    return (cfg.patterns >> (3U * sector)) & 7U;
}

static uint32_t pattern(void)
{
    return (true_pattern() | stuck_high) & ~stuck_low;
}

static void step_hall(uint32_t levels)
{
    (void)hall_step(&hall, &cfg,
                    (hall_reading_t){.pattern = levels, .age_q8 = timed ? age_q8 : 0U});
}

/* As a timer measures it that each edge sets to 0, rounded down. */
static void grow_old(step_t step)
{
    const uint32_t now = pattern();

    age_q8 += 256U;
    for (uint32_t k = 0U; (k < HALL_SECTORS) && (now != before); k++) {
        const angle_t edge = (angle_t)cfg.edges_q16[k] << 16U;
        const int64_t since = (int64_t)(int32_t)(rotor - edge) * ((step > 0) ? 1 : -1);

        if ((since >= 0) && (since < (int64_t)fx_abs(step))) {
            age_q8 = 1U + (uint32_t)((since * 256) / fx_abs(step));
        }
    }
    before = now;
}

static int32_t error(void)
{
    return (int32_t)(hall.angle - rotor);
}

/* Ticks at this speed. Returns the largest |error| from tick `from` on. */
static int32_t turn(int32_t ticks, step_t step, int32_t from)
{
    int32_t largest = 0;

    for (int32_t k = 0; k < ticks; k++) {
        rotor += (angle_t)step;
        grow_old(step);
        step_hall(pattern());
        largest = (k >= from) ? fx_max(largest, fx_abs(error())) : largest;
    }
    return largest;
}

TEST(test_an_order_holds_when_neighbours_differ_in_one_signal_and_none_is_0_or_7)
{
    TEST_ASSERT_TRUE(hall_order_holds(CFG.patterns));
    TEST_ASSERT_FALSE(hall_order_holds(CFG.patterns ^ 7U));
    TEST_ASSERT_FALSE(hall_order_holds(0U));
    /* two neighbours exchanged */
    TEST_ASSERT_FALSE(hall_order_holds(01U | (05U << 3U) | (03U << 6U) | (02U << 9U) |
                                       (06U << 12U) | (04U << 15U)));
}

TEST(test_a_rotor_at_rest_is_in_the_middle_of_its_sector)
{
    for (uint32_t k = 0U; k < 360U; k++) {
        hall_start(&hall);
        rotor = (angle_t)(k * (uint32_t)DEGREE);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(31 * DEGREE, turn(10, 0, 2));
        TEST_ASSERT_TRUE(hall.known);
    }
}

/*
 * An edge comes up to half a tick, 0.72°, from the time that is reckoned with. Half of that passes
 * on, and as much again by the speed of a sector.
 */
TEST(test_in_steady_rotation_the_angle_is_that_of_the_rotor_within_the_jitter_of_a_tick)
{
    TEST_ASSERT_LESS_OR_EQUAL_INT32((3 * DEGREE) / 2, turn(2000, STEP + 12345, 1000));
    TEST_ASSERT_LESS_OR_EQUAL_INT32((3 * DEGREE) / 2, turn(3000, -STEP - 54321, 2000));
    TEST_ASSERT_LESS_OR_EQUAL_INT32(2 * DEGREE, turn(20000, 321000, 15000)); /* 0.75 Hz */
}

/*
 * 1/256 of a tick is 0.0056°: an edge is off by up to as much. The speed of a sector takes the
 * angle off by as much once more, that of a slow rotor, which is extrapolated, by three times as
 * much. A quarter of the last error is left.
 */
TEST(test_in_steady_rotation_the_time_of_an_edge_tells_the_angle_to_a_part_of_a_tick)
{
    timed = true;
    for (int32_t fast = 0; fast <= 1; fast++) {
        const int32_t share_q8 = (fast != 0) ? 3 : 6;

        cfg.fast_speed = (fast != 0) ? 1 : 0x20000000;
        TEST_ASSERT_LESS_OR_EQUAL_INT32((share_q8 * STEP) / 256, turn(2000, STEP + 12345, 1000));
        TEST_ASSERT_LESS_OR_EQUAL_INT32((share_q8 * STEP) / 256, turn(3000, -STEP - 54321, 2000));
    }
}

/*
 * Motor B at 1200 rpm, braked by 3 N·m: 545 rad/s² electrical, 0.9 % of the speed in a sector. A
 * step of the acceleration is a sector old before an edge tells it, and the speed between two edges
 * is that of their middle. Half of what is left is corrected at each edge, so 2.5 sectors are
 * missing in the end: 2.3 %.
 */
TEST(test_where_the_time_of_an_edge_is_known_the_speed_lags_behind_by_two_and_a_half_sectors)
{
    step_t step = STEP;
    int32_t largest = 0;

    timed = true;
    cfg.fast_speed = STEP / 2;
    (void)turn(2000, step, 0);
    for (uint32_t k = 0U; k < 500U; k++) {
        step -= 3728; /* 545 rad/s² electrical at 10 kHz */
        (void)turn(1, step, 0);
        largest = fx_max(largest, fx_abs(hall.speed - step));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT32((STEP / 1000) * 25, largest);
}

TEST(test_edges_at_their_own_angles_are_followed_as_well_as_even_ones)
{
    static const int32_t off[HALL_SECTORS] = {900, -700, 500, -900, 300, 600}; /* up to 5° */

    for (uint32_t k = 0U; k < HALL_SECTORS; k++) {
        cfg.edges_q16[k] = (cfg.edges_q16[k] + (uint32_t)off[k]) & 0xFFFFU;
    }
    cfg.edges_q16[0] = 900U;
    TEST_ASSERT_LESS_OR_EQUAL_INT32((3 * DEGREE) / 2, turn(3000, STEP, 2000));
}

/* From rest with 600 rad/s²: before the speed is known it is off by a sector's half, or a little.
 */
TEST(test_a_start_from_rest_is_off_by_no_more_than_the_half_of_a_sector_and_finds_the_speed)
{
    step_t step = 0;
    int32_t largest = 0;

    for (uint32_t k = 0U; k < 4000U; k++) {
        step += 4100; /* 600 rad/s² electrical at 10 kHz */
        largest = fx_max(largest, turn(1, step, 0) * ((k > 2U) ? 1 : 0));
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT32(45 * DEGREE, largest);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(2 * DEGREE, turn(750, step, 500));
}

TEST(test_a_rotor_that_stops_is_in_the_middle_of_its_sector_after_a_while)
{
    (void)turn(1000, STEP, 0);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(31 * DEGREE, turn(1000, 0, 900));
    TEST_ASSERT_EQUAL_INT32(0, hall.speed);
}

TEST(test_a_disturbance_of_one_tick_is_not_seen)
{
    for (uint32_t bit = 1U; bit <= 4U; bit *= 2U) {
        (void)turn(1000, STEP, 0);
        for (uint32_t k = 0U; k < 40U; k++) {
            rotor += STEP;
            step_hall(pattern() ^ (((k % 7U) == 3U) ? bit : 0U));
            TEST_ASSERT_LESS_OR_EQUAL_INT32(3 * DEGREE, fx_abs(error()));
        }
    }
}

TEST(test_a_pattern_that_passes_over_a_sector_is_named)
{
    (void)turn(1000, STEP, 0);
    (void)turn(1000, 0, 0);
    rotor += 2U * SECTOR;
    (void)turn(1, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, hall.trouble);
    (void)turn(1, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_JUMP, hall.trouble);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(31 * DEGREE, fx_abs(error()));
}

/* Turns until a signal is left out; at most three turns. Returns the largest error up to there. */
static int32_t turn_until_left_out(step_t step)
{
    int32_t largest = 0;

    for (int32_t k = 0; (k < (3 * TICKS_PER_TURN)) && (hall.dead == 0U); k++) {
        largest = fx_max(largest, turn(1, step, 0));
    }
    return largest;
}

/* Each signal, stuck at each level, at 12 places of a turn, both ways. */
TEST(test_a_signal_that_stands_still_is_named_and_the_other_two_tell_the_angle)
{
    for (uint32_t k = 0U; k < (3U * 2U * 12U * 2U); k++) {
        const uint32_t bit = (uint32_t)1U << (k % 3U);
        const step_t step = ((k / 36U) == 0U) ? STEP : -STEP;

        setUp();
        rotor = (angle_t)((k / 6U) % 12U) * (SECTOR / 2U);
        (void)turn(1000, step, 0);
        stuck_high = (((k / 3U) % 2U) != 0U) ? bit : 0U;
        stuck_low = bit ^ stuck_high;
        /* up to there it waits at the end of a sector for as long as a sector takes */
        TEST_ASSERT_LESS_OR_EQUAL_INT32(75 * DEGREE, turn_until_left_out(step));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_SIGNAL, hall.trouble);
        TEST_ASSERT_EQUAL_UINT8(bit, hall.dead);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(5 * DEGREE, turn(2000, step, 1000));
        TEST_ASSERT_TRUE(hall.known);
    }
}

/*
 * Of the same: the angle goes on with the speed. It is off by a quarter of a sector, where a signal
 * has made an edge too early, and by the jitter of a tick.
 */
TEST(test_a_fast_rotor_loses_a_signal_without_a_jerk)
{
    cfg.fast_speed = STEP / 2;
    for (uint32_t k = 0U; k < (3U * 2U * 12U * 2U); k++) {
        const uint32_t bit = (uint32_t)1U << (k % 3U);
        const step_t step = ((k / 36U) == 0U) ? STEP : -STEP;

        hall_start(&hall);
        stuck_high = 0U;
        stuck_low = 0U;
        rotor = (angle_t)((k / 6U) % 12U) * (SECTOR / 2U);
        (void)turn(1000, step, 0);
        stuck_high = (((k / 3U) % 2U) != 0U) ? bit : 0U;
        stuck_low = bit ^ stuck_high;
        TEST_ASSERT_LESS_OR_EQUAL_INT32(18 * DEGREE, turn_until_left_out(step));
        TEST_ASSERT_EQUAL_UINT8(bit, hall.dead);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(5 * DEGREE, turn(2000, step, 1000)); /* 120° long */
    }
}

static bool is_lost_or_jumps_within(uint32_t turns, step_t step)
{
    bool lost = false;

    for (uint32_t k = 0U; (k < (turns * (uint32_t)TICKS_PER_TURN)) && !lost; k++) {
        (void)turn(1, step, 0);
        lost = !hall.known || (hall.trouble == (uint8_t)SHAFT_TROUBLE_HALL_JUMP);
    }
    return lost;
}

/*
 * Each pair of signals, at each level, at 12 places of a turn, both ways; at once and one later.
 * Two at once may look like a jump, and then like a rotor at rest.
 */
TEST(test_two_signals_of_a_fast_rotor_that_stand_still_are_named)
{
    for (uint32_t k = 0U; k < (3U * 4U * 12U * 2U * 2U); k++) {
        const uint32_t left = (uint32_t)1U << (k % 3U);
        const uint32_t stuck = 7U ^ left;
        const uint32_t levels = (k / 3U) % 4U;
        const uint32_t first = (left == 1U) ? 2U : 1U;
        const uint32_t high =
            ((levels & 1U) != 0U ? first : 0U) | ((levels & 2U) != 0U ? (stuck ^ first) : 0U);
        const step_t step = (((k / 144U) % 2U) == 0U) ? STEP : -STEP;

        setUp();
        cfg.fast_speed = STEP / 2;
        rotor = (angle_t)((k / 12U) % 12U) * (SECTOR / 2U);
        (void)turn(1000, step, 0);
        if (k >= 288U) {
            stuck_high = high & first;
            stuck_low = first ^ stuck_high;
            (void)turn(2 * TICKS_PER_TURN, step, 0);
        }
        stuck_high = high;
        stuck_low = stuck ^ high;
        TEST_ASSERT_TRUE(is_lost_or_jumps_within(2U, step));
    }
}

TEST(test_a_fast_rotor_whose_pattern_stands_still_is_lost_while_the_angle_is_right)
{
    int32_t largest = 0;
    uint32_t ticks = 0U;
    uint32_t still;

    cfg.fast_speed = STEP / 2;
    (void)turn(1010, STEP, 0);
    still = pattern();
    while (hall.known && (ticks < 1000U)) {
        rotor += STEP;
        step_hall(still);
        largest = fx_max(largest, fx_abs(error()));
        ticks++;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT32(8 * DEGREE, largest);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32((4U * 42U) + 4U, ticks);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_PATTERN, hall.trouble);
}

TEST(test_an_illegal_pattern_of_unknown_cause_loses_the_angle_until_a_legal_one_comes)
{
    (void)turn(10, 0, 0);
    stuck_low = 7U;
    (void)turn(4, 0, 0);
    TEST_ASSERT_TRUE(hall.known);
    (void)turn(1, 0, 0);
    TEST_ASSERT_FALSE(hall.known);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_PATTERN, hall.trouble);
    stuck_low = 0U;
    (void)turn(2, 0, 0);
    TEST_ASSERT_TRUE(hall.known);
}

/* The signals of this broken one read what makes an illegal pattern where the rotor is now. */
static bool breaks_here(uint32_t bit)
{
    const uint32_t now = true_pattern();

    stuck_high = ((now | bit) == 7U) ? bit : 0U;
    stuck_low = ((now & ~bit) == 0U) ? bit : 0U;
    return (stuck_high | stuck_low) != 0U;
}

/* The pattern becomes illegal here, and the rotor stays. */
static void assert_no_other_signal_is_left_out(uint32_t bit)
{
    if (breaks_here(bit)) {
        (void)turn(10, 0, 0);
        TEST_ASSERT_TRUE((hall.dead == 0U) || (hall.dead == bit));
        TEST_ASSERT_EQUAL_INT(hall.dead != 0U, hall.known);
    }
}

/* With the speed of before another signal would be left out, and the angle be 120° off. */
TEST(test_a_signal_that_stands_still_after_the_rotor_has_turned_back_is_not_taken_for_another)
{
    for (uint32_t k = 0U; k < (3U * 6U * 40U); k++) {
        setUp();
        rotor = ((k / 3U) % 6U) * SECTOR;
        (void)turn(1000, STEP, 0);
        (void)turn(43 + (int32_t)(k / 18U), -STEP, 0); /* through one edge or two */
        assert_no_other_signal_is_left_out((uint32_t)1U << (k % 3U));
    }
}

/*
 * Up to two sectors and a half the speed would have brought it where a broken signal shows itself;
 * a sector takes 42 ticks.
 */
TEST(test_a_signal_that_stands_still_after_the_rotor_has_stopped_is_not_taken_for_another)
{
    for (uint32_t k = 0U; k < (3U * 6U * 8U); k++) {
        setUp();
        rotor = ((k / 3U) % 6U) * SECTOR;
        (void)turn(1000, STEP, 0);
        (void)turn(105 + (10 * (int32_t)(k / 18U)), 0, 0);
        assert_no_other_signal_is_left_out((uint32_t)1U << (k % 3U));
    }
}

/* A slow rotor: at once, or after up to the two sectors that a single signal would explain. */
TEST(test_a_connector_that_opens_while_the_rotor_turns_loses_the_angle)
{
    for (uint32_t k = 0U; k < (2U * 84U * 2U); k++) {
        const step_t step = ((k % 2U) == 0U) ? STEP : -STEP;

        setUp();
        (void)turn(1000 + (int32_t)(k / 4U) * 3, step, 0);
        stuck_high = (((k / 2U) % 2U) == 0U) ? 7U : 0U;
        stuck_low = 7U ^ stuck_high;
        TEST_ASSERT_TRUE(is_lost_or_jumps_within(1U, step));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_PATTERN, hall.trouble);
    }
}

TEST(test_no_sensor_at_all_is_named)
{
    stuck_low = 7U;
    (void)turn(6, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_PATTERN, hall.trouble);
    TEST_ASSERT_FALSE(hall.known);
}

/* Two sectors of 100° are one of 200° where the signal between them is left out. */
TEST(test_a_signal_that_stands_still_may_leave_a_sector_of_more_than_half_a_turn)
{
    cfg.fast_speed = STEP / 2; /* so that 200° without an edge are not a stop */
    cfg.edges_q16[1] = 18204U; /* 100° */
    cfg.edges_q16[2] = 36408U; /* 200° */
    cfg.edges_q16[3] = 43690U;
    cfg.edges_q16[4] = 50972U;
    cfg.edges_q16[5] = 58254U;
    (void)turn(1000, STEP, 0);
    stuck_high = 4U; /* what the edge at 100° changes */
    (void)turn_until_left_out(STEP);
    TEST_ASSERT_EQUAL_UINT8(4U, hall.dead);
    (void)turn(2000, STEP, 0);
    TEST_ASSERT_TRUE(hall.known);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(5 * DEGREE, turn(TICKS_PER_TURN, STEP, 0));
}

TEST(test_the_time_since_an_edge_ends_at_its_largest_value)
{
    const uint32_t largest = 0x100000U;

    (void)turn(10, 0, 0);
    hall.ticks = largest - 1U;
    (void)turn(3, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(largest, hall.ticks);
    TEST_ASSERT_TRUE(hall.known);
}
