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

/*
 * From here on a state is set and one step done. Sectors of 67.5°, 45° and 67.5°, twice: round
 * numbers in Q32.
 */
#define TICKS_MAX (0x100000U)
#define WIDE (0x30000000U)   /* sectors 0, 2, 3 and 5 */
#define NARROW (0x20000000U) /* sectors 1 and 4 */
#define MEASURED (0x100000)  /* speed of a wide sector in MEASURED_TICKS */
#define MEASURED_TICKS (768U)
#define CLOSE (0x0AAAAAA9)

static const hall_cfg_t ROUND = {
    .patterns = 05U | (01U << 3U) | (03U << 6U) | (02U << 9U) | (06U << 12U) | (04U << 15U),
    .edges_q16 = {0U, 0x3000U, 0x5000U, 0x8000U, 0xB000U, 0xD000U},
    .fast_speed = 0x20000000,
};

static uint32_t pattern_in(uint32_t sector)
{
    return (ROUND.patterns >> (3U * sector)) & 7U;
}

/* The rotor has been in this sector for long. */
static void be_in(uint32_t sector)
{
    setUp();
    cfg = ROUND;
    hall = (hall_t){.known = true,
                    .span = {(uint8_t)sector, 1U},
                    .seen = (uint8_t)pattern_in(sector),
                    .taken = (uint8_t)pattern_in(sector),
                    .patience = TICKS_MAX};
}

/* The step in which a pattern counts. */
static void take(uint32_t levels)
{
    hall.seen = (uint8_t)levels;
    step_hall(levels);
}

static void be_at_speed(step_t speed)
{
    hall.paced = true;
    hall.speed = speed;
    hall.pace = speed;
}

/* Before the end of a wide sector: of 0 forwards, of 3 backwards. */
static void be_in_wide(int8_t direction)
{
    be_in((direction > 0) ? 0U : 3U);
    hall.direction = direction;
    hall.edge = (direction > 0) ? 0U : 0xB0000000U;
}

/* Its edge counts in this tick after the one before. */
static void end_wide(uint32_t ticks)
{
    hall.ticks = ticks - 1U;
    take(pattern_in((hall.direction > 0) ? 1U : 2U));
}

TEST(test_an_order_does_not_hold_with_one_wrong_pair_or_with_patterns_left_out)
{
    TEST_ASSERT_FALSE(hall_order_holds(05U | (01U << 3U) | (02U << 6U) | (03U << 9U) |
                                       (06U << 12U) | (04U << 15U)));
    TEST_ASSERT_FALSE(hall_order_holds(05U | (01U << 3U) | (05U << 6U) | (01U << 9U) |
                                       (05U << 12U) | (01U << 15U)));
    TEST_ASSERT_FALSE(hall_order_holds(05U | (01U << 3U) | (00U << 6U) | (02U << 9U) |
                                       (06U << 12U) | (04U << 15U)));
}

TEST(test_signals_that_are_all_1_from_the_start_are_named_from_the_fifth_tick_on)
{
    for (uint32_t k = 1U; k <= 300U; k++) {
        step_hall(7U);
        TEST_ASSERT_EQUAL_UINT8((k < 5U) ? SHAFT_TROUBLE_NONE : SHAFT_TROUBLE_HALL_PATTERN,
                                hall.trouble);
    }
    TEST_ASSERT_EQUAL_UINT8(4U, hall.unlike);
}

TEST(test_a_legal_pattern_ends_the_count_of_illegal_ones)
{
    be_in(0U);
    hall.unlike = 3U;
    take(pattern_in(1U));
    TEST_ASSERT_EQUAL_UINT8(0U, hall.unlike);
    TEST_ASSERT_EQUAL_UINT8(pattern_in(1U), hall.taken);
}

TEST(test_an_edge_that_is_missed_by_a_fast_rotor_loses_the_angle_and_all_that_is_known_of_signals)
{
    be_in(0U);
    be_at_speed(MEASURED);
    hall.fast = true;
    hall.dead = 2U;
    hall.ticks = 10U;
    hall.patience = 10U;
    step_hall(7U);
    TEST_ASSERT_FALSE(hall.known);
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_PATTERN, hall.trouble);
    TEST_ASSERT_EQUAL_UINT8(0U, hall.dead);
    TEST_ASSERT_EQUAL_UINT8(0U, hall.unlike); /* a pattern is seen for the first time */
    TEST_ASSERT_EQUAL_UINT32(11U, hall.ticks);
    TEST_ASSERT_EQUAL_UINT32(TICKS_MAX, hall.patience);
}

