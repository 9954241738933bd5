/* SPDX-License-Identifier: MIT */
/* Plans of a rotor that does not turn: what follows from the sums of the window that has ended. */
#include "identify_rest.h"

#include "example_identify.h"
#include "testing.h"

void setUp(void)
{
    identify_example();
}

/* ---- PULSE ---- */

/* 22576 of the bus: 88 is 1/256 of it, 5644 a quarter. */
static void begin_pulses(void)
{
    begin_phase(IDENTIFY_PULSE);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    TEST_ASSERT_EQUAL_UINT32(1U, identify.step);
}

/* One round of the three axes: 64 changes of so much at their peak. */
static void answer_pulses(const dq_t *peaks)
{
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        bool aims;

        TEST_ASSERT_EQUAL_UINT32(axis, identify.rest.axis);
        sums()->change = (dq_t){64 * peaks[axis].d, 64 * peaks[axis].q};
        aims = identify_rest_plan_pulse(&identify);
        TEST_ASSERT_EQUAL(identify.phase == IDENTIFY_PULSE, aims);
        TEST_ASSERT_EQUAL_INT32(peaks[axis].d, identify.rest.peaks[axis].d);
        TEST_ASSERT_EQUAL_INT32(peaks[axis].q, identify.rest.peaks[axis].q);
    }
}

/* With 1/16 of the continuous current it becomes fine, with a quarter it has ended. */
static void answer_to_the_end(const dq_t *peaks)
{
    static const dq_t some[] = {{400, 0}, {400, 0}, {400, 0}};

    setUp();
    begin_pulses();
    answer_pulses(some);
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(88 + 22, identify.rest.pulse);
    answer_pulses(peaks);
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
        *identify_aim_word(&identify, PROBE_CURRENT) = 5; /* of another experiment */
        (void)identify_rest_plan_pulse(&identify);
    }
}

TEST(test_without_a_bus_the_first_pulse_is_1)
{
    begin_phase(IDENTIFY_PULSE);
    app.drive.signals.bus = 255;
    (void)identify_rest_plan_pulse(&identify);
    TEST_ASSERT_EQUAL_INT32(1, identify.rest.pulse);
}

/* 110 LSB are 22 more than 88: they have made 1000 more. What the legs lose is in both. */
TEST(test_pulses_give_the_inductance_of_what_the_last_step_has_added)
{
    static const dq_t first[] = {{1400, 0}, {1390, 20}, {1380, -20}};
    static const dq_t last[] = {{1380, 0}, {1390, 20}, {1400, -20}};

    answer_to_the_end(first);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.inductance_q16);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.along_q16);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.across_q16);
    answer_to_the_end(last);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.inductance_q16);
}

/* Those across have no pulses before them then. */
TEST(test_pulses_that_have_ended_leave_none_across)
{
    static const dq_t peaks[] = {{1400, 0}, {1400, 0}, {1400, 0}};

    begin_pulses();
    identify.rest.fine = true;
    identify.rest.across_volts = 7;
    identify.rest.across_current = 9;
    answer_pulses(peaks);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_current);
}

TEST(test_an_inductance_saturates)
{
    static const dq_t peaks[] = {{1400, 0}, {1400, 0}, {1400, 0}};

    begin_pulses();
    identify.rest.fine = true;
    identify.rest.before = 1399;
    identify.rest.pulse = 5000;
    identify.rest.quarter = 64; /* 64000 for 1 */
    answer_pulses(peaks);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, identify.rest.inductance_q16);
    setUp();
    begin_pulses();
    identify.rest.fine = true;
    identify.rest.before = 1400; /* no more: counts as 1 */
    answer_pulses(peaks);
    TEST_ASSERT_EQUAL_INT32((88 / 5) * 65536, identify.rest.inductance_q16);
}

