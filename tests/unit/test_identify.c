/* SPDX-License-Identifier: MIT */
/*
 * The identification as a whole: its lines and words with the drive behind them, its begin and its
 * ends.
 */
#include "commander.h"
#include "example_identify.h"
#include "identify_rest.h"
#include "identify_turn.h"
#include "state_guard.h"
#include "testing.h"

#include <stdio.h>
#include <string.h>

#define PATIENCE (200000U) /* passes */
#define FAULT "identify refused: the drive has a fault: BREAK\r\n"
#define TOO_LONG "identify refused: it has not ended within 2 minutes\r\n"

static text_t text;

void setUp(void)
{
    identify_example();
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

/* To the first phase. */
static void begin(void)
{
    start();
    (void)next_line();
    (void)next_line();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, identify.phase);
}

static void assert_given_back(void)
{
    tick_period();
    TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
    TEST_ASSERT_EQUAL_INT32(TARGET, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, app.in.command.mode);
    TEST_ASSERT_FALSE(app.out.gate_enable);
}

static void assert_ended(void)
{
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    assert_given_back();
}

/* ---- begin and end ---- */

TEST(test_it_is_refused_unless_the_drive_is_ready)
{
    power_on();
    TEST_ASSERT_EQUAL_STRING("the drive is not READY", identify_start(&identify));
    calibrate();
    fail();
    TEST_ASSERT_EQUAL_STRING("the drive is not READY", identify_start(&identify));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_STRING("", pass());
}

TEST(test_it_is_refused_while_a_change_waits_for_the_control_interrupt)
{
    drive_cfg_t other = cfg;

    app_change(&app, &other);
    TEST_ASSERT_NOT_NULL(strstr(identify_start(&identify), "ask again"));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    tick_period();
    TEST_ASSERT_NULL(identify_start(&identify));
}

/* Its current could be ten times that of the motor which is connected. */
TEST(test_it_is_refused_while_nobody_has_said_which_motor_is_connected)
{
    about_t example = *identify.about;

    example.is_example = 1U;
    identify.about = &example;
    TEST_ASSERT_NOT_NULL(strstr(identify_start(&identify), "example motor"));
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_STRING("", pass());
    example.is_example = 0U;
    TEST_ASSERT_NULL(identify_start(&identify));
}

/* 192/32768 of 40 A are 0.2344 A. */
TEST(test_a_current_that_the_converter_hardly_sees_is_refused_with_the_one_it_takes)
{
    cfg.derating.current_continuous = 191;
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_EQUAL_STRING(
        "identify refused: the continuous current of the name plate is too small for this board's "
        "sensors, it takes at least 0.235 A\r\n",
        pass());
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    cfg.derating.current_continuous = 192;
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_EQUAL_STRING_LEN("identify 2 ", pass(), 11U);
}

/* 24 counts of 8 bits, which has 128 of them from its middle to its end. */
TEST(test_a_coarser_converter_takes_more_current)
{
    about_t coarse = *identify.about;

    coarse.current_zero_count = 128U;
    identify.about = &coarse;
    cfg.derating.current_continuous = 3071;
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_EQUAL_INT32(3072, identify.needed);
    identify_stop(&identify);
    coarse.current_zero_count = 0U; /* of a file that says nothing: one count is all */
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_EQUAL_INT32(24 * 16384, identify.needed);
    identify_stop(&identify);
    coarse.current_zero_count = 128U;
    cfg.derating.current_continuous = 3072;
    TEST_ASSERT_NULL(identify_start(&identify));
    TEST_ASSERT_NULL(identify.why);
}

TEST(test_it_is_refused_while_it_is_under_way)
{
    start();
    TEST_ASSERT_EQUAL_STRING("it is under way", identify_start(&identify));
    (void)next_line();
    TEST_ASSERT_EQUAL_STRING("it is under way", identify_start(&identify));
    identify_stop(&identify);
    assert_ended();
}

TEST(test_it_says_its_scales_and_what_it_will_do_before_it_does_it)
{
    start();
    TEST_ASSERT_EQUAL_STRING("identify 2 100000000 20000000 450000000 2 11 #500ABCC2\r\n", pass());
    TEST_ASSERT_EQUAL_UINT8(PROBE_CURRENT, command_mailbox_take(&app.mailbox).mode);
    TEST_ASSERT_EQUAL_INT32(0, command_mailbox_take(&app.mailbox).target);
    TEST_ASSERT_EQUAL_STRING("pulses on each phase, the shaft hardly moves, up to 6.718 A; behind "
                             "them it turns, up to 1333 rpm\r\n",
                             next_line());
}