TEST(test_a_lost_angle_is_not_lost_again_and_stays_where_no_edge_comes)
{
    be_in(0U);
    be_at_speed(MEASURED);
    hall.known = false;
    hall.fast = true;
    hall.ticks = TICKS_MAX - 1U;
    hall.patience = TICKS_MAX - 1U;
    step_hall(pattern_in(0U));
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, hall.trouble);
    TEST_ASSERT_EQUAL_UINT32(TICKS_MAX, hall.ticks);
    TEST_ASSERT_EQUAL_UINT32(WIDE / 2U / 64U, hall.angle); /* to the middle, not with the speed */
}

TEST(test_a_trouble_is_told_for_one_tick)
{
    be_in(0U);
    hall.trouble = (uint8_t)SHAFT_TROUBLE_HALL_JUMP;
    step_hall(pattern_in(0U));
    TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_NONE, hall.trouble);
}

/* A jump from sector 0 to 2 at this pace, which begins the time of an edge anew. */
static void jump_at(step_t pace)
{
    be_at_speed(pace);
    hall.speed = 0;
    hall.angle = WIDE;
    cfg.edges_q16[1] = 0x1000U; /* the angle is in sector 2 already, and stays */
    cfg.edges_q16[2] = 0x3000U;
    cfg.edges_q16[3] = 0x3000U + (NARROW >> 16U);
    hall.fast = true;
    take(pattern_in(2U));
    TEST_ASSERT_EQUAL_UINT32(WIDE, hall.edge);
    TEST_ASSERT_EQUAL_UINT32(0U, hall.ticks);
}

/* 2^30 + 1 = 13325 · 80581 and 2^30 + 2 = 3033169 · 354. */
TEST(test_a_slow_rotor_is_waited_for_twice_the_time_of_its_sector_and_one_2_to_32_of_a_turn)
{
    be_in(0U);
    jump_at(13325);
    TEST_ASSERT_EQUAL_UINT32(80581U, hall.patience);
    be_in(0U);
    jump_at(-3033169);
    TEST_ASSERT_EQUAL_UINT32(353U, hall.patience);
    be_in(0U);
    jump_at(1);
    TEST_ASSERT_EQUAL_UINT32(TICKS_MAX, hall.patience);
}

/* 4 · 60° in Q32 and 1 are 19 · 150700607. */
TEST(test_a_rotor_of_the_fast_speed_is_waited_for_four_sectors)
{
    be_in(0U);
    cfg.fast_speed = 150700607;
    jump_at(150700607);
    TEST_ASSERT_TRUE(hall.fast);
    TEST_ASSERT_EQUAL_UINT32(18U, hall.patience);
    be_in(0U);
    cfg.fast_speed = 150700607;
    jump_at(150700606);
    TEST_ASSERT_FALSE(hall.fast);
}

/*
 * Without signal 1 the sectors 5 and 0 are one, of half a turn here. 2^32 − 1 =
 * 65537 · 65535, and 1048575 times 4096 and a rest.
 */
TEST(test_in_a_sector_of_half_a_turn_an_edge_is_waited_for_a_whole_turn)
{
    static const step_t paces[] = {65537, 4096};
    static const uint32_t ticks[] = {65535U, 1048575U};

    for (uint32_t k = 0U; k < 2U; k++) {
        be_in(2U);
        cfg.edges_q16[5] = 0xE000U;
        cfg.edges_q16[1] = 0x6000U;
        cfg.edges_q16[2] = 0x7000U;
        be_at_speed(paces[k]);
        hall.speed = 0;
        hall.angle = 0U;
        hall.fast = true;
        hall.dead = 1U;
        take(pattern_in(0U));
        TEST_ASSERT_EQUAL_UINT8(5U, hall.span.first);
        TEST_ASSERT_EQUAL_UINT8(2U, hall.span.count);
        TEST_ASSERT_EQUAL_UINT32(ticks[k], hall.patience);
    }
}

