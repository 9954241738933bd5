/* SPDX-License-Identifier: MIT */
/* Plans of a rotor that does not turn: what follows from the sums of the window that has ended. */
#include "identify_rest.h"

#include "example_identify.h"
#include "testing.h"

#define SHORTED \
    "less than 3/4 of the resistance of the other phases, is the winding shorted: phase "
#define RESTLESS "the rotor does not come to rest on the current: does a load turn it?"

void setUp(void)
{
    identify_example();
    start();
}

/* ---- PULSE ---- */

/* 22576 of the bus: 88 is 1/256 of it, 5644 a quarter. */
static void begin_pulses(void)
{
    setUp();
    identify_aim_phase(&identify, IDENTIFY_PULSE);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    TEST_ASSERT_EQUAL_INT32(88, identify.rest.pulse);
    TEST_ASSERT_EQUAL_UINT32(1U, identify.step);
}

/* One round of the three axes: 64 changes of so much at their peak. */
static void answer_pulses(const dq_t *peaks)
{
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        TEST_ASSERT_EQUAL_UINT32(axis, identify.rest.axis);
        sums()->change = (dq_t){64 * peaks[axis].d, 64 * peaks[axis].q};
        const bool aims = identify_rest_plan_pulse(&identify);

        TEST_ASSERT_EQUAL(identify.phase == IDENTIFY_PULSE, aims);
        TEST_ASSERT_EQUAL_INT32(peaks[axis].d, identify.rest.peaks[axis].d);
        TEST_ASSERT_EQUAL_INT32(peaks[axis].q, identify.rest.peaks[axis].q);
    }
}

static void answer_along(int32_t a, int32_t b, int32_t c)
{
    answer_pulses((const dq_t[]){{a, 0}, {b, 0}, {c, 0}});
}

/* With 1/16 of the continuous current they become fine, with a quarter they have ended. */
static void expect_verdict(const char *why, dq_t a, dq_t b, dq_t c)
{
    begin_pulses();
    answer_along(400, 400, 400);
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(88 + 22, identify.rest.pulse);
    identify.rest.across_volts = 7;
    identify.rest.across_current = 9;
    answer_pulses((const dq_t[]){a, b, c});
    if (why == NULL) {
        TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    } else {
        assert_refused(why);
    }
}

TEST(test_a_pulse_has_no_current_and_lies_on_the_axis_of_its_phase)
{
    static const uint32_t angles[] = {0U, 0x55555555U, 0xAAAAAAAAU};

    begin_pulses();
    identify.rest.quarter = 3;
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        TEST_ASSERT_EQUAL_UINT32(angles[axis], fx_unsigned(word(PROBE_ANGLE)));
        TEST_ASSERT_EQUAL_INT32(0, word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_INT32(0x20000000, word(PROBE_RATE));
        TEST_ASSERT_EQUAL_INT32(88, word(PROBE_PULSE_D));
        TEST_ASSERT_EQUAL_INT32((axis == 0U) ? 1 : 3, word(PROBE_PULSE_TICKS));
        TEST_ASSERT_EQUAL_INT32(64 * word(PROBE_PULSE_TICKS), identify.aim.ticks);
        TEST_ASSERT_EQUAL_INT32(MS, identify.aim.settle);
        TEST_ASSERT_EQUAL_STRING("pulse", identify.aim.kind);
        identify_aim_set(&identify, PROBE_CURRENT, 5); /* of another experiment */
        (void)identify_rest_plan_pulse(&identify);
    }
    app.drive.bus = 255; /* as good as none */
    identify_aim_phase(&identify, IDENTIFY_PULSE);
    (void)identify_rest_plan_pulse(&identify);
    TEST_ASSERT_EQUAL_INT32(1, identify.rest.pulse);
}

/* 110 LSB are 22 more than 88: they have made 1000 more. What the legs lose is in both. */
TEST(test_pulses_give_the_inductance_of_what_the_last_step_has_added)
{
    expect_verdict(NULL, (dq_t){1400, 0}, (dq_t){1390, 20}, (dq_t){1380, -20});
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.inductance_q16);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.along_q16);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_current);
    expect_verdict(NULL, (dq_t){1380, 0}, (dq_t){1390, 20}, (dq_t){1400, -20});
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.inductance_q16);
}

static int32_t inductance_of(int32_t before, int32_t pulse, int32_t quarter)
{
    begin_pulses();
    identify.rest.fine = true;
    identify.rest.before = before;
    identify.rest.pulse = pulse;
    identify.rest.quarter = quarter;
    answer_along(1400, 1400, 1400);
    return identify.rest.inductance_q16;
}

TEST(test_an_inductance_saturates)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, inductance_of(1399, 5000, 64));     /* 64000 for 1 */
    TEST_ASSERT_EQUAL_INT32((88 / 5) * 65536, inductance_of(1400, 88, 1)); /* 0 counts as 1 */
}