TEST(test_a_stop_opens_the_gates_and_brings_the_users_command_back)
{
    begin();
    tick(100U);
    TEST_ASSERT_TRUE(app.out.gate_enable);
    identify_stop(&identify);
    assert_ended();
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    TEST_ASSERT_EQUAL_STRING("", next_line());
}

TEST(test_a_stop_without_an_identification_leaves_the_command)
{
    const drive_command_t runs = {.target = 5, .request = DRIVE_REQUEST_RUN};

    command_mailbox_post(&app.mailbox, &runs);
    identify_stop(&identify);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
}

TEST(test_a_fault_ends_it_with_a_line)
{
    begin();
    fail();
    TEST_ASSERT_EQUAL_STRING(FAULT, pass());
    assert_ended();
    TEST_ASSERT_EQUAL_STRING("", next_line());
    setUp();
    start(); /* and before its first word */
    fail();
    TEST_ASSERT_EQUAL_STRING(FAULT, pass());
    assert_ended();
}

/* A rotor that the vector holds gives power back. At rest the bus is too high by itself. */
TEST(test_an_overvoltage_names_braking_in_each_phase_that_may_brake)
{
    static const struct {
        identify_phase_t phase;
        bool brakes;
    } phases[] = {{IDENTIFY_PULSE, false}, {IDENTIFY_CATCH, true}, {IDENTIFY_STILL, false},
                  {IDENTIFY_SPIN, true},   {IDENTIFY_RAMP, true},  {IDENTIFY_COAST, true}};

    for (uint32_t k = 0U; k < (sizeof phases / sizeof phases[0]); k++) {
        setUp();
        begin();
        identify.phase = phases[k].phase;
        identify.said = phases[k].phase;
        app.drive.fault.id = FAULT_OVERVOLTAGE;
        app.drive.state = DRIVE_STATE_FAULT;
        TEST_ASSERT_EQUAL(phases[k].brakes, strstr(pass(), "by braking") != NULL);
        assert_ended();
    }
}

/* The clear comes before the next line: the name is that of the fault that has ended it. */
TEST(test_a_fault_that_is_cleared_meanwhile_has_ended_it)
{
    begin();
    fail();
    text.length = 1U;
    identify_step(&identify, &text);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    tick_period();
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
    commander_step(&app);
    TEST_ASSERT_EQUAL_STRING(FAULT, pass());
    assert_ended();
}

/* From another link of the background, whose command stays. */
TEST(test_a_drive_that_leaves_probe_by_another_command_ends_it)
{
    begin();
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    tick_period();
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
    TEST_ASSERT_EQUAL_STRING("identify refused: another command has ended it\r\n", pass());
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
    TEST_ASSERT_EQUAL_INT32(TARGET, command_mailbox_take(&app.mailbox).target);
}

/*
 * Of the example: 20 s, and a largest current of 1.34 times the continuous one: 1.2 − 0.1 − 8/20 ·
 * 1.34² is 0.38.
 */
TEST(test_it_waits_until_a_winding_that_may_be_warm_has_cooled)
{
    app.drive.derating.heat_q24 = 0xE66666; /* 0.9 */
    state_guard_keep_heat(&app.drive.state_guard, &app.drive.derating);
    start();
    TEST_ASSERT_EQUAL_STRING(
        "the winding may be at 90 % of its continuous heat; waiting until it is at 38 %\r\n",
        next_line());
    for (uint32_t k = 0U; k < 1000U; k++) {
        tick(1U);
        TEST_ASSERT_EQUAL_STRING("", pass());
        TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
        TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
    }
    app.drive.derating.heat_q24 = 0x400000;
    state_guard_keep_heat(&app.drive.state_guard, &app.drive.derating);
    TEST_ASSERT_EQUAL_STRING_LEN("identify 2", next_line(), 10);
    (void)next_line();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
}

TEST(test_a_stop_ends_the_wait_for_a_winding)
{
    app.drive.derating.heat_q24 = 0xE66666;
    state_guard_keep_heat(&app.drive.state_guard, &app.drive.derating);
    start();
    (void)next_line();
    identify_stop(&identify);
    assert_ended();
}