/* The angle is within the sector jumped to, but no speed is known; or it is at its end. */
TEST(test_a_jump_without_a_speed_that_explains_it_begins_in_the_middle_of_the_sector)
{
    for (int32_t paced = 0; paced <= 1; paced++) {
        be_in(0U);
        cfg.fast_speed = 1;
        hall.fast = true;
        hall.paced = paced != 0;
        hall.angle = (paced != 0) ? 0x80000000U : 0x70000000U;
        hall.pace = 77;
        hall.steady = false;
        hall.direction = (paced != 0) ? 1 : -1;
        hall.turned = true;
        hall.ticks = 100U;
        hall.seen_age_q8 = 9U;
        take(pattern_in(2U));
        TEST_ASSERT_EQUAL_UINT8(SHAFT_TROUBLE_HALL_JUMP, hall.trouble);
        TEST_ASSERT_EQUAL_UINT32(0x68000000U, hall.angle);
        TEST_ASSERT_EQUAL_INT8(0, hall.direction);
        TEST_ASSERT_FALSE(hall.turned || hall.steady || hall.paced || hall.fast);
        TEST_ASSERT_EQUAL_INT32(0, hall.pace);
        TEST_ASSERT_EQUAL_UINT32(0U, hall.ticks);
        TEST_ASSERT_EQUAL_UINT16(9U, hall.edge_age_q8);
        TEST_ASSERT_EQUAL_UINT32(TICKS_MAX, hall.patience);
    }
}

/* From 2048 ticks on no part of a tick counts. way/time is 393216 without the half tick. */
TEST(test_the_part_of_a_tick_counts_below_2048_ticks)
{
    be_in_wide(1);
    end_wide(2047U);
    TEST_ASSERT_EQUAL_INT32((step_t)((WIDE / (2047U * 256U)) * 256U), hall.speed);
    be_in_wide(1);
    hall.edge_age_q8 = 128U;
    end_wide(2048U);
    TEST_ASSERT_EQUAL_INT32((step_t)(WIDE / 2048U), hall.speed);
}

TEST(test_a_measured_speed_ends_at_2_to_28)
{
    be_in_wide(1);
    end_wide(2U);
    TEST_ASSERT_EQUAL_INT32(0x0FFFFF00, hall.speed);
    be_in_wide(-1);
    end_wide(2U);
    TEST_ASSERT_EQUAL_INT32(-0x0FFFFF00, hall.speed);
}

/* Speed of a slow rotor after a wide sector in this time, from the one of the sector before. */
static step_t slow_after(uint32_t ticks, step_t before_it, bool with_time)
{
    be_in_wide((before_it > 0) ? 1 : -1);
    be_at_speed(before_it);
    hall.timed = with_time;
    end_wide(ticks);
    return hall.speed;
}

TEST(test_the_speed_of_a_slow_rotor_is_extrapolated_where_the_jitter_of_a_tick_does_not_matter)
{
    const step_t of_12 = (step_t)(WIDE / 12U);
    const step_t of_65 = (step_t)((WIDE / (65U * 256U)) * 256U);
    const step_t of_64 = (step_t)(WIDE / 64U);

    TEST_ASSERT_EQUAL_INT32(of_12 + 4096, slow_after(12U, of_12 - 4096, true));
    TEST_ASSERT_EQUAL_INT32(of_65 + 4096, slow_after(65U, of_65 - 4096, false));
    TEST_ASSERT_EQUAL_INT32(of_64 - 4096 + 1024, slow_after(64U, of_64 - 4096, false));
}

TEST(test_the_extrapolation_of_a_speed_changes_it_by_no_more_than_its_half)
{
    for (step_t sign = -1; sign <= 1; sign += 2) {
        const step_t measured = sign * MEASURED;

        TEST_ASSERT_EQUAL_INT32(measured + (measured / 2),
                                slow_after(MEASURED_TICKS, measured / 4, true));
        TEST_ASSERT_EQUAL_INT32(measured / 2, slow_after(MEASURED_TICKS, 4 * measured, true));
        TEST_ASSERT_EQUAL_INT32(measured, hall.pace);
    }
}

TEST(test_the_speed_of_a_fast_rotor_takes_on_a_half_of_a_change_or_a_quarter_without_time)
{
    for (int32_t with_time = 0; with_time <= 1; with_time++) {
        be_in_wide(1);
        be_at_speed(MEASURED - 4096);
        hall.fast = true;
        hall.timed = with_time != 0;
        end_wide(MEASURED_TICKS);
        TEST_ASSERT_EQUAL_INT32(MEASURED - ((with_time != 0) ? 2048 : 3072), hall.speed);
        TEST_ASSERT_EQUAL_INT32(hall.speed, hall.pace);
    }
}

