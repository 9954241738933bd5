/* SPDX-License-Identifier: MIT */
/*
 * The identification: its lines and words with the drive behind them; and the rules of its plans, which look at the sums of
 * the window that has ended, as they are put there by hand.
 */
#include "identify.h"

#include "commander.h"
#include "example_app.h"
#include "identify_aim.h"
#include "identify_rest.h"
#include "identify_turn.h"

#include <stdio.h>
#include <string.h>

#define CONTINUOUS (5504)  /* 6.719 A of 40 A */
#define PATIENCE (200000U) /* passes */
#define TARGET (-4321)     /* the user's, before */

static identify_t identify;
static text_t text;

void setUp(void)
{
    const drive_command_t before = {
        .target = TARGET, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};

    power_on();
    calibrate();
    command_mailbox_post(&app.mailbox, &before);
    identify_init(&identify, &app, &ABOUT);
}

void tearDown(void)
{
}

/* One pass of the background: what it says. */
static const char *pass(void)
{
    memset(&text, 0, sizeof text);
    identify_step(&identify, &text);
    return text.characters;
}

/* Passes with a tick each until it says something. */
static const char *next_line(void)
{
    const char *said = pass();

    for (uint32_t k = 0U; (k < PATIENCE) && (said[0] == '\0') && identify_is_busy(&identify); k++) {
        tick(1U);
        said = pass();
    }
    return said;
}

static void start(void)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_TRUE(identify_is_busy(&identify));
}

/* To the first phase. */
static void begin(void)
{
    start();
    (void)next_line();
    (void)next_line();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
}

static void assert_ended(void)
{
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    tick_period();
    TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
    TEST_ASSERT_EQUAL_INT32(TARGET, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, app.in.command.mode);
    TEST_ASSERT_FALSE(app.out.gate_enable);
}

/* ---- begin and end ---- */

static void test_it_is_refused_unless_the_drive_is_ready(void)
{
    power_on();
    TEST_ASSERT_EQUAL_STRING("the drive is not READY", identify_start(&identify));
    calibrate();
    fail();
    TEST_ASSERT_EQUAL_STRING("the drive is not READY", identify_start(&identify));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_STRING("", pass());
}

static void test_it_is_refused_with_a_continuous_current_in_the_noise_of_the_converter(void)
{
    cfg.derating.current_continuous = 191;
    TEST_ASSERT_EQUAL_STRING_LEN("the continuous current is below 1.2 %", identify_start(&identify),
                                 37U);
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    cfg.derating.current_continuous = 192;
    TEST_ASSERT_NULL(identify_start(&identify));
}

static void test_it_is_refused_while_it_is_under_way(void)
{
    start();
    TEST_ASSERT_EQUAL_STRING("it is under way", identify_start(&identify));
    (void)next_line();
    TEST_ASSERT_EQUAL_STRING("it is under way", identify_start(&identify));
    identify_stop(&identify);
    assert_ended();
}

static void test_it_says_its_scales_and_what_it_will_do_before_it_does_it(void)
{
    start();
    TEST_ASSERT_EQUAL_STRING("identify 1 100000000 20000000 450000000 2 11\r\n", next_line());
    TEST_ASSERT_EQUAL_STRING("pulses on each phase, the shaft rests, up to 6.718 A\r\n",
                             next_line());
}

static void test_a_stop_opens_the_gates_and_brings_the_users_command_back(void)
{
    begin();
    tick(100U);
    TEST_ASSERT_TRUE(app.out.gate_enable);
    identify_stop(&identify);
    assert_ended();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_EQUAL_STRING("", next_line());
}

static void test_a_stop_without_an_identification_leaves_the_command(void)
{
    const drive_command_t runs = {.target = 5, .request = DRIVE_REQUEST_RUN};

    command_mailbox_post(&app.mailbox, &runs);
    identify_stop(&identify);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
}

static void test_a_fault_ends_it_with_a_line(void)
{
    begin();
    fail();
    TEST_ASSERT_EQUAL_STRING("identify refused: a fault has ended it\r\n", next_line());
    assert_ended();
    TEST_ASSERT_EQUAL_STRING("", next_line());
}

static void test_it_can_be_started_again(void)
{
    begin();
    identify_stop(&identify);
    assert_ended();
    begin();
    TEST_ASSERT_EQUAL_UINT32(1U, identify.step);
}