/* 8 s of ten minutes add 0.02. */
TEST(test_a_winding_with_a_long_time_constant_is_not_waited_for)
{
    cfg.derating.heat_rate_shift += 5U;
    cfg.crc = config_guard_crc(&cfg);
    state_guard_keep_config(&app.drive.state_guard, app.drive.cfg);
    app.drive.derating.heat_q24 = 0xE66666;
    state_guard_keep_heat(&app.drive.state_guard, &app.drive.derating);
    begin();
}

/* Whoever follows it on a PC counts them too. */
TEST(test_the_wait_for_a_winding_is_part_of_the_two_minutes)
{
    app.drive.derating.heat_q24 = 0xE66666;
    state_guard_keep_heat(&app.drive.state_guard, &app.drive.derating);
    start();
    (void)next_line();
    app.drive.tick += 2U * 60U * 1000U * (uint32_t)MS;
    TEST_ASSERT_EQUAL_STRING("", pass());
    app.drive.tick++;
    TEST_ASSERT_EQUAL_STRING(TOO_LONG, next_line());
    assert_ended();
}

TEST(test_it_can_be_started_again)
{
    begin();
    identify_stop(&identify);
    assert_ended();
    begin();
    TEST_ASSERT_EQUAL_UINT32(1U, identify.step);
}

/* Before the drive has taken it. */
TEST(test_a_run_that_was_asked_for_is_not_asked_for_again_at_the_end)
{
    (void)commander_run(&app, SOURCE_LINK);
    start();
    identify_stop(&identify);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

/* They begin with it. It ends with open gates before its line is said. */
TEST(test_after_two_minutes_it_ends_whatever_it_waits_for)
{
    for (uint32_t wait = 0U; wait <= (uint32_t)IDENTIFY_MEASURING; wait++) {
        setUp();
        app.drive.tick = 130000U * MS;
        begin();
        TEST_ASSERT_NULL(identify.why);
        tick(100U);
        TEST_ASSERT_TRUE(app.out.gate_enable);
        identify.wait = (identify_wait_t)wait;
        identify.began = app.drive.tick - (120000U * MS);
        identify.said = identify.phase;
        text.length = 1U; /* nobody reads the line */
        identify_step(&identify, &text);
        TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
        TEST_ASSERT_NULL(identify.why);
        tick(1U);
        identify_step(&identify, &text);
        TEST_ASSERT_EQUAL_UINT32(1U, text.length);
        TEST_ASSERT_TRUE(identify_is_busy(&identify));
        assert_given_back();
        TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
        tick(100U);
        identify_step(&identify, &text);
        TEST_ASSERT_TRUE(identify_is_busy(&identify));
        TEST_ASSERT_EQUAL_STRING(TOO_LONG, pass());
        assert_ended();
    }
}

/* Nothing has been asked of the drive then. */
TEST(test_a_line_that_nobody_reads_from_the_beginning_ends_it_too)
{
    start();
    identify.began = app.drive.tick - (120000U * MS) - 1U;
    text.length = 1U;
    identify_step(&identify, &text);
    TEST_ASSERT_EQUAL_STRING(TOO_LONG, pass());
    assert_ended();
}

TEST(test_what_has_ended_keeps_its_reason_while_its_line_waits)
{
    begin();
    identify_aim_refusal(&identify, "of this");
    identify.began = app.drive.tick - (120000U * MS) - 1U;
    fail();
    TEST_ASSERT_EQUAL_STRING("identify refused: of this\r\n", pass());
    assert_ended();
}

TEST(test_it_says_nothing_while_a_line_waits)
{
    begin();
    tick(1000U);
    text.length = 1U;
    for (uint32_t k = 0U; k < 1000U; k++) {
        identify_step(&identify, &text);
        tick(1U);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, text.length);
    TEST_ASSERT_EQUAL_STRING_LEN("= pulse", next_line(), 7U);
}

/*
 * A fault that is cleared in the pass in which it is seen; or another link that commands the drive.
 */
TEST(test_another_request_than_its_own_is_left_to_the_user)
{
    static const uint8_t requests[] = {DRIVE_REQUEST_CLEAR, DRIVE_REQUEST_RUN};

    for (uint32_t k = 0U; k < 2U; k++) {
        setUp();
        begin();
        drive_command_t command = command_mailbox_take(&app.mailbox);
        TEST_ASSERT_TRUE(command.mode >= (uint8_t)PROBE_CURRENT);
        command.request = requests[k];
        command_mailbox_post(&app.mailbox, &command);
        identify_stop(&identify);
        command = command_mailbox_take(&app.mailbox);
        TEST_ASSERT_EQUAL_UINT8(requests[k], command.request);
        TEST_ASSERT_EQUAL_INT32(TARGET, command.target);
        TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, command.mode);
    }
}

