/* SPDX-License-Identifier: MIT */
/* Safe state: what shorts a motor, what opens the gates, whatever the sensors do. */
#include "safe_state.h"

#include "fx.h"
#include "testing.h"

#include <math.h>

#define TWO_PI (6.283185307179586)
#define STEPS_PER_TURN (4294967296.0)
#define OPEN_SPEED (100000000) /* 43 ticks a turn */
#define BUS_MAX (30000)
#define AMPLITUDE (8000.0)
/* 3/4 of the change of AMPLITUDE over five ticks at OPEN_SPEED: 2·8000·sin(5·π/42.9)·3/4 */
#define CHANGE_MIN (4294)
#define SETTLE (86U) /* two turns */

static const safe_state_cfg_t CFG = {
    .open_speed = OPEN_SPEED,
    .span_ticks = 5U,
    .change_min = CHANGE_MIN,
    .settle_ticks = SETTLE,
};

static safe_state_t safe;
static double angle; /* turns */

void setUp(void)
{
    safe = (safe_state_t){.phase = SAFE_STATE_BROKEN, .slow_ticks = 77U};
    safe_state_reset(&safe);
    angle = 0.0;
}

static bool step(ab_t current, int32_t bus)
{
    const safe_state_in_t in = {.current = current, .bus = bus, .bus_max = BUS_MAX};

    return safe_state_step(&safe, &CFG, &in);
}

/* What the sensors are. */
typedef enum {
    HEALTHY,
    A_STANDS_STILL,
    B_STANDS_STILL,
    A_IS_OPEN, /* the wire */
    B_IS_OPEN,
    SHIFTED, /* by a current that does not turn, larger than what turns */
    CLIPPED,
    KINDS
} sensors_t;

/* Phase currents a and b of a machine in the short circuit at this share of OPEN_SPEED. */
static ab_t current_of(sensors_t sensors, double amplitude)
{
    const double turn = angle * TWO_PI;
    double a = amplitude * cos(turn);
    double b = amplitude * cos(turn - TWO_PI / 3.0);

    if (sensors == A_STANDS_STILL) {
        a = 3000.0;
    } else if (sensors == B_STANDS_STILL) {
        b = -5000.0;
    } else if (sensors == A_IS_OPEN) {
        b = 0.5 * sqrt(3.0) * amplitude * cos(turn);
        a = 0.0;
    } else if (sensors == B_IS_OPEN) {
        a = 0.5 * sqrt(3.0) * amplitude * cos(turn);
        b = 0.0;
    } else if (sensors == SHIFTED) {
        a = 0.5 * a + 6000.0;
        b = 0.5 * b + 3000.0;
    } else if (sensors == CLIPPED) {
        a = fmin(fmax(2.0 * a, -AMPLITUDE), AMPLITUDE);
        b = fmin(fmax(2.0 * b, -AMPLITUDE), AMPLITUDE);
    } else {
        /* as they are */
    }
    return transforms_clarke((int32_t)lround(a), (int32_t)lround(b));
}

/* Ticks at a share of OPEN_SPEED until the gates open, `most` if they do not. */
static uint32_t ticks_short(sensors_t sensors, double share, uint32_t most)
{
    uint32_t count = 0U;

    while ((count < most) && step(current_of(sensors, AMPLITUDE), 20000)) {
        angle += share * (double)OPEN_SPEED / STEPS_PER_TURN;
        count++;
    }
    return count;
}

TEST(test_a_motor_is_shorted_above_the_speed_and_not_at_it)
{
    safe_state_leave(&safe, &CFG, OPEN_SPEED);
    TEST_ASSERT_FALSE(safe_state_is_short(&safe));
    TEST_ASSERT_FALSE(step((ab_t){8000, 0}, 20000));
    safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
    TEST_ASSERT_TRUE(safe_state_is_short(&safe));
    TEST_ASSERT_TRUE(step((ab_t){8000, 0}, 20000));
}

TEST(test_without_a_speed_nothing_shorts_it)
{
    safe_state_cfg_t open = CFG;
    const safe_state_in_t in = {.current = {8000, 0}, .bus = 32767, .bus_max = BUS_MAX};

    open.open_speed = 0;
    safe_state_leave(&safe, &open, 1 << 30);
    TEST_ASSERT_FALSE(safe_state_step(&safe, &open, &in));
    safe_state_leave(&safe, &CFG, 1 << 29);
    TEST_ASSERT_TRUE(safe_state_step(&safe, &CFG, &in));
    TEST_ASSERT_FALSE(safe_state_step(&safe, &open, &in)); /* a change of the configuration */
}

/*
 * At half of it an open wire and a clipped sensor are slow too; at 3/4 of a healthy one's change
 * the gates are still shut.
 */