TEST(test_pulses_grow_until_a_quarter_of_the_continuous_current_flows)
{
    static const dq_t little[] = {{343, 0}, {0, 0}, {300, 0}};
    static const dq_t some[] = {{340, 0}, {330, 0}, {344, 0}};
    static const dq_t more[] = {{1375, 0}, {1375, 0}, {1375, 0}};
    static const dq_t enough[] = {{1375, 0}, {1376, 0}, {1375, 0}};

    begin_pulses();
    TEST_ASSERT_EQUAL_INT32(88, identify.rest.pulse);
    answer_pulses(little);
    TEST_ASSERT_EQUAL_INT32(176, identify.rest.pulse);
    answer_pulses(some);
    TEST_ASSERT_EQUAL_INT32(176 + 44, identify.rest.pulse);
    answer_pulses(more);
    TEST_ASSERT_EQUAL_INT32(220 + 55, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(1375, identify.rest.before);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
    answer_pulses(enough);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
}

static void expect_next_pulse(uint32_t axis, dq_t peak, int32_t pulse)
{
    dq_t peaks[] = {{100, 0}, {100, 0}, {100, 0}};

    setUp();
    begin_pulses();
    peaks[axis] = peak;
    answer_pulses(peaks);
    TEST_ASSERT_EQUAL_INT32(pulse, identify.rest.pulse);
}

/* 344, 1/16 of the continuous current, wherever exchanged wires turn it: a quarter more of 88 follows, not twice as much. */
TEST(test_a_current_shows_in_any_direction_of_any_axis)
{
    static const dq_t directions[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        for (uint32_t k = 0U; k < 4U; k++) {
            const dq_t d = directions[k];

            expect_next_pulse(axis, (dq_t){344 * d.d, 344 * d.q}, 88 + 22);
            expect_next_pulse(axis, (dq_t){343 * d.d, 343 * d.q}, 2 * 88);
        }
    }
}

/* A first answer gives no difference of two. */
TEST(test_a_large_answer_to_coarse_pulses_is_not_the_end)
{
    static const dq_t peaks[] = {{1400, 0}, {1400, 0}, {1400, 0}};

    begin_pulses();
    answer_pulses(peaks);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
    TEST_ASSERT_TRUE(identify.rest.fine);
}

/* The voltage ends at a quarter of the bus, 5644; then the time grows. */
TEST(test_pulses_get_longer_once_they_are_a_quarter_of_the_bus)
{
    static const dq_t none[IDENTIFY_AXES];
    int32_t longest = 0;

    begin_pulses();
    for (uint32_t k = 0U; (k < 100U) && (identify.phase == IDENTIFY_PULSE); k++) {
        TEST_ASSERT_TRUE(identify.rest.pulse <= 5644);
        longest = identify.rest.quarter;
        answer_pulses(none);
    }
    TEST_ASSERT_EQUAL_INT32(64, longest);
    assert_refused("no current flows: is the motor connected?");
}

static void pulses_after(int32_t pulse, int32_t peak)
{
    const dq_t peaks[] = {{peak, 0}, {peak, 0}, {peak, 0}};

    setUp();
    begin_pulses();
    identify.rest.pulse = pulse;
    identify.rest.quarter = 2;
    answer_pulses(peaks);
}

/* 4515 and 2822 are the last ones of which a quarter more and twice as much are a quarter of the bus. */
TEST(test_the_next_pulse_ends_at_a_quarter_of_the_bus)
{
    pulses_after(4516, 400);
    TEST_ASSERT_EQUAL_INT32(5645 - 1, app.drive.signals.bus / 4);
    TEST_ASSERT_FALSE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32((4516 * 5) / 8, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(4, identify.rest.quarter);
    pulses_after(4515, 400);
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(5643, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(2, identify.rest.quarter);
    pulses_after(2823, 0);
    TEST_ASSERT_EQUAL_INT32((2823 * 5) / 8, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(4, identify.rest.quarter);
    pulses_after(2822, 0);
    TEST_ASSERT_EQUAL_INT32(5644, identify.rest.pulse);
    TEST_ASSERT_EQUAL_INT32(2, identify.rest.quarter);
    app.drive.signals.bus = 4 * 7055;
    answer_pulses((const dq_t[]){{400, 0}, {400, 0}, {400, 0}}); /* 5644 and a quarter of it */
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(7055, identify.rest.pulse);
}

TEST(test_an_open_phase_is_named)
{
    static const char *const names[] = {"phase a is open", "phase b is open", "phase c is open"};

    for (uint32_t open = 0U; open < IDENTIFY_AXES; open++) {
        dq_t peaks[] = {{1400, 800}, {1400, -800}, {1400, 800}};

        peaks[open] = (dq_t){174, -174}; /* 1/8 is 175 */
        answer_to_the_end(peaks);
        assert_refused(names[open]);
        peaks[open] = (dq_t){-174, 174};
        answer_to_the_end(peaks);
        assert_refused(names[open]);
        peaks[open] = (dq_t){0, 1400 / 8};
        answer_to_the_end(peaks);
        TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
        peaks[open] = (dq_t){1400 / 8, 0};
        answer_to_the_end(peaks);
        TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    }
}

/* 1/8 of the largest one, along a pulse or not. */
TEST(test_the_current_of_an_open_phase_is_small_beside_any_other)
{
    answer_to_the_end((const dq_t[]){{1400, 0}, {1400, -1600}, {199, 0}});
    assert_refused("phase c is open");
    answer_to_the_end((const dq_t[]){{1400, 0}, {1400, -1600}, {200, 0}});
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
}

TEST(test_an_open_phase_is_named_before_two_that_are_exchanged)
{
    answer_to_the_end((const dq_t[]){{-1400, 2000}, {-1400, -2000}, {0, 0}});
    assert_refused("phase c is open");
    answer_to_the_end((const dq_t[]){{1400, 2000}, {1400, -2000}, {0, 0}});
    assert_refused("phase c is open");
}

TEST(test_two_exchanged_phases_are_named)
{
    static const char *const names[] = {
        "the wires or the current sensors of phases b and c are exchanged",
        "the wires or the current sensors of phases a and c are exchanged",
        "the wires or the current sensors of phases a and b are exchanged"};

    for (uint32_t straight = 0U; straight < IDENTIFY_AXES; straight++) {
        dq_t peaks[] = {{-700, 1212}, {-700, -1212}, {-700, 1212}};

        peaks[straight] = (dq_t){1400, 0};
        answer_to_the_end(peaks);
        assert_refused(names[straight]);
    }
}

/* A reversed sensor of a, both reversed, wires exchanged in a circle: the current lies along none of the pulses. */
TEST(test_three_axes_that_are_turned_are_refused)
{
    static const dq_t answers[][IDENTIFY_AXES] = {{{-1400, -1617}, {1400, -1617}, {0, 808}},
                                                  {{-1400, 0}, {-1400, 0}, {-1400, 0}},
                                                  {{-700, 1212}, {-700, 1212}, {-700, 1212}},
                                                  {{-700, -1212}, {-700, -1212}, {-700, -1212}}};

    for (uint32_t k = 0U; k < 4U; k++) {
        answer_to_the_end(answers[k]);
        assert_refused("a current sensor is reversed, or the wires or the sensors of all three "
                       "phases are exchanged");
    }
}

/* A salient rotor turns the current of two axes by up to 1.25/2.25. */
TEST(test_a_current_that_is_turned_by_less_than_45_degrees_is_straight)
{
    static const dq_t turned[] = {{1400, 0}, {800, 800}, {800, -800}};
    static const dq_t one[] = {{1400, 0}, {800, 801}, {800, -800}};
    static const dq_t two[] = {{1400, 0}, {800, 801}, {800, -801}};

    answer_to_the_end(turned);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    answer_to_the_end(one);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    answer_to_the_end(two);
    assert_refused("the wires or the current sensors of phases b and c are exchanged");
}

/* ---- CATCH ---- */

/* A small current rises, the vector turns in two quarters, the rest of the current follows; then it looks. */
TEST(test_the_rotor_is_caught_half_a_turn_away_and_taken_along)
{
    static const struct {
        int32_t eighths;
        uint32_t angle;
    } moves[] = {{1, 0x80000000U}, {2, 0x80000000U}, {2, 0x40000000U}, {2, 0U}, {3, 0U}, {4, 0U},
                 {5, 0U},          {6, 0U},          {7, 0U},          {8, 0U}, {8, 0U}};

    begin_phase(IDENTIFY_CATCH);
    identify.rest.inductance_q16 = 1441;
    *identify_aim_word(&identify, PROBE_RATE) = 77;
    *identify_aim_word(&identify, PROBE_SPEED) = 88;
    for (uint32_t k = 0U; k < 11U; k++) {
        const bool looks = k == 10U;

        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
        TEST_ASSERT_EQUAL_INT32((CONTINUOUS * moves[k].eighths) / 8, word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_UINT32(moves[k].angle, fx_unsigned(word(PROBE_ANGLE)));
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

    setUp();
    begin_phase(IDENTIFY_CATCH);
    sums()->across = across;
    while (identify_rest_plan_catch(&identify)) {
        looks++;
    }
    return looks;
}

TEST(test_a_rotor_at_rest_goes_on_and_one_that_never_rests_is_refused)
{
    TEST_ASSERT_EQUAL_UINT32(10U + 41U, looks_at(CONTINUOUS / 16));
    assert_refused("the rotor does not come to rest on the current: does a load turn it?");
    TEST_ASSERT_EQUAL_UINT32(10U + 1U, looks_at((CONTINUOUS / 16) - 1));
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
}

TEST(test_a_rotor_that_was_lost_goes_on_turning)
{
    begin_phase(IDENTIFY_CATCH);
    identify.turn.slower = 1U;
    while (identify_rest_plan_catch(&identify)) {
        TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* A look of 100 ms at 5504 of current: the largest i_q and its mean. */
static bool look(int32_t across, int32_t mean)
{
    sums()->across = across;
    sums()->current = (dq_t){0, mean * 100 * MS};
    return identify_rest_plan_catch(&identify);
}

static void begin_to_look(void)
{
    setUp();
    begin_phase(IDENTIFY_CATCH);
    identify.step = 10U;
    TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
}

static void look_with(int32_t noise_a, int32_t noise_b, int32_t across, bool rests)
{
    begin_to_look();
    sums()->noise_a = noise_a * 100 * MS;
    sums()->noise_b = noise_b * 100 * MS;
    TEST_ASSERT_EQUAL(!rests, look(across, 0));
}

/* 344 of 5504, and five times the mean change from sample to sample. */
TEST(test_what_noise_has_for_its_largest_sample_is_no_swing)
{
    look_with(10, 3, 344 + 49, true);
    look_with(10, 3, 344 + 50, false);
    look_with(3, 10, 344 + 49, true);
    look_with(3, 10, 344 + 50, false);
}

static void look_often(uint32_t count, int32_t across, int32_t mean)
{
    for (uint32_t k = 0U; k < count; k++) {
        TEST_ASSERT_TRUE(look(across, mean));
    }
}

/* The first look that has it, and 5 more. */
TEST(test_a_mean_across_that_stays_is_no_swing)
{
    begin_to_look();
    look_often(5U, 1000, 800);
    TEST_ASSERT_FALSE(look(1000, 800));
    begin_to_look();
    look_often(5U, 1000, -800);
    TEST_ASSERT_FALSE(look(1000, -800));
    begin_to_look(); /* 0 was there before the first look */
    look_often(4U, 344, 1);
    TEST_ASSERT_FALSE(look(344, 1));
}

/* By 172 from that which the others are compared with; or it swings by 344. */
TEST(test_a_mean_across_that_moves_begins_anew)
{
    begin_to_look();
    look_often(4U, 1000, 800);
    TEST_ASSERT_TRUE(look(1000, 972));
    look_often(4U, 1000, 972);
    TEST_ASSERT_FALSE(look(1000, 972));
    begin_to_look();
    look_often(3U, 1000, 800);
    look_often(2U, 1000, 971);
    TEST_ASSERT_FALSE(look(970, 629));
    begin_to_look();
    look_often(5U, 1000, 800);
    TEST_ASSERT_TRUE(look(1144, 800));
    look_often(4U, 1000, 800);
    TEST_ASSERT_FALSE(look(1143, 800));
}

/* ---- STILL ---- */

#define LOSS (300)
#define LEVELS (14U)
#define EXPERIMENTS (30U) /* of an axis: 14 currents, 16 bursts */

static void begin_still(void)
{
    begin_phase(IDENTIFY_STILL);
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

    setUp();
    begin_still();
    while (identify_rest_plan_still(&identify)) {
        TEST_ASSERT_TRUE(word(PROBE_CURRENT) <= 7372); /* 0.9 of 8192 */
        experiments++;
        answer_still(resistances[identify.rest.axis]);
    }
    return experiments;
}

TEST(test_levels_reach_twice_the_continuous_current_or_nine_tenths_of_the_largest)
{
    TEST_ASSERT_EQUAL_INT32(7372, identify_rest_largest(&identify));
    cfg.derating.current_continuous = 3685;
    TEST_ASSERT_EQUAL_INT32(7370, identify_rest_largest(&identify));
}

/* Down by a factor of 10, and up again in between. */
TEST(test_an_axis_has_14_levels_of_current)
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
        answer_still(1547);
    }
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_STRING("burst", identify.aim.kind);
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

/* Of the first and the fifth level; the others are for the record. */
TEST(test_the_resistance_is_that_of_two_levels)
{
    begin_still();
    for (uint32_t k = 0U; k <= LEVELS; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        answer_still(((k == 0U) || (k == 4U)) ? 1547 : 9999);
    }
    TEST_ASSERT_INT32_WITHIN(3, 1547, identify.rest.resistance_q13[0]);
    TEST_ASSERT_INT32_WITHIN(2, LOSS, identify.rest.loss);
    TEST_ASSERT_EQUAL_INT32((7372 * 255) / 256, identify.rest.high_current);
}

static void two_levels(dq_t high, dq_t low)
{
    setUp();
    begin_still();
    (void)identify_rest_plan_still(&identify);
    identify.aim.ticks = 1;
    sums()->voltage.d = high.d;
    sums()->current.d = high.q;
    (void)identify_rest_plan_still(&identify);
    identify.step = 5U;
    identify.aim.ticks = 1;
    sums()->voltage.d = low.d;
    sums()->current.d = low.q;
    (void)identify_rest_plan_still(&identify);
}

TEST(test_a_resistance_and_a_loss_are_between_nothing_and_their_largest)
{
    two_levels((dq_t){1000, 5000}, (dq_t){1001, 2500}); /* falls */
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.resistance_q13[0]);
    TEST_ASSERT_EQUAL_INT32(1001, identify.rest.loss);
    two_levels((dq_t){1000, 5000}, (dq_t){1000 - 4, 5000 - 1}); /* 32768 */
    TEST_ASSERT_EQUAL_INT32(32767, identify.rest.resistance_q13[0]);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.loss);
    two_levels((dq_t){20000, 5000}, (dq_t){10001, 2500});
    TEST_ASSERT_EQUAL_INT32(32764, identify.rest.resistance_q13[0]);
    TEST_ASSERT_EQUAL_INT32(10001 - 9998, identify.rest.loss); /* 32764·2500/8192: 9998.8 */
    two_levels((dq_t){1000, 2500}, (dq_t){999, 2500}); /* no current between them counts as 1 */
    TEST_ASSERT_EQUAL_INT32(8192, identify.rest.resistance_q13[0]);
}

#define BAD_CONTACT "more than 5/4 of the resistance of the other phases, is a contact bad: phase "
#define SHORTED \
    "less than 3/4 of the resistance of the other phases, is the winding shorted: phase "

TEST(test_phases_whose_resistances_differ_by_more_than_a_quarter_are_refused)
{
    static const int32_t unlike[][IDENTIFY_AXES] = {
        {1547, 1945, 1547}, {1547, 1547, 1945}, {1547, 1150, 1547}, {1547, 1547, 1150}};
    static const int32_t alike[] = {1547, 1640, 1454};

    static const char *const phases[] = {"b", "c", "b", "c"};

    for (uint32_t k = 0U; k < 4U; k++) {
        (void)stay_still(unlike[k]);
        assert_refused((k < 2U) ? BAD_CONTACT : SHORTED);
        TEST_ASSERT_EQUAL_STRING(phases[k], identify.detail);
    }
    (void)stay_still(alike);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

static void leave_the_last_axis(int32_t first, int32_t second)
{
    setUp();
    begin_still();
    identify.rest.axis = IDENTIFY_AXES - 1U;
    identify.rest.resistance_q13[0] = first;
    identify.rest.resistance_q13[1] = second;
    identify.rest.resistance_q13[2] = first;
    identify.step = EXPERIMENTS;
    (void)identify_rest_plan_still(&identify);
}

/* Of the phases, whose own differ by twice as much as the axes: a quarter and an LSB, which is all that a small one has. */
TEST(test_resistances_may_differ_by_a_quarter_and_an_lsb)
{
    leave_the_last_axis(1000, 1120); /* 960 and 1200 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    leave_the_last_axis(1000, 1121);
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    leave_the_last_axis(1004, 1125); /* 964 and 1206 */
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    leave_the_last_axis(3, 2);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

TEST(test_between_two_axes_the_rotor_follows_with_the_continuous_current)
{
    begin_still();
    identify.step = EXPERIMENTS;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_UINT32(1U, identify.rest.axis);
    TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
    TEST_ASSERT_EQUAL_INT32(CONTINUOUS, word(PROBE_CURRENT));
    TEST_ASSERT_EQUAL_UINT32(0x55555555U, fx_unsigned(word(PROBE_ANGLE)));
    TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
    TEST_ASSERT_EQUAL_INT32(100 * MS, identify.aim.settle);
    TEST_ASSERT_EQUAL_INT32(100 * MS, identify.aim.ticks);
    TEST_ASSERT_EQUAL_UINT32(1U, identify.rest.looks);
    sums()->voltage.d = 12345; /* of the way: no level */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.high_voltage);
}

/* 4 s of looks. */
TEST(test_a_rotor_that_swings_on_the_next_axis_is_looked_at_until_it_rests)
{
    begin_still();
    identify.step = EXPERIMENTS;
    (void)identify_rest_plan_still(&identify);
    sums()->across = CONTINUOUS;
    for (uint32_t k = 0U; k < 39U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
        TEST_ASSERT_EQUAL_INT32(0, identify.aim.settle);
        TEST_ASSERT_EQUAL_INT32(100 * MS, identify.aim.ticks);
        TEST_ASSERT_EQUAL_UINT32(0U, identify.step);
    }
    sums()->across = 0;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_STRING("still", identify.aim.kind);
    TEST_ASSERT_EQUAL_UINT32(0U, identify.rest.looks);
}

TEST(test_a_rotor_that_never_rests_on_the_next_axis_is_refused)
{
    begin_still();
    identify.step = EXPERIMENTS;
    (void)identify_rest_plan_still(&identify);
    sums()->across = CONTINUOUS;
    for (uint32_t k = 0U; k < 40U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    }
    TEST_ASSERT_FALSE(identify_rest_plan_still(&identify));
    assert_refused("the rotor does not come to rest on the current: does a load turn it?");
}

static void first_level(int32_t current)
{
    setUp();
    begin_still();
    (void)identify_rest_plan_still(&identify);
    TEST_ASSERT_EQUAL_INT32(7343, word(PROBE_CURRENT));
    sums()->current.d = current * identify.aim.ticks;
    TEST_ASSERT_EQUAL(identify_rest_plan_still(&identify), current >= 6425);
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
    cfg.derating.current_continuous = 1600;
    begin_phase(IDENTIFY_STILL);
    identify.rest.along_q16 = 10 * 65536;
    identify.rest.across_q16 = 65536;
    identify.step = LEVELS;
    identify_aim_window(&identify, "still", 0, 1); /* the last level */
}

/* Twice the same eight. */
TEST(test_bursts_have_their_shares_of_current_along_and_across_another_one)
{
    static const int32_t bias[] = {800, 1600, 500, 300, 200, 200, 200, 800};
    static const int32_t along[] = {3000, 6000, 4000, 2000, 0, 0, 0, 0};
    static const int32_t across[] = {0, 0, 0, 0, 600, 1100, 1600, 1400};

    begin_bursts();
    for (uint32_t k = 0U; k < 16U; k++) {
        TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
        TEST_ASSERT_EQUAL_INT32(bias[k % 8U], word(PROBE_CURRENT));
        TEST_ASSERT_EQUAL_INT32(along[k % 8U], word(PROBE_PULSE_D));
        TEST_ASSERT_EQUAL_INT32(across[k % 8U], word(PROBE_PULSE_Q));
        TEST_ASSERT_EQUAL_INT32(1, word(PROBE_PULSE_TICKS));
        TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
        TEST_ASSERT_EQUAL_INT32(20 * MS, identify.aim.settle);
        TEST_ASSERT_EQUAL_STRING("burst", identify.aim.kind);
    }
    (void)identify_rest_plan_still(&identify);
    TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
}

static void expect_bias(uint32_t burst, int32_t current_max, int32_t bias)
{
    setUp();
    begin_bursts();
    cfg.derating.current_max = current_max;
    identify.step = LEVELS + burst;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(bias, word(PROBE_CURRENT));
}

/* Along it both add up, 600 of the pulses with it: 7/8 of 9/10 of the largest one are the end. */
TEST(test_a_current_with_its_pulses_stays_below_the_largest)
{
    expect_bias(1U, 2795, 1600); /* 2515 and 2200 */
    expect_bias(1U, 2794, 1599);
    expect_bias(1U, 2000, 975); /* 1800 and 1575 */
    expect_bias(1U, 764, 1);    /* 687 and 601 */
    expect_bias(1U, 600, 0);
    expect_bias(4U, 600, 200);
}

TEST(test_pulses_on_a_current_take_the_inductance_of_those_before)
{
    begin_bursts();
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    sums()->change = (dq_t){256 * 600, 256 * 7}; /* twice as much as was planned */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(5 * 65536, identify.rest.along_q16);
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(0, identify.rest.across_current); /* it was no pulse across */
}

/* 600·109 and 1600·40 are just below another volt. */
TEST(test_the_volts_of_pulses_are_rounded_down)
{
    begin_bursts();
    identify.rest.along_q16 = (10 * 65536) + 109;
    identify.rest.across_q16 = (5 * 65536) + 40;
    identify.step = LEVELS + 1U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(6000, word(PROBE_PULSE_D));
    identify.step = LEVELS + 6U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(8000, word(PROBE_PULSE_Q));
}

static void answer_across(int32_t current)
{
    sums()->change = (dq_t){7, 256 * current};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
}

/* Volts of the pulses before, and L for what is more. The first ones say nothing of L: the legs may take most of their volts. */
TEST(test_pulses_across_take_the_volts_of_those_before_and_the_inductance_of_the_change)
{
    begin_bursts();
    identify.step = LEVELS + 4U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(600, word(PROBE_PULSE_Q));
    answer_across(300);
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(600 + (1100 - 300), word(PROBE_PULSE_Q));
    answer_across(700); /* 800 volts for 400 */
    TEST_ASSERT_EQUAL_INT32(2 * 65536, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(1400 + (2 * (1600 - 700)), word(PROBE_PULSE_Q));
    answer_across(1600); /* 1800 for 900 */
    TEST_ASSERT_EQUAL_INT32(2 * 65536, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(3200 - (2 * (1600 - 1400)), word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
}

/* No pulse rather than one the other way. */
TEST(test_volts_of_pulses_across_end_at_none)
{
    begin_bursts();
    identify.rest.across_volts = 100;
    identify.rest.across_current = 30000;
    identify.step = LEVELS + 4U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(0, word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(1, word(PROBE_PULSE_TICKS));
}

/* The last level is no burst. */
TEST(test_what_follows_the_last_level_has_no_inductance)
{
    begin_bursts();
    *identify_aim_word(&identify, PROBE_PULSE_D) = 100;
    sums()->change = (dq_t){1, 1};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
}

TEST(test_pulses_without_an_answer_keep_the_inductance)
{
    begin_bursts();
    identify.step = LEVELS + 1U;
    identify.aim.ticks = 256;
    *identify_aim_word(&identify, PROBE_PULSE_D) = 100;
    sums()->change = (dq_t){0, 0};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(10 * 65536, identify.rest.along_q16);
    *identify_aim_word(&identify, PROBE_PULSE_D) = 0;
    *identify_aim_word(&identify, PROBE_PULSE_Q) = 100;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(65536, identify.rest.across_q16);
}

/* Those across follow 1000 volts for a current of `before`. */
static void burst_after(int32_t before, dq_t pulse, dq_t change)
{
    setUp();
    begin_bursts();
    identify.rest.inductance_q16 = 65537;
    identify.rest.across_volts = 1000;
    identify.rest.across_current = before;
    identify.step = LEVELS + 1U;
    identify.aim.ticks = 256;
    *identify_aim_word(&identify, PROBE_PULSE_D) = pulse.d;
    *identify_aim_word(&identify, PROBE_PULSE_Q) = pulse.q;
    *identify_aim_word(&identify, PROBE_PULSE_TICKS) = 1;
    sums()->change = change;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
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

static void expect_across(int32_t before, dq_t pulse, int32_t inductance_q16)
{
    burst_after(before, (dq_t){0, pulse.d}, (dq_t){0, 256 * pulse.q});
    TEST_ASSERT_EQUAL_INT32(inductance_q16, identify.rest.across_q16);
    TEST_ASSERT_EQUAL_INT32(pulse.d, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(pulse.q, identify.rest.across_current);
}

/* By more than 1/8 of 800, up or down. */
TEST(test_pulses_across_of_about_the_same_current_keep_the_inductance)
{
    expect_across(700, (dq_t){1300, 800}, 65536);
    expect_across(699, (dq_t){1303, 800}, 3 * 65536);
    expect_across(900, (dq_t){700, 800}, 65536);
    expect_across(901, (dq_t){697, 800}, 3 * 65536);
    expect_across(0, (dq_t){3400, 800}, 65536); /* none before */
    expect_across(0, (dq_t){1, 800}, 65536);
    burst_after(0, (dq_t){0, 5}, (dq_t){0, 1}); /* the least change that is one */
    TEST_ASSERT_EQUAL_INT32(5, identify.rest.across_volts);
}

/* Of that which the first pulses have shown, 65537: the volts of the legs may hide all that is more. */
TEST(test_an_inductance_across_is_half_of_that_along_at_least)
{
    expect_across(400, (dq_t){1200, 800}, 32768);
    expect_across(400, (dq_t){1201, 800}, (201 * 65536) / 400);
    expect_across(400, (dq_t){1199, 800}, 32768);
    expect_across(400, (dq_t){900, 800}, 32768);
}

/* Of a quarter of 3 ticks. The mean change of a tick is a whole number. */
TEST(test_pulses_across_add_up_over_their_quarter)
{
    burst_after(0, (dq_t){0, 0}, (dq_t){0, 0});
    identify.step = LEVELS + 1U;
    identify.aim.ticks = 252;
    *identify_aim_word(&identify, PROBE_PULSE_D) = 0;
    *identify_aim_word(&identify, PROBE_PULSE_Q) = 700;
    *identify_aim_word(&identify, PROBE_PULSE_TICKS) = 3;
    sums()->change = (dq_t){0, (252 * 200) + 251};
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(3 * 700, identify.rest.across_volts);
    TEST_ASSERT_EQUAL_INT32(3 * 200, identify.rest.across_current);
}

/* 8466 of the bus at most in a tick: 64000 need 8. */
TEST(test_long_pulses_share_their_volts)
{
    begin_bursts();
    identify.rest.across_q16 = 65536 * 40;
    identify.step = LEVELS + 6U; /* 1600 across */
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(8, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(64000 / 8, word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
    identify.rest.across_q16 = 65536 * 50; /* 80000: 10 ticks, of which 256 have 6 patterns */
    identify.step = LEVELS + 6U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(10, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(240, identify.aim.ticks);
}

TEST(test_pulses_are_at_most_64_ticks_and_three_eighths_of_the_bus)
{
    begin_bursts();
    identify.rest.across_q16 = INT32_MAX;
    identify.step = LEVELS + 6U;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(64, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32((app.drive.signals.bus * 3) / 8, word(PROBE_PULSE_Q));
    TEST_ASSERT_EQUAL_INT32(256, identify.aim.ticks);
}

TEST(test_without_a_bus_pulses_are_1)
{
    begin_bursts();
    app.drive.signals.bus = 2;
    TEST_ASSERT_TRUE(identify_rest_plan_still(&identify));
    TEST_ASSERT_EQUAL_INT32(64, word(PROBE_PULSE_TICKS));
    TEST_ASSERT_EQUAL_INT32(1, word(PROBE_PULSE_D));
}