static void assert_says_of(identify_phase_t phase, const char *line)
{
    identify_aim_phase(&identify, phase);
    TEST_ASSERT_EQUAL_STRING(line, pass());
}

/*
 * 6.71875 A and the largest, and half of 2000 rpm with a third for swings: before each phase a
 * person knows what the shaft will do.
 */
TEST(test_each_phase_is_told_before_it_begins)
{
    begin();
    assert_says_of(IDENTIFY_CATCH,
                   "the shaft turns by up to one and a half electrical turns, with 6.718 A\r\n");
    assert_says_of(IDENTIFY_STILL,
                   "the shaft goes to three angles of an electrical turn, up to 8.999 A\r\n");
    assert_says_of(IDENTIFY_SPIN, "the shaft turns, up to 1333 rpm, with at most 6.718 A\r\n");
    assert_says_of(IDENTIFY_RAMP, "between half of that speed and the whole\r\n");
    assert_says_of(IDENTIFY_COAST, "no current, the shaft coasts\r\n");
    cfg.derating.current_continuous = 5505; /* 6.71997 A */
    assert_says_of(IDENTIFY_CATCH,
                   "the shaft turns by up to one and a half electrical turns, with 6.719 A\r\n");
    assert_says_of(IDENTIFY_ENDS, "identify done #42071888\r\n");
    assert_ended();
}

/* ---- words and records ---- */

TEST(test_the_words_that_are_in_force_at_first_are_those_of_a_reset)
{
    probe_t probe;

    probe_reset(&probe);
    start();
    for (uint32_t k = 0U; k < IDENTIFY_WORDS; k++) {
        const uint32_t which = k + (uint32_t)PROBE_CURRENT;
        const bool ones = (which == (uint32_t)PROBE_PULSE_TICKS) || (which == (uint32_t)PROBE_EMF);

        TEST_ASSERT_EQUAL_INT32(ones ? 1 : 0, identify.in_force[k]);
    }
    TEST_ASSERT_EQUAL_INT32(probe.pulse_ticks, word(PROBE_PULSE_TICKS) + 1);
    TEST_ASSERT_EQUAL_INT32(probe.emf_full, word(PROBE_EMF));
}

/* Of 2 ms a tick. */
TEST(test_a_millisecond_has_a_tick_at_least)
{
    about_t slow = ABOUT;

    slow.rotation.tick_ps = 2000000000U;
    identify_init(&identify, &app, &slow);
    start();
    TEST_ASSERT_EQUAL_INT32(1, identify.ms_ticks);
}

static bool are_equal(const drive_command_t *a, const drive_command_t *b)
{
    return (a->target == b->target) && (a->mode == b->mode) && (a->request == b->request);
}