/* A quarter of 838861, rounded down, is 1048576 − 838861. */
TEST(test_a_speed_is_steady_up_to_a_quarter_of_a_change_and_of_a_fast_rotor)
{
    (void)slow_after(MEASURED_TICKS, 838861, true);
    TEST_ASSERT_TRUE(hall.steady);
    (void)slow_after(MEASURED_TICKS, -838861, true);
    TEST_ASSERT_TRUE(hall.steady);
    (void)slow_after(MEASURED_TICKS, 838860, true);
    TEST_ASSERT_FALSE(hall.steady);
    be_in_wide(1);
    be_at_speed(MEASURED / 4);
    hall.fast = true;
    end_wide(MEASURED_TICKS);
    TEST_ASSERT_TRUE(hall.steady);
    be_in_wide(1);
    hall.pace = MEASURED; /* of before it stopped */
    end_wide(MEASURED_TICKS);
    TEST_ASSERT_FALSE(hall.steady);
}

/* Returns what is left of this error after the edge at the end of sector 0. */
static int32_t left_of(int32_t angle_error, bool paced, bool with_time)
{
    const angle_t now = WIDE + (angle_t)MEASURED; /* the edge counts a tick late */

    be_in_wide(1);
    be_at_speed(MEASURED);
    hall.paced = paced;
    hall.fast = true; /* the angle does not wait at the end */
    hall.timed = with_time;
    hall.angle = now - (angle_t)MEASURED - (angle_t)angle_error;
    end_wide(MEASURED_TICKS);
    return (int32_t)(now - hall.angle);
}

TEST(test_an_edge_corrects_three_quarters_of_an_error_up_to_15_degrees_or_half_without_time)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL_INT32(sign * 0x4000, left_of(sign * 0x10000, true, true));
        TEST_ASSERT_EQUAL_INT32(sign * 0x8000, left_of(sign * 0x10000, true, false));
        TEST_ASSERT_EQUAL_INT32(0, left_of(sign * 0x10000, false, true));
        TEST_ASSERT_INT32_WITHIN(1, sign * (CLOSE / 2), left_of(sign * CLOSE, true, false));
        TEST_ASSERT_EQUAL_INT32(0, left_of(sign * (CLOSE + 1), true, false));
    }
}

/* A pattern is illegal for the fourth tick; the rotor is expected there after `ticks`. */
static uint8_t left_out(angle_t expected, step_t pace, uint32_t ticks, bool paced)
{
    be_in(1U);
    be_at_speed(pace);
    hall.paced = paced;
    hall.fast = true;
    hall.edge = expected - ((angle_t)pace * ticks);
    hall.ticks = ticks - 1U;
    hall.unlike = 3U;
    take(7U);
    TEST_ASSERT_EQUAL(hall.dead != 0U, hall.known);
    return hall.dead;
}

/* 111 would be in sector 4 without signal 1, in 0 without 2, in 2 without 3: middles ± 45°. */
TEST(test_a_signal_is_left_out_where_the_rotor_is_within_45_degrees_of_the_sector_it_tells)
{
    static const angle_t middles[] = {0xC0000000U, 0x18000000U, 0x68000000U};

    for (uint32_t k = 0U; k < 3U; k++) {
        const uint32_t bit = (uint32_t)1U << k;

        TEST_ASSERT_EQUAL_UINT8(bit, left_out(middles[k] - 0x20000000U, 1, 1U, true));
        TEST_ASSERT_EQUAL_UINT8(bit, left_out(middles[k] + 0x1FFFFFFFU, 1, 1U, true));
        TEST_ASSERT_EQUAL_UINT8(0U, left_out(middles[k] - 0x20000001U, 1, 1U, true));
        TEST_ASSERT_EQUAL_UINT8(0U, left_out(middles[k] + 0x20000000U, 1, 1U, true));
    }
}