TEST(test_pulses_grow_until_a_quarter_of_the_continuous_current_flows)
{
    begin_pulses();
    answer_along(343, 0, 300);
    TEST_ASSERT_EQUAL_INT32(176, identify.rest.pulse);
    answer_along(340, 330, 344);
    TEST_ASSERT_EQUAL_INT32(176 + 44, identify.rest.pulse);
    answer_along(1375, 1375, 1375);
    TEST_ASSERT_EQUAL_INT32(220 + 55, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(1375, identify.rest.before);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
    answer_along(1375, 1376, 1375);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    begin_pulses();
    answer_along(1400, 1400, 1400); /* a first answer gives no difference of two */
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
    TEST_ASSERT_TRUE(identify.rest.fine);
}

static int32_t pulse_after(uint32_t axis, dq_t peak)
{
    dq_t peaks[] = {{100, 0}, {100, 0}, {100, 0}};

    begin_pulses();
    peaks[axis] = peak;
    answer_pulses(peaks);
    return identify.rest.pulse;
}

/*
 * 344, 1/16 of the continuous current, wherever exchanged wires turn it: a quarter more of 88
 * follows, not twice as much.
 */
TEST(test_a_current_shows_in_any_direction_of_any_axis)
{
    static const dq_t directions[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

    for (uint32_t k = 0U; k < (4U * IDENTIFY_AXES); k++) {
        const dq_t d = directions[k % 4U];

        TEST_ASSERT_EQUAL_INT32(88 + 22, pulse_after(k / 4U, (dq_t){344 * d.d, 344 * d.q}));
        TEST_ASSERT_EQUAL_INT32(2 * 88, pulse_after(k / 4U, (dq_t){343 * d.d, 343 * d.q}));
    }
}

/* The voltage ends at a quarter of the bus, 5644; then the time grows. */
TEST(test_pulses_get_longer_once_they_are_a_quarter_of_the_bus)
{
    int32_t longest = 0;

    begin_pulses();
    for (uint32_t k = 0U; (k < 100U) && (identify.phase == IDENTIFY_PULSE); k++) {
        TEST_ASSERT_TRUE(identify.rest.pulse <= 5644);
        longest = identify.rest.quarter;
        answer_along(0, 0, 0);
    }
    TEST_ASSERT_EQUAL_INT32(64, longest);
    assert_refused("no current flows: is the motor connected?");
}

static void expect_next_pulse(int32_t pulse, int32_t peak, int32_t next, bool longer)
{
    begin_pulses();
    identify.rest.pulse = pulse;
    identify.rest.quarter = 2;
    answer_along(peak, peak, peak);
    TEST_ASSERT_EQUAL_INT32(next, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(longer ? 4 : 2, identify.rest.quarter);
    TEST_ASSERT_EQUAL((peak > 0) && !longer, identify.rest.fine);
}

/*
 * 4515 and 2822 are the last ones of which a quarter more and twice as much are a quarter of the
 * bus.
 */
TEST(test_the_next_pulse_ends_at_a_quarter_of_the_bus)
{
    TEST_ASSERT_EQUAL_INT32(5645 - 1, app.drive.bus / 4);
    expect_next_pulse(4516, 400, (4516 * 5) / 8, true);
    expect_next_pulse(4515, 400, 5643, false);
    expect_next_pulse(2823, 0, (2823 * 5) / 8, true);
    expect_next_pulse(2822, 0, 5644, false);
    app.drive.bus = 4 * 7055;
    answer_along(400, 400, 400); /* 5644 and a quarter of it */
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(7055, identify.rest.pulse);
}

/* 5644 of the voltage for one tick, then 5/8 of it for two. */
static bool lags(int32_t fast, int32_t slow)
{
    begin_pulses();
    identify.rest.pulse = 5644;
    answer_along(fast, fast, fast);
    TEST_ASSERT_TRUE(identify.rest.longer);
    answer_along(slow, slow, slow);
    return identify.rest.lag;
}

/*
 * 5/4 of the current is right, and 13/8 of it iron's most. 86 is 1/64 of the continuous current:
 * less is no answer.
 */
TEST(test_sensors_follow_late_where_a_longer_pulse_has_much_more_current)
{
    TEST_ASSERT_FALSE(lags(200, 250));
    TEST_ASSERT_FALSE(lags(200, 325));
    TEST_ASSERT_TRUE(lags(200, 326));
    TEST_ASSERT_TRUE(lags(CONTINUOUS / 64, 200));
    TEST_ASSERT_FALSE(lags((CONTINUOUS / 64) - 1, 200));
}

/* A pulse of twice the voltage has twice the current. What was found stays. */
TEST(test_only_longer_pulses_tell_whether_sensors_follow_late)
{
    begin_pulses();
    answer_along(100, 100, 100);
    TEST_ASSERT_FALSE(identify.rest.longer);
    answer_along(200, 200, 200);
    TEST_ASSERT_FALSE(identify.rest.lag);
    TEST_ASSERT_TRUE(lags(200, 326));
    answer_along(340, 340, 340);
    TEST_ASSERT_TRUE(identify.rest.lag);
}

/* It has less than 1/8 of the largest current in any direction, and turns those of the others. */
TEST(test_an_open_phase_is_named)
{
    static const char *const names[] = {"phase a is open", "phase b is open", "phase c is open"};
    static const dq_t small[] = {{174, -174}, {-174, 174}, {100, 1400 / 8}, {1400 / 8, 0}};

    cfg.speed_shift = 20U;
    cfg.current_loop.emf_q13 = 8192; /* a flux that holds a rotor whose L_q is ten times L_d */
    for (uint32_t k = 0U; k < (4U * IDENTIFY_AXES); k++) {
        dq_t peaks[] = {{1400, 800}, {1400, -800}, {1400, 800}};

        peaks[k / 4U] = small[k % 4U];
        expect_verdict(((k % 4U) < 2U) ? names[k / 4U] : NULL, peaks[0], peaks[1], peaks[2]);
    }
    expect_verdict(names[2], (dq_t){1400, 0}, (dq_t){1400, -1600}, (dq_t){199, 0});
    expect_verdict(NULL, (dq_t){1400, 0}, (dq_t){1400, -1600}, (dq_t){200, 0});
    expect_verdict(names[2], (dq_t){-1400, 2000}, (dq_t){-1400, -2000}, (dq_t){0, 0});
    expect_verdict(names[2], (dq_t){1400, 2000}, (dq_t){1400, -2000}, (dq_t){0, 0});
}

/* Means of 933 with a spread as large: no current is small enough for such a rotor. */
TEST(test_a_rotor_that_only_a_current_below_the_sensors_would_hold_is_refused)
{
    expect_verdict("L_q is so much larger than L_d that only a current holds the rotor that is too "
                   "small for this board's sensors, it takes at least ",
                   (dq_t){1400, 800}, (dq_t){1400, -800}, (dq_t){0, 800});
}

/* A salient rotor turns the current of two axes by up to 1.25/2.25: 45 degrees are straight. */
TEST(test_two_exchanged_phases_are_named)
{
    static const char *const names[] = {
        "the wires or the current sensors of phases b and c are exchanged",
        "the wires or the current sensors of phases a and c are exchanged",
        "the wires or the current sensors of phases a and b are exchanged"};

    for (uint32_t straight = 0U; straight < IDENTIFY_AXES; straight++) {
        dq_t peaks[] = {{-700, 1212}, {-700, -1212}, {-700, 1212}};

        peaks[straight] = (dq_t){1400, 0};
        expect_verdict(names[straight], peaks[0], peaks[1], peaks[2]);
    }
    expect_verdict(NULL, (dq_t){1400, 0}, (dq_t){800, 800}, (dq_t){800, -800});
    expect_verdict(NULL, (dq_t){1400, 0}, (dq_t){800, 801}, (dq_t){800, -800});
    expect_verdict(names[0], (dq_t){1400, 0}, (dq_t){800, 801}, (dq_t){800, -801});
}

/*
 * A reversed sensor of a, both reversed, wires exchanged in a circle: the current lies along none
 * of the pulses.
 */
TEST(test_three_axes_that_are_turned_are_refused)
{
    const char *const why = "a current sensor is reversed, or the wires or the sensors of all "
                            "three phases are exchanged";

    expect_verdict(why, (dq_t){-1400, -1617}, (dq_t){1400, -1617}, (dq_t){0, 808});
    expect_verdict(why, (dq_t){-1400, 0}, (dq_t){-1400, 0}, (dq_t){-1400, 0});
    expect_verdict(why, (dq_t){-700, 1212}, (dq_t){-700, 1212}, (dq_t){-700, 1212});
    expect_verdict(why, (dq_t){-700, -1212}, (dq_t){-700, -1212}, (dq_t){-700, -1212});
}

/* ---- CATCH ---- */

/*
 * A small current rises, the vector turns in two quarters, the rest of the current follows; then it
 * looks.
 */
TEST(test_the_rotor_is_caught_half_a_turn_away_and_taken_along)
{
    static const int32_t eighths[] = {1, 2, 2, 2, 3, 4, 5, 6, 7, 8, 8};
    static const uint32_t angles[11] = {0x80000000U, 0x80000000U, 0x40000000U};

    identify_aim_phase(&identify, IDENTIFY_CATCH);
    identify.rest.inductance_q16 = 1441;
    identify_aim_set(&identify, PROBE_RATE, 77);
    identify_aim_set(&identify, PROBE_SPEED, 88);
    for (uint32_t k = 0U; k < 11U; k++) {
        const bool looks = k == 10U;

        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
        TEST_ASSERT_EQUAL_INT32((CONTINUOUS * eighths[k]) / 8, word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_UINT32(angles[k], fx_unsigned(word(PROBE_ANGLE)));
        /* half a turn in 400 ms */
        TEST_ASSERT_EQUAL_INT32((k < 2U) ? 77 : (INT32_MAX / (400 * MS)), word(PROBE_RATE));
        TEST_ASSERT_EQUAL_INT32(looks ? 0 : (30 * MS), identify.aim.settle);
        TEST_ASSERT_EQUAL_INT32(looks ? (100 * MS) : MS, identify.aim.ticks);
        TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
        TEST_ASSERT_EQUAL_INT32(0, word(PROBE_SPEED));
        TEST_ASSERT_EQUAL_INT32(0x20000000, word(PROBE_RAMP));
        TEST_ASSERT_EQUAL_INT32((27 << 16) | 23056, word(PROBE_GAIN_Q)); /* soft */
    }
}

static uint32_t looks_at(int32_t across)
{
    uint32_t looks = 0U;

    identify_aim_phase(&identify, IDENTIFY_CATCH);
    sums()->across = across;
    while (identify_rest_plan_catch(&identify)) {
        looks++;
    }
    return looks;
}

TEST(test_a_rotor_at_rest_goes_on_and_one_that_never_rests_is_refused)
{
    TEST_ASSERT_EQUAL_UINT32(10U + 41U, looks_at(CONTINUOUS / 16));
    assert_refused(RESTLESS);
    TEST_ASSERT_EQUAL_UINT32(10U + 1U, looks_at((CONTINUOUS / 16) - 1));
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
    identify.turn.slower = 1U; /* it was lost, and goes on turning */
    TEST_ASSERT_EQUAL_UINT32(10U + 1U, looks_at(0));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/*
 * With half as much current again, where it is caught first. One that was lost in the experiments
 * has been tried.
 */
TEST(test_a_salient_rotor_is_tried_once)
{
    identify.rest.unlike = 500;
    identify.rest.mean = 1000;
    identify.rest.stiff_current = CONTINUOUS;
    identify.turn.slower = 1U;
    TEST_ASSERT_EQUAL_UINT32(10U + 1U, looks_at(0));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    identify.turn.slower = 0U;
    TEST_ASSERT_EQUAL_UINT32(10U + 2U, looks_at(0));
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
}

/* After a look of 100 ms at 5504 of current with this largest i_q and this mean of it. */
static bool rests(int32_t across, int32_t mean)
{
    sums()->across = across;
    sums()->current = (dq_t){0, mean * 100 * MS};
    return !identify_rest_plan_catch(&identify);
}

static void begin_to_look(void)
{
    setUp();
    identify_aim_phase(&identify, IDENTIFY_CATCH);
    identify.step = 10U;
    TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
}

static bool rests_with_noise(int32_t noise_a, int32_t noise_b, int32_t across)
{
    begin_to_look();
    sums()->noise_a = noise_a * 100 * MS;
    sums()->noise_b = noise_b * 100 * MS;
    return rests(across, 0);
}

/* 344 of 5504, and five times the mean change from sample to sample. */
TEST(test_what_noise_has_for_its_largest_sample_is_no_swing)
{
    TEST_ASSERT_TRUE(rests_with_noise(10, 3, 344 + 49));
    TEST_ASSERT_FALSE(rests_with_noise(10, 3, 344 + 50));
    TEST_ASSERT_TRUE(rests_with_noise(3, 10, 344 + 49));
    TEST_ASSERT_FALSE(rests_with_noise(3, 10, 344 + 50));
}

static void swing_often(uint32_t count, int32_t across, int32_t mean)
{
    for (uint32_t k = 0U; k < count; k++) {
        TEST_ASSERT_FALSE(rests(across, mean));
    }
}

/* The first look that has it, and 5 more. */
TEST(test_a_mean_across_is_no_swing_as_long_as_it_stays)
{
    begin_to_look();
    swing_often(5U, 1000, 800);
    TEST_ASSERT_TRUE(rests(1000, 800));
    begin_to_look();
    swing_often(5U, 1000, -800);
    TEST_ASSERT_TRUE(rests(1000, -800));
    begin_to_look(); /* 0 was there before the first look */
    swing_often(4U, 344, 1);
    TEST_ASSERT_TRUE(rests(344, 1));
    /* one that moves by 172 from the first, or a swing by 344, begins anew */
    begin_to_look();
    swing_often(4U, 1000, 800);
    swing_often(5U, 1000, 972);
    TEST_ASSERT_TRUE(rests(1000, 972));
    begin_to_look();
    swing_often(3U, 1000, 800);
    swing_often(2U, 1000, 971);
    TEST_ASSERT_TRUE(rests(970, 629));
    begin_to_look();
    swing_often(5U, 1000, 800);
    swing_often(1U, 1144, 800);
    swing_often(4U, 1000, 800);
    TEST_ASSERT_TRUE(rests(1143, 800));
}

/* ---- STILL ---- */

#define LOSS (300)
#define LEVELS (14U)
#define EXPERIMENTS (34U) /* of an axis: 14 currents, 20 bursts */

static void begin_still(void)
{
    setUp();
    identify_aim_phase(&identify, IDENTIFY_STILL);
    identify.rest.axis = 0U;
    identify.rest.along_q16 = 1441;
    identify.rest.across_q16 = 1441;
}

static void answer_still(int32_t resistance_q13)
{
    const int32_t current = word(PROBE_CURRENT);
    const int32_t voltage = LOSS + ((resistance_q13 * current) / 8192);
    const int32_t ticks = identify.aim.ticks;

    sums()->current.d = current * ticks;
    sums()->voltage.d = voltage * ticks;
}

static uint32_t stay_still(const int32_t *resistances)
{
    uint32_t experiments = 0U;

    begin_still();
    while (identify_rest_plan_still(&identify)) {
        TEST_ASSERT_TRUE(word(PROBE_CURRENT) <= 7372); /* 0.9 of 8192 */
        experiments++;
        answer_still(resistances[identify.rest.axis]);
    }
    return experiments;
}

/* Down by a factor of 10, and up again in between. The first and the fifth give R and the loss. */
TEST(test_an_axis_has_14_levels_of_current_and_the_resistance_of_two_of_them)
{
    static const int32_t shares[LEVELS] = {255, 205, 164, 131, 105, 84,  67,
                                           54,  43,  34,  27,  54,  105, 205};

    begin_still();
    for (uint32_t k = 0U; k < LEVELS; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        TEST_ASSERT_EQUAL_INT32((7372 * shares[k]) / 256, word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_STRING("still", identify.aim.kind);
        TEST_ASSERT_EQUAL_INT32(20 * MS, identify.aim.settle);
        TEST_ASSERT_EQUAL_INT32(40 * MS, identify.aim.ticks);
        answer_still(((k == 0U) || (k == 4U)) ? 1547 : 9999);
    }
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_STRING("burst", identify.aim.kind);
    TEST_ASSERT_INT32_WITHIN(3, 1547, identify.rest.resistance_q13[0]);
    TEST_ASSERT_INT32_WITHIN(2, LOSS, identify.rest.loss);
    TEST_ASSERT_EQUAL_INT32((7372 * 255) / 256, identify.rest.high_current);
    cfg.derating.current_continuous = 3685; /* twice that is less than 0.9 of the largest */
    TEST_ASSERT_EQUAL_INT32(7370, identify_rest_largest(&identify));
}

/* R to an LSB of the voltage in 4319 of current. */
TEST(test_each_axis_gives_its_resistance_and_the_last_one_the_loss)
{
    static const int32_t alike[] = {1547, 1640, 1454};

    TEST_ASSERT_EQUAL_UINT32((IDENTIFY_AXES * EXPERIMENTS) + 2U, stay_still(alike));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        TEST_ASSERT_INT32_WITHIN(3, alike[axis], identify.rest.resistance_q13[axis]);
    }
    TEST_ASSERT_INT32_WITHIN(2, LOSS, identify.rest.loss);
}

static void answer_level(uint32_t step, int32_t voltage, int32_t current)
{
    identify.step = step;
    identify.aim.ticks = 1;
    sums()->voltage.d = voltage;
    sums()->current.d = current;
    (void)identify_rest_plan_still(&identify);
}

/* Two levels of a voltage and a current each. */
static void expect_resistance(dq_t high, dq_t low, int32_t resistance_q13, int32_t loss)
{
    begin_still();
    (void)identify_rest_plan_still(&identify);
    answer_level(1U, high.d, high.q);
    answer_level(5U, low.d, low.q);
    TEST_ASSERT_EQUAL_INT32(resistance_q13, identify.rest.resistance_q13[0]);
    TEST_ASSERT_EQUAL_INT32(loss, identify.rest.loss);
}

TEST(test_a_resistance_and_a_loss_are_between_nothing_and_their_largest)
{
    expect_resistance((dq_t){1000, 5000}, (dq_t){1001, 2500}, 0, 1001);          /* falls */
    expect_resistance((dq_t){1000, 5000}, (dq_t){1000 - 4, 5000 - 1}, 32767, 0); /* 32768 */
    /* 32764·2500/8192: 9998.8 */
    expect_resistance((dq_t){20000, 5000}, (dq_t){10001, 2500}, 32764, 10001 - 9998);
    /* no current between them counts as 1 */
    expect_resistance((dq_t){1000, 2500}, (dq_t){999, 2500}, 8192, 0);
}

static identify_phase_t phase_of(int32_t first, int32_t second)
{
    begin_still();
    identify.rest.axis = IDENTIFY_AXES - 1U;
    identify.rest.resistance_q13[0] = first;
    identify.rest.resistance_q13[1] = second;
    identify.rest.resistance_q13[2] = first;
    identify.step = EXPERIMENTS;
    (void)identify_rest_plan_still(&identify);
    return identify.phase;
}

/* Phases differ by twice as much as axes. A quarter and an LSB, all of a small one, are alike. */
TEST(test_phases_whose_resistances_differ_by_more_than_a_quarter_are_refused)
{
    const char *const bad_contact =
        "more than 5/4 of the resistance of the other phases, is a contact bad: phase ";
    static const int32_t unlike[][IDENTIFY_AXES] = {
        {1547, 1945, 1547}, {1547, 1547, 1945}, {1547, 1150, 1547}, {1547, 1547, 1150}};
    static const char *const phases[] = {"b", "c", "b", "c"};

    for (uint32_t k = 0U; k < 4U; k++) {
        (void)stay_still(unlike[k]);
        assert_refused((k < 2U) ? bad_contact : SHORTED);
        TEST_ASSERT_EQUAL_STRING(phases[k], identify.detail);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_of(1000, 1120)); /* 960 and 1200 */
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_of(1000, 1121));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_of(1004, 1125)); /* 964 and 1206 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, phase_of(3, 2));
}

/* Of counts at mid-scale, which are 8 LSB each, the zeros leave these currents. */
static void carry(int32_t a, int32_t b)
{
    app.in.adc_ia = 2048U;
    app.in.adc_ib = 2048U;
    app.drive.sensors.offset_a = (2048 * 8) - a;
    app.drive.sensors.offset_b = (2048 * 8) - b;
}

/* The axes have been measured, with this share of their voltages moving. */
static void leave_still(const int32_t *resistances, int32_t unsteady)
{
    begin_still();
    carry(4000, -2000);
    identify.rest.axis = IDENTIFY_AXES - 1U;
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        identify.rest.resistance_q13[axis] = resistances[axis];
    }
    identify.rest.unsteady = unsteady;
    identify.step = EXPERIMENTS;
    (void)identify_rest_plan_still(&identify);
}

/*
 * A phase of 640 or 280 beside two of 1000: 33/256 explain 515. Up to 32 they are a winding that
 * gets warm.
 */
TEST(test_a_rotor_that_moves_is_the_reason_only_as_far_as_its_motion_explains)
{
    static const int32_t unlike[IDENTIFY_AXES] = {940, 940, 760};
    static const int32_t far_off[IDENTIFY_AXES] = {880, 880, 520};

    leave_still(unlike, 33);
    assert_refused("the rotor swings too slowly for this current: take inertia off, or allow more "
                   "continuous current");
    leave_still(unlike, 32);
    assert_refused(SHORTED);
    leave_still(far_off, 33);
    assert_refused(SHORTED);
}

/* R is 2000/8192: at a current of 4000 a level takes 976. */
TEST(test_a_level_that_comes_again_with_another_voltage_shows_that_the_rotor_moves)
{
    begin_still();
    (void)identify_rest_plan_still(&identify);
    identify.rest.resistance_q13[0] = 2000;
    answer_level(5U, 976, 4000);
    identify.rest.resistance_q13[0] = 2000;
    answer_level(13U, 976 + 122, 4000);
    TEST_ASSERT_EQUAL_INT32((122 * 256) / 976, identify.rest.unsteady);
    identify.rest.resistance_q13[0] = 2000;
    answer_level(13U, 976 - 61, 4000); /* what was found stays */
    TEST_ASSERT_EQUAL_INT32(32, identify.rest.unsteady);
    answer_level(13U, 5000, 4000);
    TEST_ASSERT_EQUAL_INT32(256, identify.rest.unsteady);
}

static void expect_look(int32_t settle)
{
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
    TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(settle, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(100 * MS, identify.aim.ticks);
}

/* The rotor swings there for so many looks. */
static void come_to_next_axis(uint32_t looks)
{
    begin_still();
    identify.step = EXPERIMENTS;
    expect_look(100 * MS);
    TEST_ASSERT_EQUAL_UINT32(1U, identify.rest.looks);
    sums()->across = CONTINUOUS;
    for (uint32_t k = 0U; k < looks; k++) {
        expect_look(0);
    }
}

/* It follows with the continuous current; 4 s of looks. */
TEST(test_a_rotor_that_never_rests_on_the_next_axis_is_refused)
{
    come_to_next_axis(0U);
    TEST_ASSERT_EQUAL_UINT32(1U, identify.rest.axis);
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_UINT32(0x55555555U, fx_unsigned(word(PROBE_ANGLE)));
    sums()->across = 0;
    sums()->voltage.d = 12345; /* of the way: no level */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.high_voltage);
    come_to_next_axis(39U);
    sums()->across = 0; /* it rests */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_STRING("still", identify.aim.kind);
    TEST_ASSERT_EQUAL_UINT32(0U, identify.rest.looks);
    come_to_next_axis(40U);
    TEST_ASSERT_FALSE(identify_rest_plan_still(&identify));
    assert_refused(RESTLESS);
}

static void first_level(int32_t current)
{
    begin_still();
    (void)identify_rest_plan_still(&identify);
    TEST_ASSERT_EQUAL_INT32(7343, word(PROBE_CURRENT));
    carry(7343, -3671);
    sums()->current.d = current * identify.aim.ticks;
    TEST_ASSERT_EQUAL(identify_rest_plan_still(&identify), current >= 6425);
}

static const char *refusal_at_rest(uint32_t axis, int32_t a, int32_t b)
{
    setUp();
    identify_aim_current(&identify, 8000);
    identify.rest.axis = axis;
    carry(a, b);
    identify_rest_refuse(&identify, "of this");
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    return identify.why;
}

/*
 * Nothing flows along its axis, less than 1/8 of what was asked for; along another one it has less
 * than 1/8 of the largest.
 */
TEST(test_a_phase_that_opens_under_a_current_is_the_reason)
{
    TEST_ASSERT_EQUAL_STRING("phase a is open", refusal_at_rest(0U, 999, -500));
    TEST_ASSERT_EQUAL_STRING("of this", refusal_at_rest(0U, 1000, -500));
    TEST_ASSERT_EQUAL_STRING("phase b is open", refusal_at_rest(1U, 0, -999));
    TEST_ASSERT_EQUAL_STRING("phase c is open", refusal_at_rest(2U, -500, -499));
    TEST_ASSERT_EQUAL_STRING("phase a is open", refusal_at_rest(1U, 999, 7999));
    TEST_ASSERT_EQUAL_STRING("phase b is open", refusal_at_rest(0U, 7999, -998));
    TEST_ASSERT_EQUAL_STRING("phase c is open", refusal_at_rest(0U, 7500, -6570));
    TEST_ASSERT_EQUAL_STRING("of this", refusal_at_rest(0U, 7000, -6000));
    TEST_ASSERT_EQUAL_STRING("of this", refusal_at_rest(0U, 8000, -4000));
}

/* 7/8 of the largest: the voltage regulates the rest of it no more. */
TEST(test_a_bus_that_is_too_low_for_the_current_is_refused)
{
    first_level(6425);
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
    first_level(6424);
    assert_refused("the bus voltage is too low for the current");
}

/* 3000 of 65536·10: a burst of 3/16 of 1600 has 3000 volts for a tick. */
static void begin_bursts(void)
{
    begin_still();
    cfg.derating.current_continuous = 1600;
    identify.rest.along_q16 = 10 * 65536;
    identify.rest.across_q16 = 65536;
    identify.step = LEVELS;
    identify_aim_window(&identify, "still", 0, 1); /* the last level */
}

/* The number of a burst counts from 0. */
static void plan_burst(uint32_t burst)
{
    identify.step = LEVELS + burst;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
}

/*
 * Twice the same ten. The slow ones have half of the voltage of those before, and twice their
 * ticks.
 */
TEST(test_bursts_have_their_shares_of_current_along_and_across_another_one)
{
    static const int32_t bias[] = {800, 1600, 1600, 500, 300, 200, 200, 200, 200, 800};
    static const int32_t along[] = {3000, 6000, 3000, 4000, 2000, 0, 0, 0, 0, 0};
    static const int32_t across[] = {0, 0, 0, 0, 0, 600, 1100, 550, 1600, 1400};
    static const int32_t quarter[] = {1, 1, 2, 1, 1, 1, 1, 2, 1, 1};

    begin_bursts();
    for (uint32_t k = 0U; k < 20U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        TEST_ASSERT_EQUAL_INT32(bias[k % 10U], word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_INT32(along[k % 10U], word(PROBE_PULSE_D));
        TEST_ASSERT_EQUAL_INT32(across[k % 10U], word(PROBE_PULSE_Q));
        TEST_ASSERT_EQUAL_INT32(quarter[k % 10U], word(PROBE_PULSE_TICKS));
        TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
        TEST_ASSERT_EQUAL_INT32(20 * MS, identify.aim.settle);
        TEST_ASSERT_EQUAL_STRING("burst", identify.aim.kind);
    }
    (void)identify_rest_plan_still(&identify);
    TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
}

static int32_t bias_of(uint32_t burst, int32_t current_max)
{
    begin_bursts();
    cfg.derating.current_max = current_max;
    plan_burst(burst);
    return word(PROBE_CURRENT);
}

/* Along it both add up, 600 of the pulses with it: 7/8 of 9/10 of the largest one are the end. */
TEST(test_a_current_with_its_pulses_stays_below_the_largest)
{
    TEST_ASSERT_EQUAL_INT32(1600, bias_of(1U, 2795)); /* 2515 and 2200 */
    TEST_ASSERT_EQUAL_INT32(1599, bias_of(1U, 2794));
    TEST_ASSERT_EQUAL_INT32(975, bias_of(1U, 2000)); /* 1800 and 1575 */
    TEST_ASSERT_EQUAL_INT32(1, bias_of(1U, 764));    /* 687 and 601 */
    TEST_ASSERT_EQUAL_INT32(0, bias_of(1U, 600));
    TEST_ASSERT_EQUAL_INT32(200, bias_of(5U, 600));
}

TEST(test_pulses_on_a_current_take_the_inductance_of_those_before)
{
    begin_bursts();
    plan_burst(0U);
    sums()->change = (dq_t){256 * 600, 256 * 7}; /* twice as much as was planned */
    plan_burst(1U);
    TEST_ASSERT_EQUAL_INT32(5 * 65536, identify.rest.along_q16);
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_current); /* it was no pulse across */
}

static void answer_across(int32_t current, int32_t inductance_q16, int32_t next_volts)
{
    sums()->change = (dq_t){7, 256 * current};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(inductance_q16, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(next_volts, word(PROBE_PULSE_Q));
}

/*
 * Volts of the pulses before, and L for what is more. The first ones say nothing of L: the legs may
 * take most of their volts.
 */
TEST(test_pulses_across_take_the_volts_of_those_before_and_the_inductance_of_the_change)
{
    begin_bursts();
    plan_burst(5U);
    TEST_ASSERT_EQUAL_INT32(600, word(PROBE_PULSE_Q));
    answer_across(300, 65536, 600 + (1100 - 300));
    answer_across(700, 2 * 65536, 1400 / 2); /* 800 volts for 400; the slow ones say nothing of L */
    answer_across(1, 2 * 65536, 1400 + (2 * (1600 - 700)));
    answer_across(1600, 2 * 65536, 3200 - (2 * (1600 - 1400))); /* 1800 for 900 */
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
}

/* 600·109 and 1600·40 are just below another volt. No pulse rather than one the other way. */
TEST(test_the_volts_of_pulses_are_rounded_down_and_end_at_none)
{
    begin_bursts();
    identify.rest.along_q16 = (10 * 65536) + 109;
    identify.rest.across_q16 = (5 * 65536) + 40;
    plan_burst(1U);
    TEST_ASSERT_EQUAL_INT32(6000, word(PROBE_PULSE_D));
    plan_burst(8U);
    TEST_ASSERT_EQUAL_INT32(8000, word(PROBE_PULSE_Q));
    identify.rest.across_volts = 100;
    identify.rest.across_current = 30000;
    plan_burst(5U);
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(1, word(PROBE_PULSE_TICKS));
}

/* Its pulses have had that peak for so many ticks of each quarter. */
static void note_burst(int32_t ticks, int32_t quarter, dq_t pulse, dq_t change)
{
    identify.aim.ticks = ticks;
    identify_aim_set(&identify, PROBE_PULSE_D, pulse.d);
    identify_aim_set(&identify, PROBE_PULSE_Q, pulse.q);
    identify_aim_set(&identify, PROBE_PULSE_TICKS, quarter);
    sums()->change = change;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
}

/* Those across follow 1000 volts for a current of `before`. */
static void burst_after(int32_t before, dq_t pulse, dq_t change)
{
    begin_bursts();
    identify.rest.inductance_q16 = 65537;
    identify.rest.across_volts = 1000;
    identify.rest.across_current = before;
    identify.step = LEVELS + 1U;
    note_burst(256, 1, pulse, change);
}

/* The last level is no burst. */
TEST(test_pulses_without_an_answer_and_what_follows_the_last_level_keep_the_inductance)
{
    burst_after(0, (dq_t){100, 0}, (dq_t){0, 0});
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
    burst_after(1, (dq_t){0, 100}, (dq_t){0, 0});
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
    begin_bursts();
    note_burst(256, 1, (dq_t){100, 0}, (dq_t){1, 1});
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
}

TEST(test_an_inductance_of_pulses_is_from_1_to_its_largest)
{
    burst_after(0, (dq_t){8000, 0}, (dq_t){1, 0});
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, identify.rest.along_q16);
    burst_after(0, (dq_t){1, 0}, (dq_t){512, 0});
    TEST_ASSERT_EQUAL_INT32(32768, identify.rest.along_q16);
    burst_after(1, (dq_t){0, 33768}, (dq_t){0, 2 * 256}); /* 32768 for 1: 2^31 */
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, identify.rest.across_q16);
    burst_after(1, (dq_t){0, 33767}, (dq_t){0, 2 * 256});
    TEST_ASSERT_EQUAL_INT32(32767 * 65536, identify.rest.across_q16);
}

static void expect_across(int32_t before, int32_t volts, int32_t current, int32_t inductance_q16)
{
    burst_after(before, (dq_t){0, volts}, (dq_t){0, 256 * current});
    TEST_ASSERT_EQUAL_INT32(inductance_q16, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(volts, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(current, identify.rest.across_current);
}

/* By more than 1/8 of 800, up or down. */
TEST(test_pulses_across_of_about_the_same_current_keep_the_inductance)
{
    begin_bursts();
    identify.step = LEVELS + 1U;
    note_burst(252, 3, (dq_t){0, 700}, (dq_t){0, (252 * 200) + 251}); /* in each of 3 ticks */
    TEST_ASSERT_EQUAL_INT32(3 * 700, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(3 * 200, identify.rest.across_current);
    expect_across(700, 1300, 800, 65536);
    expect_across(699, 1303, 800, 3 * 65536);
    expect_across(900, 700, 800, 65536);
    expect_across(901, 697, 800, 3 * 65536);
    expect_across(0, 3400, 800, 65536); /* none before */
    expect_across(0, 1, 800, 65536);
    burst_after(0, (dq_t){0, 5}, (dq_t){0, 1}); /* the least change that is one */
    TEST_ASSERT_EQUAL_INT32(5, identify.rest.across_volts);
    /* half of what the first pulses have shown, 65537, at least: the legs may hide what is more */
    expect_across(400, 1200, 800, 32768);
    expect_across(400, 1201, 800, (201 * 65536) / 400);
    expect_across(400, 1199, 800, 32768);
    expect_across(400, 900, 800, 32768);
}

/* For 1600 across. */
static void expect_pulses(int32_t across_q16, int32_t quarter, int32_t volts, int32_t ticks)
{
    begin_bursts();
    identify.rest.across_q16 = across_q16;
    plan_burst(8U);
    TEST_ASSERT_EQUAL_INT32(quarter, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(volts, word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(ticks, identify.aim.ticks);
}

/* 8466 in a tick, 3/8 of the bus: 64000 need 8, 80000 need 10, of which 256 have 6 patterns. */
TEST(test_long_pulses_share_their_volts)
{
    expect_pulses(65536 * 40, 8, 64000 / 8, 256);
    expect_pulses(65536 * 50, 10, 80000 / 10, 240);
    expect_pulses(INT32_MAX, 64, (app.drive.bus * 3) / 8, 256);
    app.drive.bus = 2;
    plan_burst(0U);
    TEST_ASSERT_EQUAL_INT32(64, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(1, word(PROBE_PULSE_D));
}