/* Five passes a tick: what the drive has not taken is not replaced. */
TEST(test_a_word_is_posted_once_the_drive_has_taken_the_one_before)
{
    uint32_t posted = 0U;

    begin();
    for (uint32_t k = 0U; k < 20000U; k++) {
        const drive_command_t before = command_mailbox_take(&app.mailbox);
        const drive_command_t taken = app.in.command;

        (void)pass();
        const drive_command_t now = command_mailbox_take(&app.mailbox);
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

static bool pass_posts_another(const drive_command_t *posted, const drive_command_t *taken)
{
    app.in.command = *taken;
    (void)pass();
    const drive_command_t now = command_mailbox_take(&app.mailbox);

    return !are_equal(posted, &now);
}

TEST(test_a_word_is_taken_once_all_of_it_is)
{
    for (uint32_t part = 0U; part < 3U; part++) {
        setUp();
        begin();
        TEST_ASSERT_EQUAL(IDENTIFY_ASKING, identify.wait);
        const drive_command_t posted = command_mailbox_take(&app.mailbox);
        drive_command_t other = posted;

        other.target += (part == 0U) ? 1 : 0;
        other.mode = (uint8_t)(other.mode + ((part == 1U) ? 1U : 0U));
        other.request = (part == 2U) ? 0U : other.request;
        TEST_ASSERT_FALSE(pass_posts_another(&posted, &other));
        TEST_ASSERT_TRUE(pass_posts_another(&posted, &posted));
    }
}

TEST(test_the_drive_has_all_words_of_an_experiment_when_its_window_opens)
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
    .turn_q16 = -21,
    .across = 22,
    .torque = -23,
};

static bool is_measured(void)
{
    return (identify.wait == IDENTIFY_MEASURING) && (app.drive.probe.tick == 0U) &&
           (app.drive.probe.window == identify.in_force[IDENTIFY_WORDS - 1U]);
}

static void measure(void)
{
    while (!is_measured()) {
        TEST_ASSERT_EQUAL_STRING("", pass());
        tick(1U);
    }
}

static const char *next_record(void)
{
    measure();
    app.drive.probe.sums = NUMBERED;
    return next_line();
}

/* The checksums were computed apart from the firmware. Each is of all records so far. */
TEST(test_a_record_has_what_was_asked_for_the_sums_in_their_order_and_a_checksum)
{
    begin();
    TEST_ASSERT_EQUAL_STRING(
        "= pulse 0 0 0 88 0 1 64 11 -12 13 -14 15 16 17 18 -19 -21 22 -23 #9FD16D2D\r\n",
        next_record());
    TEST_ASSERT_EQUAL_STRING(
        "= pulse 1 0 0 88 0 1 64 11 -12 13 -14 15 16 17 18 -19 -21 22 -23 #4247D70B\r\n",
        next_record());
}

static uint32_t next_number(void)
{
    (void)next_record();
    TEST_ASSERT_EQUAL_INT32(64, app.drive.probe.window & 0xFFFFF);
    return fx_unsigned(app.drive.probe.window) >> 20U;
}

/* A number of 11 bits, so that the word is positive; the ticks are below it. */
TEST(test_each_window_has_a_word_of_its_own)
{
    begin();
    identify.windows = 5U;
    TEST_ASSERT_EQUAL_UINT32(5U, next_number());
    TEST_ASSERT_EQUAL_UINT32(6U, next_number());
    identify.windows = 0x7FFU;
    TEST_ASSERT_EQUAL_UINT32(0x7FFU, next_number());
    TEST_ASSERT_EQUAL_UINT32(0U, next_number());
}

/* A window of the same word that has ended is not the one that was asked for. */
TEST(test_a_window_is_measured_once_its_word_is_taken)
{
    begin();
    measure();
    app.in.command.target++;
    TEST_ASSERT_EQUAL_STRING("", pass());
    app.in.command.target--;
    TEST_ASSERT_EQUAL_STRING_LEN("= pulse", pass(), 7U);
}

#define SETTLE (50)
#define WINDOW (30)

/* An experiment of the test's own: all words but these are in force already. */
static void experiment(step_t speed, step_t ramp)
{
    begin();
    (void)next_record();
    identify_aim_set(&identify, PROBE_PULSE_D, 0);
    identify_aim_set(&identify, PROBE_SPEED, speed);
    identify_aim_set(&identify, PROBE_RAMP, ramp);
    identify_aim_set(&identify, PROBE_CURRENT, 11);
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
TEST(test_a_window_opens_once_the_vector_has_arrived_and_settled)
{
    experiment(100000, 1000);
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_SETTLING) >= 90U);
    TEST_ASSERT_EQUAL_INT32(100000, app.drive.probe.own_speed);
    TEST_ASSERT_EQUAL_INT32(11, app.drive.probe.current);
    TEST_ASSERT_EQUAL_UINT32((uint32_t)SETTLE, ticks_to(IDENTIFY_MEASURING));
    TEST_ASSERT_EQUAL_UINT32(0U, app.drive.probe.tick);
    tick_period();
    TEST_ASSERT_TRUE(app.drive.probe.tick > 0U);
    TEST_ASSERT_EQUAL_INT32(WINDOW, app.drive.probe.window & 0xFFFFF);
}