TEST(test_the_short_circuit_lasts_while_the_rotor_is_fast_whatever_one_sensor_does)
{
    static const double fast[] = {1.0, 1.6, 3.0, 5.0, -1.0, -2.0};

    for (int32_t k = 0; k < (int32_t)KINDS; k++) {
        if (k == (int32_t)SHIFTED) {
            continue; /* half of the current turns */
        }
        for (uint32_t n = 0U; n < (sizeof fast / sizeof fast[0]); n++) {
            setUp();
            safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
            TEST_ASSERT_EQUAL_UINT32(5000U, ticks_short((sensors_t)k, fast[n], 5000U));
        }
    }
}

TEST(test_a_current_that_does_not_turn_hides_no_fast_rotor)
{
    safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
    TEST_ASSERT_EQUAL_UINT32(5000U, ticks_short(SHIFTED, 2.0, 5000U));
}

/* The last large change, a span at most behind the first tick, then the time. */
TEST(test_the_gates_open_once_the_rotor_was_slow_for_the_whole_time_and_stay_open)
{
    safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
    (void)ticks_short(HEALTHY, 1.5, 200U);
    TEST_ASSERT_TRUE(safe_state_is_short(&safe));
    TEST_ASSERT_UINT32_WITHIN(CFG.span_ticks, SETTLE + CFG.span_ticks,
                              ticks_short(HEALTHY, 0.4, 5000U));
    TEST_ASSERT_EQUAL_INT(SAFE_STATE_OPEN, safe.phase);
    TEST_ASSERT_EQUAL_UINT32(0U, ticks_short(HEALTHY, 3.0, 100U));
}

TEST(test_a_fast_span_begins_the_time_anew)
{
    safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
    for (uint32_t k = 0U; k < 20U; k++) {
        TEST_ASSERT_EQUAL_UINT32(SETTLE - 10U, ticks_short(HEALTHY, 0.1, SETTLE - 10U));
        TEST_ASSERT_EQUAL_UINT32(2U * CFG.span_ticks,
                                 ticks_short(HEALTHY, 1.5, 2U * CFG.span_ticks));
    }
}

TEST(test_a_bus_above_its_limit_shorts_the_motor)
{
    TEST_ASSERT_FALSE(step((ab_t){0, 0}, BUS_MAX));
    TEST_ASSERT_TRUE(step((ab_t){0, 0}, BUS_MAX + 1));
}

/*
 * It has no room for the energy of the windings, and with dead sensors nothing else tells of a fast
 * rotor.
 */
TEST(test_the_gates_do_not_open_while_the_bus_is_above_its_limit)
{
    uint32_t count = 0U;

    TEST_ASSERT_TRUE(step((ab_t){0, 0}, BUS_MAX + 1));
    for (int k = 0; k < 10000; k++) {
        TEST_ASSERT_TRUE(step((ab_t){5000, -3000}, BUS_MAX + 1));
    }
    while (step((ab_t){5000, -3000}, BUS_MAX) && (count < 1000U)) {
        count++;
    }
    TEST_ASSERT_EQUAL_UINT32(SETTLE, count);
    TEST_ASSERT_EQUAL_INT(SAFE_STATE_OPEN, safe.phase);
    TEST_ASSERT_TRUE(step((ab_t){5000, -3000}, BUS_MAX + 1));
}

TEST(test_what_is_broken_stays_open_until_it_is_reset)
{
    safe_state_leave(&safe, &CFG, OPEN_SPEED + 1);
    TEST_ASSERT_TRUE(step((ab_t){0, 0}, 20000));
    safe_state_break(&safe);
    TEST_ASSERT_FALSE(step((ab_t){8000, 0}, 20000));
    TEST_ASSERT_FALSE(step((ab_t){8000, 0}, 32767));
    safe_state_reset(&safe);
    TEST_ASSERT_TRUE(step((ab_t){8000, 0}, 32767));
}

/* The largest of everything: nothing overflows, the words stay within their rows. */
TEST(test_the_largest_numbers_stay_within_what_is_stated)
{
    const safe_state_cfg_t largest = {.open_speed = 0x20000000,
                                      .span_ticks = 1024U,
                                      .change_min = 32767,
                                      .settle_ticks = 0x100000U};
    safe_state_in_t in = {.current = {-16384, -28379}, .bus = 32766, .bus_max = 32766};

    safe_state_leave(&safe, &largest, 1 << 30);
    for (uint32_t k = 0U; k < 3000U; k++) {
        in.current = ((k & 1024U) == 0U) ? (ab_t){-16384, -28379} : (ab_t){16383, 28379};
        TEST_ASSERT_TRUE(safe_state_step(&safe, &largest, &in));
        TEST_ASSERT_LESS_THAN_UINT32(1024U, safe.ticks);
    }
    TEST_ASSERT_EQUAL_UINT32(952U,
                             safe.slow_ticks); /* since the change of 32767 in the 2048th tick */
    safe.slow_ticks = 0x100000U;
    in.current = safe.before;
    TEST_ASSERT_FALSE(safe_state_step(&safe, &largest, &in));
    TEST_ASSERT_FALSE(safe_state_step(&safe, &largest, &in));
    in.bus = 32767;
    TEST_ASSERT_TRUE(safe_state_step(&safe, &largest, &in));
}