/* Before the drive has taken it. */
static void test_a_run_that_was_asked_for_is_not_asked_for_again_at_the_end(void)
{
    (void)commander_run(&app);
    start();
    identify_stop(&identify);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

static void assert_says_of(identify_phase_t phase, const char *line)
{
    identify_aim_phase(&identify, phase);
    TEST_ASSERT_EQUAL_STRING(line, pass());
}

/* 6.71875 A, 1.8 and 3/4 of it, and half of 2000 rpm: before each phase a person knows what the shaft will do. */
static void test_each_phase_is_told_before_it_begins(void)
{
    begin();
    assert_says_of(IDENTIFY_CATCH,
                   "the shaft turns by up to one electrical turn, with 6.718 A\r\n");
    assert_says_of(IDENTIFY_STILL, "the shaft goes to three angles, up to 8.999 A\r\n");
    assert_says_of(IDENTIFY_SPIN, "the shaft turns, up to 1000 rpm, with 5.039 A\r\n");
    assert_says_of(IDENTIFY_RAMP, "between half of that speed and the whole\r\n");
    assert_says_of(IDENTIFY_COAST, "no current, the shaft coasts\r\n");
    assert_says_of(IDENTIFY_ENDS, "identify done\r\n");
    assert_ended();
}

/* ---- words and records ---- */

static bool are_equal(const drive_command_t *a, const drive_command_t *b)
{
    return (a->target == b->target) && (a->mode == b->mode) && (a->request == b->request);
}

/* Five passes a tick: what the drive has not taken is not replaced. */
static void test_a_word_is_posted_once_the_drive_has_taken_the_one_before(void)
{
    uint32_t posted = 0U;

    begin();
    for (uint32_t k = 0U; k < 20000U; k++) {
        const drive_command_t before = command_mailbox_take(&app.mailbox);
        const drive_command_t taken = app.in.command;
        drive_command_t now;

        (void)pass();
        now = command_mailbox_take(&app.mailbox);
        if (!are_equal(&before, &now)) {
            TEST_ASSERT_TRUE(are_equal(&before, &taken));
            TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_PROBE, now.request);
            TEST_ASSERT_TRUE((now.mode >= (uint8_t)PROBE_CURRENT) &&
                             (now.mode < (uint8_t)PROBE_WORDS));
            posted++;
        }
        if ((k % 5U) == 4U) {
            tick(1U);
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(20U, posted);
}

static void test_the_drive_has_all_words_of_an_experiment_when_its_window_opens(void)
{
    const probe_t *const probe = &app.drive.probe;

    begin();
    while (probe->tick == 0U) {
        (void)pass();
        tick(1U);
    }
    TEST_ASSERT_EQUAL_INT32(0, probe->current);
    TEST_ASSERT_EQUAL_INT32(0x20000000, probe->rate);
    TEST_ASSERT_EQUAL_INT32(88, probe->pulse.d); /* 1/256 of the bus */
    TEST_ASSERT_EQUAL_INT32(0, probe->pulse.q);
    TEST_ASSERT_EQUAL_INT32(1, probe->pulse_ticks);
    TEST_ASSERT_EQUAL_INT32(1, probe->emf_full);
}

static const probe_sums_t NUMBERED = {
    .voltage = {11, -12},
    .current = {13, -14},
    .bus = 15,
    .noise_a = 16,
    .noise_b = 17,
    .change = {18, -19},
    .carried = 20,
    .turn_q16 = -21,
    .across = 22,
    .torque = -23,
};

static bool is_measured(void)
{
    return (identify.wait == IDENTIFY_MEASURING) && (app.drive.probe.tick == 0U) &&
           (app.drive.probe.window == identify.in_force[IDENTIFY_WORDS - 1U]);
}

static const char *next_record(void)
{
    while (!is_measured()) {
        TEST_ASSERT_EQUAL_STRING("", pass());
        tick(1U);
    }
    app.drive.probe.sums = NUMBERED;
    return next_line();
}

static void test_a_record_has_what_was_asked_for_and_the_sums_in_their_order(void)
{
    begin();
    TEST_ASSERT_EQUAL_STRING(
        "= pulse 0 0 0 88 0 1 64 11 -12 13 -14 15 16 17 18 -19 20 -21 22 -23\r\n", next_record());
    TEST_ASSERT_EQUAL_STRING(
        "= pulse 1 0 0 88 0 1 64 11 -12 13 -14 15 16 17 18 -19 20 -21 22 -23\r\n", next_record());
}

static void test_each_window_has_a_word_of_its_own(void)
{
    int32_t before = 0;

    begin();
    for (uint32_t k = 0U; k < 10U; k++) {
        (void)next_record();
        TEST_ASSERT_NOT_EQUAL_INT32(before, app.drive.probe.window);
        before = app.drive.probe.window;
    }
}

#define SETTLE (50)
#define WINDOW (30)

/* An experiment of the test's own: all words but these are in force already. */
static void experiment(step_t speed, step_t ramp)
{
    begin();
    (void)next_record();
    *identify_aim_word(&identify, PROBE_PULSE_D) = 0;
    *identify_aim_word(&identify, PROBE_SPEED) = speed;
    *identify_aim_word(&identify, PROBE_RAMP) = ramp;
    identify_aim_window(&identify, "spin", SETTLE, WINDOW);
}

static uint32_t ticks_to(identify_wait_t wait)
{
    uint32_t count = 0U;

    while ((identify.wait != wait) && (count < 10000U)) {
        tick(1U);
        (void)pass();
        count++;
    }
    return count;
}

/* 100 ticks of the ramp. */
static void test_a_window_opens_once_the_vector_has_arrived_and_settled(void)
{
    experiment(100000, 1000);
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_SETTLING) >= 90U);
    TEST_ASSERT_EQUAL_INT32(100000, app.drive.probe.own_speed);
    TEST_ASSERT_EQUAL_UINT32((uint32_t)SETTLE, ticks_to(IDENTIFY_MEASURING));
    TEST_ASSERT_EQUAL_UINT32(0U, app.drive.probe.tick);
    tick_period();
    TEST_ASSERT_TRUE(app.drive.probe.tick > 0U);
    TEST_ASSERT_EQUAL_INT32(WINDOW, app.drive.probe.window & 0xFFFFF);
}