TEST(test_a_vector_on_its_way_to_a_speed_has_not_arrived_at_any_angle)
{
    experiment(100000, 1);
    (void)ticks_to(IDENTIFY_MOVING);
    tick(100U);
    for (uint32_t k = 0U; k < 10U; k++) {
        tick(1U);
        app.drive.probe.angle = rotor_position_angle(&app.drive.vector.position);
        (void)pass();
        TEST_ASSERT_EQUAL(IDENTIFY_MOVING, identify.wait);
    }
}

TEST(test_a_vector_at_rest_has_arrived_at_its_angle_only)
{
    experiment(0, 1);
    identify_aim_set(&identify, PROBE_RATE, 0x100000);
    identify_aim_set(&identify, PROBE_ANGLE, 0x10000000); /* 256 ticks away */
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_SETTLING) >=
                     200U); /* its last words are asked for on the way */
    TEST_ASSERT_EQUAL_UINT32(0x10000000U, rotor_position_angle(&app.drive.vector.position));
}

/* The vector has moved for so long. */
static void have_moved(uint32_t ticks)
{
    identify.wait = IDENTIFY_MOVING;
    identify.said = identify.phase;
    identify.since = app.drive.tick - ticks;
    TEST_ASSERT_EQUAL_STRING("", pass());
}

/* 5 s, and twice as long for each further attempt. */
TEST(test_a_vector_that_does_not_arrive_is_caught_twice_and_then_refused)
{
    experiment(100000, 1);
    (void)ticks_to(IDENTIFY_MOVING);
    for (uint32_t slower = 0U; slower < 3U; slower++) {
        const uint32_t longest = (5000U * (uint32_t)MS) << slower;

        TEST_ASSERT_EQUAL_UINT32(slower, identify.turn.slower);
        have_moved(longest);
        TEST_ASSERT_EQUAL(IDENTIFY_MOVING, identify.wait);
        have_moved(longest + 1U);
        TEST_ASSERT_EQUAL(IDENTIFY_ASKING, identify.wait);
        if (slower < 2U) {
            TEST_ASSERT_EQUAL(IDENTIFY_CATCH, identify.phase);
            TEST_ASSERT_EQUAL_UINT32(1U, identify.step); /* its first move is planned */
            TEST_ASSERT_EQUAL_STRING("catch", identify.aim.kind);
        }
    }
    TEST_ASSERT_EQUAL_STRING("identify refused: the rotor falls out of step: is the load too "
                             "large, or does it change?\r\n",
                             pass());
    assert_ended();
}

/*
 * On a ramp with a bus that takes no braking power the reason is the bus, before the vector is
 * caught again.
 */
TEST(test_a_ramp_that_waits_for_the_bus_too_long_names_the_bus)
{
    for (uint32_t high = 0U; high < 2U; high++) {
        setUp();
        experiment(100000, 1);
        (void)ticks_to(IDENTIFY_MOVING);
        identify.phase = IDENTIFY_RAMP;
        app.drive.bus = (high != 0U) ? FX_Q15_MAX : 0;
        have_moved((5000U * (uint32_t)MS) + 1U);
        TEST_ASSERT_EQUAL((high != 0U) ? IDENTIFY_ENDS : IDENTIFY_CATCH, identify.phase);
    }
    TEST_ASSERT_EQUAL_STRING_LEN("the bus stays too high for braking", identify.why, 34U);
}

/* A heavy rotor has four times as long. What was measured before counts without the sensors. */
TEST(test_a_vector_that_does_not_arrive_for_the_hall_sensors_ends_the_identification_well)
{
    const uint32_t longest = 4U * 5000U * (uint32_t)MS;

    experiment(100000, 1);
    (void)ticks_to(IDENTIFY_MOVING);
    identify.phase = IDENTIFY_HALL;
    have_moved(longest);
    TEST_ASSERT_EQUAL(IDENTIFY_MOVING, identify.wait);
    have_moved(longest + 1U);
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    TEST_ASSERT_EQUAL_STRING_LEN("identify done #", pass(), 15U);
    assert_ended();
}