TEST(test_after_a_signal_is_left_out_the_rotor_is_waited_for_in_the_sector_that_is_told)
{
    TEST_ASSERT_EQUAL_UINT8(1U, left_out(0xC0000000U, MEASURED, 1U, true));
    TEST_ASSERT_EQUAL_UINT8(4U, hall.span.first);
    TEST_ASSERT_EQUAL_UINT8(1U, hall.span.count);
    TEST_ASSERT_EQUAL_UINT8(7U, hall.taken);
    TEST_ASSERT_EQUAL_UINT32((2U * NARROW) / (uint32_t)MEASURED, hall.patience);
    TEST_ASSERT_FALSE(hall.fast);
}

/* 4 · 60° less than 19 · 150700607 by 1, and 2.5 · 60° less than 12 · 149130809 by 1. */
TEST(test_a_signal_is_left_out_up_to_four_sectors_after_an_edge_and_two_and_a_half_of_a_slow_one)
{
    TEST_ASSERT_EQUAL_UINT8(1U, left_out(0xC0000000U, 150700607, 18U, true));
    TEST_ASSERT_EQUAL_UINT8(0U, left_out(0xC0000000U, 150700607, 19U, true));
    TEST_ASSERT_EQUAL_UINT8(1U, left_out(0xC0000000U, 149130809, 11U, false));
    TEST_ASSERT_EQUAL_UINT8(0U, left_out(0xC0000000U, 149130809, 12U, false));
}

/* Passes back the edge by which it has come into sector 1. */
static bool is_known_after_turning(bool fast, bool turned, uint8_t dead)
{
    be_in(1U);
    be_at_speed(MEASURED);
    hall.direction = 1;
    hall.edge = WIDE;
    hall.angle = WIDE + (NARROW / 2U);
    hall.fast = fast;
    hall.turned = turned;
    hall.dead = dead;
    hall.ticks = 100U;
    take(pattern_in(0U));
    return hall.known;
}

/* Signal 2 does not change between the sectors 0 and 1. */
TEST(test_the_angle_is_lost_where_a_fast_rotor_turns_or_twice_any_without_a_signal)
{
    TEST_ASSERT_TRUE(is_known_after_turning(false, false, 0U));
    TEST_ASSERT_TRUE(is_known_after_turning(false, true, 0U));
    TEST_ASSERT_TRUE(is_known_after_turning(false, false, 2U));
    TEST_ASSERT_FALSE(is_known_after_turning(true, false, 0U));
    TEST_ASSERT_FALSE(is_known_after_turning(false, true, 2U));
    be_in(0U);
    hall.dead = 1U; /* sectors 5 and 0 are one */
    hall.span = (hall_span_t){5U, 2U};
    hall.direction = 1;
    hall.turned = true;
    take(pattern_in(4U));
    TEST_ASSERT_FALSE(hall.known);
}

TEST(test_a_rotor_that_turns_is_at_the_edge_and_its_speed_not_known)
{
    (void)is_known_after_turning(false, false, 0U);
    TEST_ASSERT_EQUAL_UINT32(WIDE, hall.angle);
    TEST_ASSERT_EQUAL_UINT32(WIDE, hall.edge);
    TEST_ASSERT_EQUAL_INT8(-1, hall.direction);
    TEST_ASSERT_TRUE(hall.turned);
    TEST_ASSERT_EQUAL_INT32(0, hall.pace);
    TEST_ASSERT_EQUAL_INT32(0, hall.speed);
    TEST_ASSERT_FALSE(hall.paced || hall.steady);
}

/* Whether this pattern counts at a steady speed in this tick after the edge into sector 0. */
static bool counts(uint32_t sector, step_t pace, uint32_t ticks)
{
    be_in_wide(1);
    be_at_speed(pace);
    hall.speed = 0;
    hall.steady = true;
    hall.ticks = ticks - 1U;
    take(pattern_in(sector));
    return hall.taken == pattern_in(sector);
}

/*
 * One less than: half of sector 0 is 127867 · 3149; 60° 1549411 · 462; 120° 65537 · 21845. 120° and
 * 1 are 3384529 · 423.
 */
TEST(test_at_a_steady_speed_an_edge_waits_until_the_rotor_can_be_there)
{
    TEST_ASSERT_FALSE(counts(1U, 127867, 3149U));
    TEST_ASSERT_TRUE(counts(1U, 127867, 3150U));
    TEST_ASSERT_FALSE(counts(1U, MEASURED, 383U)); /* 2^20 · 384 is the half */
    TEST_ASSERT_TRUE(counts(1U, MEASURED, 384U));
    TEST_ASSERT_FALSE(counts(5U, 1549411, 462U)); /* back */
    TEST_ASSERT_TRUE(counts(5U, 1549411, 463U));
    TEST_ASSERT_FALSE(counts(2U, 65537, 21845U)); /* a jump */
    TEST_ASSERT_TRUE(counts(2U, 65537, 21846U));
    TEST_ASSERT_TRUE(counts(2U, 3384529, 423U));
}