static void test_a_window_that_rushes_waits_for_no_vector(void)
{
    experiment(100000, 1);
    identify.aim.rushes = true;
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_EQUAL_UINT32(3U, ticks_to(IDENTIFY_SETTLING));
}

static void test_a_vector_at_rest_has_arrived_at_its_angle_only(void)
{
    experiment(0, 1);
    *identify_aim_word(&identify, PROBE_RATE) = 0x100000;
    *identify_aim_word(&identify, PROBE_ANGLE) = 0x10000000; /* 256 ticks away */
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_SETTLING) >=
                     200U); /* its last words are asked for on the way */
    TEST_ASSERT_EQUAL_UINT32(0x10000000U, rotor_position_angle(&app.drive.vector.position));
}

/* In PROBE, with a window that has ended: the plan of the first ramp down. */
static void begin_ramps_in_probe(void)
{
    begin();
    (void)next_record();
    identify_aim_phase(&identify, IDENTIFY_RAMP);
    identify.said = IDENTIFY_RAMP;
    identify.turn.top = 1000000;
    identify.turn.ramp_ticks = 100;
    (void)ticks_to(IDENTIFY_MEASURING);
    (void)next_line();
}

/* A ramp lies within its window. */
static void test_a_window_that_leads_opens_before_its_words_are_asked_for(void)
{
    begin_ramps_in_probe();
    TEST_ASSERT_EQUAL(IDENTIFY_LEADING, identify.wait);
    tick_period();
    TEST_ASSERT_TRUE(app.drive.probe.tick > 0U);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_ASKING) >= (fx_unsigned(identify.aim.settle) - 20U));
    TEST_ASSERT_NOT_EQUAL_INT32(identify.turn.top / 2, app.drive.probe.speed);
    (void)ticks_to(IDENTIFY_MEASURING);
    tick_period();
    TEST_ASSERT_EQUAL_INT32(identify.turn.top / 2, app.drive.probe.speed);
}