/* One that arrives late has arrived. */
TEST(test_a_window_that_rushes_waits_for_no_vector)
{
    experiment(100000, 1);
    identify.aim.rushes = true;
    (void)ticks_to(IDENTIFY_MOVING);
    TEST_ASSERT_EQUAL_UINT32(3U, ticks_to(IDENTIFY_SETTLING));
    have_moved((5000U * (uint32_t)MS) + 1U);
    TEST_ASSERT_EQUAL(IDENTIFY_SETTLING, identify.wait);
    TEST_ASSERT_EQUAL_UINT32(0U, identify.turn.slower);
}

/* A ramp lies within its window: the plan of the first ramp down, after a window that has ended. */
TEST(test_a_window_that_leads_opens_before_its_words_are_asked_for)
{
    begin();
    (void)next_record();
    identify_aim_phase(&identify, IDENTIFY_RAMP);
    identify.said = IDENTIFY_RAMP;
    identify.turn.top = 1000000;
    identify.turn.low = 500000;
    identify.turn.ramp_ticks = 100;
    (void)ticks_to(IDENTIFY_MEASURING);
    (void)next_line();
    TEST_ASSERT_EQUAL(IDENTIFY_LEADING, identify.wait);
    tick_period();
    TEST_ASSERT_TRUE(app.drive.probe.tick > 0U);
    TEST_ASSERT_TRUE(ticks_to(IDENTIFY_ASKING) >= (fx_unsigned(identify.aim.settle) - 20U));
    TEST_ASSERT_NOT_EQUAL_INT32(identify.turn.low, app.drive.probe.speed);
    (void)ticks_to(IDENTIFY_MEASURING);
    tick_period();
    TEST_ASSERT_EQUAL_INT32(identify.turn.low, app.drive.probe.speed);
}

/* Nothing flows in the binding of memory. */
TEST(test_a_motor_that_is_not_there_ends_it_with_a_line_and_open_gates)
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

/* A window of 10 ticks has ended. */
static identify_phase_t phase_of_noise(identify_phase_t phase, uint32_t step, int32_t a, int32_t b)
{
    setUp();
    begin();
    identify.phase = phase;
    identify.said = phase;
    identify.step = step;
    identify_aim_window(&identify, "pulse", 0, 10);
    identify.wait = IDENTIFY_MEASURING;
    tick_period();
    identify.in_force[IDENTIFY_WORDS - 1U] = app.drive.probe.window;
    app.drive.probe.sums = (probe_sums_t){.noise_a = a, .noise_b = b};
    TEST_ASSERT_EQUAL_STRING_LEN("= pulse", next_line(), 7U);
    const identify_phase_t phase_then = identify.phase;

    if (phase_then == IDENTIFY_ENDS) {
        TEST_ASSERT_EQUAL_STRING("identify refused: the noise of the current sensors is too large "
                                 "for the continuous current\r\n",
                                 next_line());
    }
    return phase_then;
}

/* 5504/16 is 344 from sample to sample. Larger pulses and a rotor that moves change the current. */
TEST(test_sensors_that_are_too_noisy_are_refused)
{
    const uint32_t last = IDENTIFY_AXES;

    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, phase_of_noise(IDENTIFY_PULSE, 1U, 3449, 3449));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_of_noise(IDENTIFY_PULSE, 1U, 3450, 0));
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, phase_of_noise(IDENTIFY_PULSE, last, 0, 3450));
    TEST_ASSERT_EQUAL(IDENTIFY_PULSE, phase_of_noise(IDENTIFY_PULSE, last + 1U, 3450, 3450));
    TEST_ASSERT_EQUAL(IDENTIFY_CATCH, phase_of_noise(IDENTIFY_CATCH, 0U, 3450, 3450));
}

/* ---- a current that runs away ---- */

#define RUNS_AWAY \
    "more current flows than was asked for: does a load turn the rotor, or do the current sensors follow late?"
#define FALLS_OUT "the rotor falls out of step: is the load too large, or does it change?"
#define LACKS_VOLTAGE "the bus voltage is too low to turn the motor at 1/8 of its highest speed"

/* Under way with this experiment, which moves. */
static void be_in(identify_phase_t phase, uint32_t step, uint32_t slower)
{
    setUp();
    begin();
    identify_aim_phase(&identify, phase);
    identify.said = phase;
    identify.step = step;
    identify.turn.slower = slower;
    identify.wait = IDENTIFY_MOVING;
    identify.since = app.drive.tick;
}