TEST(test_no_edge_waits_where_the_speed_is_not_steady_or_the_angle_is_lost)
{
    for (int32_t lost = 0; lost <= 1; lost++) {
        be_in_wide(1);
        be_at_speed(MEASURED);
        hall.steady = lost != 0;
        hall.known = lost == 0;
        end_wide(2U);
        TEST_ASSERT_EQUAL_UINT8(pattern_in(1U), hall.taken);
        TEST_ASSERT_TRUE(hall.known);
    }
}

TEST(test_a_change_of_the_signal_that_is_left_out_is_no_edge)
{
    be_in(0U);
    hall.dead = 1U; /* sectors 5 and 0 are one */
    hall.span = (hall_span_t){5U, 2U};
    hall.ticks = 100U;
    take(pattern_in(5U));
    TEST_ASSERT_EQUAL_UINT8(pattern_in(5U), hall.taken);
    TEST_ASSERT_EQUAL_UINT32(101U, hall.ticks);
}

/* Returns the angle after a tick in sector 0 at this speed. */
static angle_t after_tick(angle_t angle, step_t speed)
{
    be_in_wide(1);
    be_at_speed(speed);
    hall.angle = angle;
    step_hall(pattern_in(0U));
    return hall.angle;
}

/* Two ticks at most are between the edge and the tick in which it counts. */
TEST(test_the_angle_waits_two_ticks_beyond_the_nearer_end_of_the_sector)
{
    const angle_t opposite = WIDE + 0x68000000U; /* half of the 292.5° outside of it */

    TEST_ASSERT_EQUAL_UINT32(WIDE + 2000U, after_tick(WIDE + 1500U, 1000));
    TEST_ASSERT_EQUAL_UINT32(WIDE + 1999U, after_tick(WIDE + 999U, 1000));
    TEST_ASSERT_EQUAL_UINT32(0U - 2000U, after_tick(0U - 1500U, -1000));
    TEST_ASSERT_EQUAL_UINT32(WIDE, after_tick(opposite - 1U, 0));
    TEST_ASSERT_EQUAL_UINT32(0U, after_tick(opposite, 0));
}

/* Returns how far the angle goes in a tick at rest, from an end of sector 0 to its middle. */
static int32_t to_middle(bool from_end, bool turned)
{
    const angle_t from = from_end ? WIDE : 0U;

    be_in(0U);
    cfg.fast_speed = 0x100000;
    hall.turned = turned;
    hall.angle = from;
    step_hall(pattern_in(0U));
    return (int32_t)(hall.angle - from);
}

TEST(test_at_rest_the_angle_goes_a_64th_of_the_way_to_the_middle_and_slowly_after_a_turn)
{
    TEST_ASSERT_EQUAL_INT32((int32_t)(WIDE / 2U / 64U), to_middle(false, false));
    TEST_ASSERT_EQUAL_INT32(-(int32_t)(WIDE / 2U / 64U), to_middle(true, false));
    TEST_ASSERT_EQUAL_INT32(0x10000, to_middle(false, true));
    TEST_ASSERT_EQUAL_INT32(-0x10000, to_middle(true, true));
}

static uint16_t age_seen(uint32_t age)
{
    be_in(0U);
    timed = age != 0U;
    age_q8 = age;
    step_hall(pattern_in(1U));
    TEST_ASSERT_EQUAL(timed, hall.timed);
    return hall.seen_age_q8;
}

TEST(test_the_age_of_an_edge_is_a_tick_at_most_and_half_a_tick_where_it_is_not_known)
{
    TEST_ASSERT_EQUAL_UINT16(255U, age_seen(255U));
    TEST_ASSERT_EQUAL_UINT16(256U, age_seen(256U));
    TEST_ASSERT_EQUAL_UINT16(256U, age_seen(1000U));
    TEST_ASSERT_EQUAL_UINT16(128U, age_seen(0U));
}