/* Nothing flows in the binding of memory. */
static void test_a_motor_that_is_not_there_ends_it_with_a_line_and_open_gates(void)
{
    char last[TEXT_MAX] = "";

    begin();
    for (uint32_t k = 0U; (k < 500U) && identify_is_busy(&identify); k++) {
        (void)snprintf(last, sizeof last, "%s", next_line());
    }
    TEST_ASSERT_EQUAL_STRING("identify refused: no current flows: is the motor connected?\r\n",
                             last);
    assert_ended();
}

static void noisy(int32_t noise_a, int32_t noise_b, const char *expected)
{
    setUp();
    begin();
    identify_aim_phase(&identify, IDENTIFY_CATCH);
    identify_aim_window(&identify, "catch", 0, 10);
    identify.said = IDENTIFY_CATCH;
    identify.wait = IDENTIFY_MEASURING;
    tick_period();
    identify.in_force[IDENTIFY_WORDS - 1U] = app.drive.probe.window;
    app.drive.probe.sums = (probe_sums_t){.noise_a = noise_a, .noise_b = noise_b};
    TEST_ASSERT_EQUAL_STRING_LEN("= catch", next_line(), 7U);
    TEST_ASSERT_EQUAL(expected == NULL ? IDENTIFY_CATCH : IDENTIFY_ENDS, identify.phase);
    if (expected != NULL) {
        TEST_ASSERT_EQUAL_STRING(expected, next_line());
    }
}

/* 5504/16 is 344 from sample to sample, over 10 ticks. */
static void test_sensors_that_are_too_noisy_are_refused(void)
{
    static const char *const NOISE = "identify refused: the noise of the current sensors is too "
                                     "large for the continuous current\r\n";

    noisy(3449, 3449, NULL);
    noisy(3450, 0, NOISE);
    noisy(0, 3450, NOISE);
}

/* ---- PULSE ---- */

static void assert_refused(const char *why)
{
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_EQUAL_STRING(why, identify.why);
}

static void begin_phase(identify_phase_t phase)
{
    start();
    identify_aim_phase(&identify, phase);
}

/* One round of the three axes: 64 changes of so much at their peak. */
static void answer_pulses(const dq_t *peaks)
{
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        TEST_ASSERT_EQUAL_UINT32(axis, identify.rest.axis);
        app.drive.probe.sums.change = (dq_t){64 * peaks[axis].d, 64 * peaks[axis].q};
        (void)identify_rest_plan_pulse(&identify);
    }
}

/* With 1/16 of the continuous current it becomes fine, with a quarter it has ended. */
static void answer_to_the_end(const dq_t *peaks)
{
    static const dq_t some[] = {{400, 0}, {400, 0}, {400, 0}};

    setUp();
    begin_phase(IDENTIFY_PULSE);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    answer_pulses(some);
    TEST_ASSERT_TRUE(identify.rest.fine);
    TEST_ASSERT_EQUAL_INT32(88 + 22, identify.rest.pulse);
    answer_pulses(peaks);
}

/* 110 LSB are 22 more than 88: they have made 1000 more. */
static void test_pulses_give_the_inductance_of_what_the_last_step_has_added(void)
{
    static const dq_t peaks[] = {{1400, 0}, {1390, 20}, {1380, -20}};

    answer_to_the_end(peaks);
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
    TEST_ASSERT_EQUAL_INT32((22 * 65536) / 1000, identify.rest.inductance_q16);
}

static void test_pulses_grow_until_a_quarter_of_the_continuous_current_flows(void)
{
    static const dq_t little[] = {{343, 0}, {0, 0}, {300, 0}};
    static const dq_t some[] = {{0, 0}, {0, 0}, {344, 0}};
    static const dq_t more[] = {{1375, 0}, {1375, 0}, {1375, 0}};

    begin_phase(IDENTIFY_PULSE);
    TEST_ASSERT_TRUE(identify_rest_plan_pulse(&identify));
    TEST_ASSERT_EQUAL_INT32(88, identify.rest.pulse);
    answer_pulses(little);
    TEST_ASSERT_EQUAL_INT32(176, identify.rest.pulse);
    answer_pulses(some);
    TEST_ASSERT_EQUAL_INT32(176 + 44, identify.rest.pulse);
    answer_pulses(more);
    TEST_ASSERT_EQUAL_INT32(220 + 55, identify.rest.pulse);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
}