static void flow(int32_t d, int32_t q)
{
    app.drive.probe.current_before = (dq_t){d, q};
    (void)pass();
}

static void expect_largest(identify_phase_t phase, uint32_t step, uint32_t slower, int32_t largest)
{
    const int32_t more = largest + 1;
    const dq_t beyond[] = {{more, 0}, {-more, 0}, {0, more}, {0, -more}};

    be_in(phase, step, slower);
    flow(largest, -largest);
    flow(-largest, largest);
    TEST_ASSERT_NULL(identify.why);
    for (uint32_t k = 0U; k < 4U; k++) {
        be_in(phase, step, slower);
        flow(beyond[k].d, beyond[k].q);
        TEST_ASSERT_EQUAL_STRING((slower > 0U) ? FALLS_OUT : RUNS_AWAY, identify.why);
        assert_ended();
    }
}

/*
 * 5/4 of the continuous current, half way from the largest one to the fault, and the fault itself.
 */
TEST(test_a_current_beyond_that_of_the_phase_ends_it)
{
    const int32_t fault = cfg.protection.current_max;
    const int32_t middle = (7372 + fault) / 2;

    TEST_ASSERT_TRUE((CONTINUOUS * 5) / 4 < middle);
    expect_largest(IDENTIFY_PULSE, 1U, 0U, (CONTINUOUS * 5) / 4);
    expect_largest(IDENTIFY_CATCH, 1U, 0U, middle);
    expect_largest(IDENTIFY_CATCH, 1U, 1U, fault);
    expect_largest(IDENTIFY_STILL, 1U, 0U, middle);
    expect_largest(IDENTIFY_SPIN, 1U, 0U, middle);
    expect_largest(IDENTIFY_SPIN, 2U, 0U, fault);
    expect_largest(IDENTIFY_RAMP, 1U, 1U, fault);
    expect_largest(IDENTIFY_COAST, 1U, 0U, fault);
}

/* Where it is nearer than 5/4 of the continuous one. Before the first phase no current counts. */
TEST(test_pulses_stay_below_the_middle_too)
{
    const int32_t middle = (7372 + cfg.protection.current_max) / 2;

    start();
    (void)next_line();
    flow(16383, 0);
    TEST_ASSERT_NULL(identify.why);
    be_in(IDENTIFY_PULSE, 1U, 0U);
    cfg.derating.current_continuous = 4 * CONTINUOUS;
    flow(middle, 0);
    TEST_ASSERT_NULL(identify.why);
    flow(middle + 1, 0);
    TEST_ASSERT_EQUAL_STRING(RUNS_AWAY, identify.why);
}

/* What the pulses have shown is the reason, whatever ends it. */
TEST(test_sensors_that_follow_late_are_named_with_each_refusal)
{
    be_in(IDENTIFY_CATCH, 1U, 0U);
    identify.rest.lag = true;
    app.drive.probe.current_before = (dq_t){cfg.protection.current_max, 0};
    TEST_ASSERT_EQUAL_STRING(
        "identify refused: more current flows than was asked for; the current sensors follow late, as "
        "behind a low pass: pulses of twice the time show much more current\r\n",
        pass());
}

TEST(test_a_current_that_runs_away_while_a_phase_is_open_names_the_phase)
{
    be_in(IDENTIFY_STILL, 1U, 0U);
    identify_aim_current(&identify, CONTINUOUS);
    flow(cfg.protection.current_max, 0);
    TEST_ASSERT_EQUAL_STRING("phase a is open", identify.why);
}

TEST(test_a_current_that_runs_away_for_want_of_voltage_says_so)
{
    be_in(IDENTIFY_SPIN, 1U, 0U);
    app.drive.control.voltage = (dq_t){0, 12382};
    flow(cfg.protection.current_max, 0);
    TEST_ASSERT_EQUAL_STRING(LACKS_VOLTAGE, identify.why);
}

/* Its line waits: what is said of it is the first reason. */
TEST(test_a_measurement_that_was_refused_keeps_its_reason_when_the_link_falls_silent)
{
    be_in(IDENTIFY_STILL, 1U, 0U);
    identify_refuse(&identify, "first");
    TEST_ASSERT_EQUAL(IDENTIFY_ENDS, identify.phase);
    identify_refuse(&identify, "second");
    TEST_ASSERT_EQUAL_STRING("first", identify.why);
}