/* The voltage ends at a quarter of the bus, 5644; then the time grows. */
static void test_pulses_get_longer_once_they_are_a_quarter_of_the_bus(void)
{
    static const dq_t none[IDENTIFY_AXES];
    int32_t longest = 0;

    begin_phase(IDENTIFY_PULSE);
    (void)identify_rest_plan_pulse(&identify);
    for (uint32_t k = 0U; (k < 100U) && (identify.phase == IDENTIFY_PULSE); k++) {
        TEST_ASSERT_TRUE(identify.rest.pulse <= 5644);
        longest = identify.rest.quarter;
        answer_pulses(none);
    }
    TEST_ASSERT_EQUAL_INT32(64, longest);
    assert_refused("no current flows: is the motor connected?");
}

static void test_an_open_phase_is_named(void)
{
    static const char *const names[] = {"phase a is open", "phase b is open", "phase c is open"};

    for (uint32_t open = 0U; open < IDENTIFY_AXES; open++) {
        dq_t peaks[] = {{1400, 800}, {1400, -800}, {1400, 800}};

        peaks[open] = (dq_t){174, -174}; /* 1/8 is 175 */
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

static void test_two_exchanged_phases_are_named(void)
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

/* ---- CATCH ---- */

/* Eight rises of the current, two quarters of a turn, then it looks. */
static void test_the_rotor_is_caught_half_a_turn_away_and_taken_along(void)
{
    begin_phase(IDENTIFY_CATCH);
    identify.rest.inductance_q16 = 1441;
    app.drive.probe.sums.across = 100000;
    for (int32_t k = 1; k <= 11; k++) {
        const uint32_t turns = (k <= 8) ? 0U : (uint32_t)(k - 8);
        const uint32_t angle = (turns >= 2U) ? 0U : (0x80000000U >> turns);

        TEST_ASSERT_TRUE(identify_rest_plan_catch(&identify));
        TEST_ASSERT_EQUAL_INT32((CONTINUOUS * ((k < 8) ? k : 8)) / 8,
                                *identify_aim_word(&identify, PROBE_CURRENT));
        TEST_ASSERT_EQUAL_UINT32(angle, fx_unsigned(*identify_aim_word(&identify, PROBE_ANGLE)));
    }
    /* half a turn in 400 ms of 10 ticks */
    TEST_ASSERT_EQUAL_INT32(INT32_MAX / 4000, *identify_aim_word(&identify, PROBE_RATE));
}

static void test_a_rotor_at_rest_goes_on_and_one_that_never_rests_is_refused(void)
{
    uint32_t looks = 0U;

    begin_phase(IDENTIFY_CATCH);
    app.drive.probe.sums.across = CONTINUOUS / 16;
    while (identify_rest_plan_catch(&identify)) {
        looks++;
    }
    TEST_ASSERT_EQUAL_UINT32(8U + 2U + 41U, looks);
    assert_refused("the rotor does not come to rest on the current: does a load turn it?");
    setUp();
    begin_phase(IDENTIFY_CATCH);
    app.drive.probe.sums.across = (CONTINUOUS / 16) - 1;
    looks = 0U;
    while (identify_rest_plan_catch(&identify)) {
        looks++;
    }
    TEST_ASSERT_EQUAL_UINT32(8U + 2U + 1U, looks);
    TEST_ASSERT_EQUAL(IDENTIFY_STILL, identify.phase);
}

/* L/8 a tick along the current as a mantissa and a shift; its integral 40 times slower, with 11 bits more. */
static void test_gains_follow_the_inductance_that_was_found(void)
{
    start();
    identify.rest.inductance_q16 = 1441;
    identify_aim_gains(&identify, false);
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, *identify_aim_word(&identify, PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32((17 << 16) | 18444, *identify_aim_word(&identify, PROBE_INTEGRAL_D));
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, *identify_aim_word(&identify, PROBE_GAIN_Q));
    TEST_ASSERT_EQUAL_INT32((17 << 16) | 18444, *identify_aim_word(&identify, PROBE_INTEGRAL_Q));
    identify_aim_gains(&identify, true);
    TEST_ASSERT_EQUAL_INT32((23 << 16) | 23056, *identify_aim_word(&identify, PROBE_GAIN_D));
    TEST_ASSERT_EQUAL_INT32(1 << 16, *identify_aim_word(&identify, PROBE_GAIN_Q));
    TEST_ASSERT_EQUAL_INT32((25 << 16) | 18444, *identify_aim_word(&identify, PROBE_INTEGRAL_Q));
}

/* ---- STILL ---- */

#define LOSS (300)

static void answer_still(int32_t resistance_q13)
{
    const int32_t current = *identify_aim_word(&identify, PROBE_CURRENT);
    const int32_t voltage = LOSS + ((resistance_q13 * current) / 8192);
    const int32_t ticks = identify.aim.ticks;
    probe_sums_t *const sums = &app.drive.probe.sums;

    sums->current.d = current * ticks;
    sums->voltage.d = voltage * ticks;
}

static uint32_t stay_still(const int32_t *resistances)
{
    uint32_t experiments = 0U;

    setUp();
    begin_phase(IDENTIFY_STILL);
    identify.rest.axis = 0U;
    identify.rest.along_q16 = 1441;
    identify.rest.across_q16 = 1441;
    while (identify_rest_plan_still(&identify)) {
        TEST_ASSERT_TRUE(*identify_aim_word(&identify, PROBE_CURRENT) <= 7372); /* 0.9 of 8192 */
        experiments++;
        answer_still(resistances[identify.rest.axis]);
    }
    return experiments;
}

/* Of each axis 14 currents and 14 bursts, and a way to the next one. R to an LSB of the voltage in 3500 of current. */
static void test_each_axis_gives_its_resistance_and_the_last_one_the_loss(void)
{
    static const int32_t alike[] = {1547, 1700, 1400};

    TEST_ASSERT_EQUAL_UINT32((3U * 28U) + 2U, stay_still(alike));
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    for (uint32_t axis = 0U; axis < IDENTIFY_AXES; axis++) {
        TEST_ASSERT_INT32_WITHIN(4, alike[axis], identify.rest.resistance_q13[axis]);
    }
    TEST_ASSERT_INT32_WITHIN(3, LOSS, identify.rest.loss);
}

static void test_phases_whose_resistances_differ_by_more_than_a_quarter_are_refused(void)
{
    static const int32_t unlike[][IDENTIFY_AXES] = {
        {1547, 1960, 1547}, {1547, 1547, 1960}, {1547, 1130, 1547}, {1547, 1547, 1130}};
    static const int32_t alike[] = {1547, 1900, 1190};

    for (uint32_t k = 0U; k < 4U; k++) {
        (void)stay_still(unlike[k]);
        assert_refused(
            "the resistances of the three phases differ: is a winding shorted, or a contact bad?");
    }
    (void)stay_still(alike);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

/* ---- SPIN ---- */

#define TOP (14316557)    /* half of 2000 rpm */
#define QUARTER (3579139) /* of that */

/* The means of the window that has ended, at so many steps a tick. */
static void answer_spin(int32_t along, int32_t across, step_t speed)
{
    const int32_t ticks = identify.aim.ticks;
    probe_sums_t *const sums = &app.drive.probe.sums;

    *sums = (probe_sums_t){.voltage = {along * ticks, across * ticks}};
    sums->current.d = *identify_aim_word(&identify, PROBE_CURRENT) * ticks;
    sums->turn_q16 = (int32_t)(((int64_t)speed * ticks) / 65536);
}

static void begin_spin(int32_t along, int32_t across)
{
    setUp();
    begin_phase(IDENTIFY_SPIN);
    identify.rest.inductance_q16 = 1441;
    identify.rest.resistance_q13[2] = 1547;
    TEST_ASSERT_TRUE(identify_turn_plan_spin(&identify));
    TEST_ASSERT_EQUAL_INT32((CONTINUOUS * 3) / 4, *identify_aim_word(&identify, PROBE_CURRENT));
    TEST_ASSERT_EQUAL_INT32(QUARTER, *identify_aim_word(&identify, PROBE_SPEED));
    answer_spin(along, across, QUARTER);
    (void)identify_turn_plan_spin(&identify);
}

/* 12/16 of 0.5485 of the bus, 9286: with 3000 across at a quarter of it 9272/3000 of that are there. */
static void test_the_highest_speed_is_that_for_which_the_bus_is_there(void)
{
    begin_spin(500, 3000);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
    TEST_ASSERT_INT32_WITHIN(QUARTER / 500, (int32_t)(QUARTER * (9272.0 / 3000.0)),
                             identify.turn.top);
    begin_spin(500, 2000);
    TEST_ASSERT_EQUAL_INT32(TOP, identify.turn.top);
}

/* 1/20 of the voltage at the highest speed: 12382/20 at 13981 is 77 at 1747; ωL·i of 4128 adds 14. */
static void test_a_rotor_that_does_not_turn_has_no_emf(void)
{
    begin_spin(500, 60);
    assert_refused("the rotor does not turn with the current: is it blocked, braked, or loaded?");
    begin_spin(500, 150);
    TEST_ASSERT_EQUAL(IDENTIFY_SPIN, identify.phase);
}

static void test_a_bus_that_is_too_low_is_refused(void)
{
    begin_spin(9200, 3000);
    assert_refused("the bus voltage is too low to turn the motor at 1/16 of its highest speed");
    begin_spin(20000, 3000);
    assert_refused("the bus voltage is too low to turn the motor at 1/16 of its highest speed");
}

/* ---- RAMP ---- */

#define ACROSS (3000) /* at a quarter of the speed */

/* A torque over what the current can pull, as a share of the flux that shows. */
static void answer_ramp(double share)
{
    const double flux = ACROSS / (QUARTER / 2048.0);
    const double current = *identify_aim_word(&identify, PROBE_CURRENT);

    answer_spin(500, (int32_t)(((double)identify.turn.top / QUARTER) * ACROSS), identify.turn.top);
    app.drive.probe.sums.torque = (int32_t)(share * flux * current * identify.turn.ramp_ticks);
}

static void begin_ramps(double share)
{
    begin_spin(500, ACROSS);
    while (identify.phase == IDENTIFY_SPIN) {
        answer_ramp(share);
        (void)identify_turn_plan_spin(&identify);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
}

/* One pair: down, hold, up, hold. */
static void pair_of_ramps(double share)
{
    for (uint32_t part = 0U; (part < 4U) && (identify.phase == IDENTIFY_RAMP); part++) {
        answer_ramp((part == 1U) ? -share : share);
        (void)identify_turn_plan_ramp(&identify);
    }
}

/* A torque of 0.15 asks for ramps of half the time, of 0.3 for no other. */
static void test_ramps_become_as_steep_as_the_torque_allows(void)
{
    int32_t first;

    begin_ramps(0.3);
    first = identify.turn.ramp_ticks;
    TEST_ASSERT_INT32_WITHIN(first / 50, 12500, first);
    pair_of_ramps(0.15);
    TEST_ASSERT_INT32_WITHIN(first / 50, first / 2, identify.turn.ramp_ticks);
    TEST_ASSERT_EQUAL_INT32(0, identify.turn.pairs_left);
    pair_of_ramps(0.3);
    TEST_ASSERT_INT32_WITHIN(first / 50, first / 2, identify.turn.ramp_ticks);
    TEST_ASSERT_TRUE((identify.turn.pairs_left >= 2) && (identify.turn.pairs_left <= 9));
}

static void test_after_its_pairs_of_ramps_the_rotor_coasts(void)
{
    int32_t left;

    begin_ramps(0.3);
    pair_of_ramps(0.3);
    left = identify.turn.pairs_left;
    for (int32_t k = 1; k < left; k++) {
        TEST_ASSERT_EQUAL(IDENTIFY_RAMP, identify.phase);
        pair_of_ramps(0.3);
    }
    TEST_ASSERT_EQUAL_INT32(1, identify.turn.pairs_left);
    pair_of_ramps(0.3);
    TEST_ASSERT_EQUAL(IDENTIFY_COAST, identify.phase);
}

static void test_a_rotor_out_of_step_is_refused(void)
{
    begin_ramps(0.3);
    pair_of_ramps(0.15);
    answer_spin(500, ACROSS / 3, QUARTER);
    (void)identify_turn_plan_ramp(&identify);
    assert_refused("the rotor has fallen out of step: does its load change?");
}

/* ---- COAST ---- */

static uint32_t coast(double fall)
{
    uint32_t windows = 0U;
    double speed = TOP;

    setUp();
    begin_phase(IDENTIFY_COAST);
    identify.turn.top = TOP;
    identify_aim_window(&identify, "ramp", 0, 400); /* the last before */
    answer_spin(0, 0, TOP);
    while (identify_turn_plan_coast(&identify) && (windows < 100U)) {
        TEST_ASSERT_EQUAL_INT32(0, *identify_aim_word(&identify, PROBE_CURRENT));
        TEST_ASSERT_TRUE(*identify_aim_word(&identify, PROBE_TRACKING) > 0);
        windows++;
        answer_spin(0, 0, (step_t)speed);
        speed *= fall;
    }
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_NULL(identify.why);
    return windows;
}

/* The second window gives the speed that halves: 0.8^4 is below a half of it. */
static void test_coasting_ends_at_half_of_the_speed_or_after_its_windows(void)
{
    TEST_ASSERT_EQUAL_UINT32(25U, coast(1.0));
    /* one electrical turn at first, 300 ticks, then two; twice as long until 80 ms are reached */
    TEST_ASSERT_EQUAL_INT32(1200, identify.turn.coast_ticks);
    TEST_ASSERT_EQUAL_UINT32(6U, coast(0.8));
    TEST_ASSERT_EQUAL_INT32(600, identify.turn.coast_ticks);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_it_is_refused_unless_the_drive_is_ready);
    RUN_TEST(test_it_is_refused_with_a_continuous_current_in_the_noise_of_the_converter);
    RUN_TEST(test_it_is_refused_while_it_is_under_way);
    RUN_TEST(test_it_says_its_scales_and_what_it_will_do_before_it_does_it);
    RUN_TEST(test_a_stop_opens_the_gates_and_brings_the_users_command_back);
    RUN_TEST(test_a_stop_without_an_identification_leaves_the_command);
    RUN_TEST(test_a_fault_ends_it_with_a_line);
    RUN_TEST(test_it_can_be_started_again);
    RUN_TEST(test_a_run_that_was_asked_for_is_not_asked_for_again_at_the_end);
    RUN_TEST(test_each_phase_is_told_before_it_begins);
    RUN_TEST(test_a_word_is_posted_once_the_drive_has_taken_the_one_before);
    RUN_TEST(test_the_drive_has_all_words_of_an_experiment_when_its_window_opens);
    RUN_TEST(test_a_record_has_what_was_asked_for_and_the_sums_in_their_order);
    RUN_TEST(test_each_window_has_a_word_of_its_own);
    RUN_TEST(test_a_window_opens_once_the_vector_has_arrived_and_settled);
    RUN_TEST(test_a_window_that_rushes_waits_for_no_vector);
    RUN_TEST(test_a_vector_at_rest_has_arrived_at_its_angle_only);
    RUN_TEST(test_a_window_that_leads_opens_before_its_words_are_asked_for);
    RUN_TEST(test_a_motor_that_is_not_there_ends_it_with_a_line_and_open_gates);
    RUN_TEST(test_sensors_that_are_too_noisy_are_refused);
    RUN_TEST(test_pulses_give_the_inductance_of_what_the_last_step_has_added);
    RUN_TEST(test_pulses_grow_until_a_quarter_of_the_continuous_current_flows);
    RUN_TEST(test_pulses_get_longer_once_they_are_a_quarter_of_the_bus);
    RUN_TEST(test_an_open_phase_is_named);
    RUN_TEST(test_two_exchanged_phases_are_named);
    RUN_TEST(test_the_rotor_is_caught_half_a_turn_away_and_taken_along);
    RUN_TEST(test_a_rotor_at_rest_goes_on_and_one_that_never_rests_is_refused);
    RUN_TEST(test_gains_follow_the_inductance_that_was_found);
    RUN_TEST(test_each_axis_gives_its_resistance_and_the_last_one_the_loss);
    RUN_TEST(test_phases_whose_resistances_differ_by_more_than_a_quarter_are_refused);
    RUN_TEST(test_the_highest_speed_is_that_for_which_the_bus_is_there);
    RUN_TEST(test_a_rotor_that_does_not_turn_has_no_emf);
    RUN_TEST(test_a_bus_that_is_too_low_is_refused);
    RUN_TEST(test_ramps_become_as_steep_as_the_torque_allows);
    RUN_TEST(test_after_its_pairs_of_ramps_the_rotor_coasts);
    RUN_TEST(test_a_rotor_out_of_step_is_refused);
    RUN_TEST(test_coasting_ends_at_half_of_the_speed_or_after_its_windows);
    return UNITY_END();
}
