/* SPDX-License-Identifier: MIT */
/* The console: what it answers to each line, what the drive gets of it. */
#include "box.h"
#include "commander.h"
#include "console.h"
#include "example_app.h"
#include "flash_model.h"
#include "testing.h"

#include <string.h>

#define SAID_MAX (4096U)
#define HELP \
    "error: the commands are run, stop, clear, speed RPM, torque NM, zero, unlock, status, dump, record, last, faults, identify\r\n"
#define WRONG_SPEED "error: speed takes a whole number of rpm, at most 2000 either way\r\n"

static struct {
    size_t room;
    char said[SAID_MAX];
    size_t length;
    uint32_t sent; /* of the console's text */
} line;
static console_t console;
static recorder_t recorder;
static recorder_entry_t entries[RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN];

/* What the line has room for is taken from the console's text, as link.h does it. */
static void send(void)
{
    text_t *const out = &console.out;

    while ((line.sent < out->length) && (line.room > 0U) && (line.length < (SAID_MAX - 1U))) {
        line.said[line.length] = out->characters[line.sent];
        line.length++;
        line.sent++;
        line.room--;
    }
    if (line.sent == out->length) {
        line.sent = 0U;
        out->length = 0U;
    }
}

static bool counts; /* what is typed does not come late */

/* What the console says to this, with nothing said before. */
static const char *said_to(const char *typed)
{
    memset(line.said, 0, sizeof line.said);
    line.length = 0U;
    for (const char *at = typed; *at != '\0'; at++) {
        console_take(&console, (uint8_t)*at, counts);
    }
    commander_step(&app);
    console_step(&console);
    send();
    return line.said;
}

static void assert_says(const char *expected, const char *typed)
{
    TEST_ASSERT_EQUAL_STRING_MESSAGE(expected, said_to(typed), typed);
}

static void assert_contains(const char *expected, const char *said)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, expected), said);
}

static void ready(void)
{
    calibrate();
    (void)said_to("");
}

static void failed(void)
{
    ready();
    fail();
    (void)said_to("");
}

static uint8_t request_taken(void)
{
    tick_period();
    return app.in.command.request;
}

void setUp(void)
{
    flash_new(1U);
    memset(&line, 0, sizeof line);
    line.room = SIZE_MAX;
    power_on();
    TEST_ASSERT_NULL(recorder_init(&recorder, entries, RECORDER_ENTRIES_MIN, 8U));
    console_init(&console, &app, &hardware, &ABOUT);
    counts = true;
}

TEST(test_what_comes_late_commands_nothing_unless_it_is_a_stop)
{
    static const char *const refused[] = {"run\n",      "clear\n", "speed 100\n", "torque 0.1\n",
                                          "identify\n", "zero\n",  "unlock\n"};

    tick(EXAMPLE_CALIBRATION_TICKS);
    counts = false;
    for (uint32_t k = 0U; k < (sizeof refused / sizeof refused[0]); k++) {
        TEST_ASSERT_NOT_NULL(strstr(said_to(refused[k]), "error: " COMMANDER_STALE "\r\n"));
        TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
    }
    TEST_ASSERT_NOT_NULL(strstr(said_to("status\n"), "READY"));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said_to("stop\n"));
}

TEST(test_each_speed_within_the_boards_limit_reaches_the_drive)
{
    static const struct {
        const char *typed;
        int32_t target;
    } speeds[] = {{"speed 2000\n", EXAMPLE_SPEED_STEP},
                  {"speed -2000\n", -EXAMPLE_SPEED_STEP},
                  {"speed +1\n", 14317},
                  {"speed 0\n", 0},
                  {"speed -1\n", -14317},
                  {"speed 1999\n", 28618799}};

    ready();
    for (uint32_t k = 0U; k < (sizeof speeds / sizeof speeds[0]); k++) {
        assert_says("ok\r\n", speeds[k].typed);
        tick_period();
        TEST_ASSERT_EQUAL_INT32_MESSAGE(speeds[k].target, app.in.command.target, speeds[k].typed);
    }
}

TEST(test_a_speed_beyond_the_limit_on_either_side_or_no_number_changes_nothing)
{
    static const char *const wrong[] = {
        "speed 2001\n", "speed -2001\n", "speed 999999999\n", "speed -999999999\n",
        "speed \n",     "speed 1.5\n",   "speed x\n",         "speed 4294967297\n"};

    ready();
    (void)said_to("speed 1000\n");
    tick_period();
    for (uint32_t k = 0U; k < (sizeof wrong / sizeof wrong[0]); k++) {
        const int32_t before = app.in.command.target;

        assert_says(WRONG_SPEED, wrong[k]);
        tick_period();
        TEST_ASSERT_EQUAL_INT32_MESSAGE(before, app.in.command.target, wrong[k]);
    }
}

/* Rounded towards zero to 2^-28 of T_b, which is far below what is typed. */
TEST(test_each_torque_within_the_motors_reaches_the_drive)
{
    static const char *const typed[] = {"torque 2.5\n", "torque -2.5\n", "torque 0\n"};
    static const double newton_metres[] = {2.5, -2.5, 0.0};
    const int64_t base = units_torque_base(&ABOUT.rotation, ABOUT.current_full_scale_ua,
                                           ABOUT.bus_full_scale_uv, app.drive.cfg->speed_shift);

    ready();
    for (uint32_t k = 0U; k < 3U; k++) {
        assert_says("ok\r\n", typed[k]);
        tick_period();
        TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_TORQUE, app.in.command.mode);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, newton_metres[k] * 1e6 * 268435456.0 / (double)base,
                                  app.in.command.target);
    }
}

TEST(test_a_torque_beyond_the_motors_or_no_number_changes_nothing)
{
    static const char *const wrong[] = {"torque 999\n", "torque -999\n", "torque \n",
                                        "torque x\n",   "torque 1.\n",   "torque 12345\n"};

    ready();
    (void)said_to("speed 1000\n");
    tick_period();
    for (uint32_t k = 0U; k < (sizeof wrong / sizeof wrong[0]); k++) {
        const char *const said = said_to(wrong[k]);

        assert_contains("error: torque takes N m, at most ", said);
        assert_contains(" either way\r\n", said);
        tick_period();
        TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, app.in.command.mode);
    }
}

TEST(test_where_the_configuration_is_refused_no_torque_is_taken)
{
    app = (app_t){.hal = &hardware}; /* nothing has begun */
    command_mailbox_init(&app.mailbox);
    assert_contains("error: torque takes N m, at most 0.000000", said_to("torque 1\n"));
}

TEST(test_run_and_stop_reach_the_drive_and_leave_the_speed)
{
    ready();
    (void)said_to("speed 2000\n");
    assert_says("ok\r\n", "run\n");
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, request_taken());
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, app.in.command.target);
    (void)said_to("");
    assert_says("ok\r\n", "stop\n");
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, app.in.command.target);
}

TEST(test_a_latched_fault_does_not_run_and_is_cleared_once)
{
    failed();
    assert_says("error: a fault is latched; clear it first\r\n", "run\n");
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
    assert_says("ok\r\n", "clear\n");
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_CLEAR, request_taken());
    (void)said_to("");
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
    ready();
    assert_says("error: there is no fault to clear\r\n", "clear\n");
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
}

TEST(test_a_change_of_state_is_said_once_with_its_fault)
{
    calibrate();
    assert_contains("READY, speed", said_to(""));
    assert_says("", "");
    measured.flags = DRIVE_FLAG_BREAK;
    tick(1U);
    assert_contains("FAULT by ", said_to(""));
    assert_says("", "");
}

TEST(test_a_line_ends_with_either_end_or_both_and_nothing_is_none)
{
    assert_says("ok\r\n", "stop\r");
    assert_says("ok\r\n", "stop\r\n");
    assert_says("ok\r\nok\r\n", "stop\n\n\rstop\n");
    assert_says("", "\r\n");
    assert_says("", "st");
    assert_says("ok\r\n", "op\n");
}

TEST(test_what_protects_is_unlocked_at_rest_only)
{
    ready();
    assert_says("ok\r\n", "unlock\n");
    TEST_ASSERT_TRUE(app.unlocked);
    assert_says("ok\r\n", "run\n");
    TEST_ASSERT_FALSE(app.unlocked);
    assert_contains("error: ", said_to("unlock\n"));
    TEST_ASSERT_FALSE(app.unlocked);
}

TEST(test_other_lines_name_the_commands)
{
    static const char *const others[] = {"x\n",        "runs\n",    "ru\n",   "stop \n",
                                         "clear1\n",   "statusx\n", "dum\n",  "dumps\n",
                                         "recorder\n", "speed\n",   " run\n", "RUN\n"};

    for (uint32_t k = 0U; k < (sizeof others / sizeof others[0]); k++) {
        assert_says(HELP, others[k]);
    }
}

/* 31 characters fit; one more makes the line no command, whatever it begins with. */
TEST(test_a_line_that_is_too_long_is_no_command_and_the_next_one_is)
{
    assert_says(WRONG_SPEED, "speed 1000                     \n");
    assert_says(HELP, "speed 1000                      \n");
    assert_says(HELP, "stopstopstopstopstopstopstopstopstopstopstopstop\n");
    assert_says("ok\r\n", "stop\n");
}

TEST(test_a_dump_needs_a_recorder_and_a_tick_that_runs)
{
    assert_says("error: there is no recorder\r\n", "dump\n");
    assert_says("error: there is no recorder\r\n", "record\n");
    app_record(&app, &recorder);
    assert_says("error: the control tick does not run, nothing is recorded\r\n", "dump\n");
    tick(1U);
    hardware.health.tick_lost = true;
    (void)said_to("");
    assert_says("error: the control tick does not run, nothing is recorded\r\n", "dump\n");
}

static void serve(void)
{
    for (uint32_t k = 0U; k < 64U; k++) {
        tick(1U);
        recorder_service(&recorder, &app.drive);
    }
}

static void record_fault(void)
{
    app_record(&app, &recorder);
    failed();
    serve();
}

static void start_dump(void)
{
    app_record(&app, &recorder);
    ready();
    serve();
    assert_says("ok\r\n", "dump\n");
}

TEST(test_a_dump_is_sent_to_its_end_and_recording_goes_on)
{
    char last[SAID_MAX] = "";

    start_dump();
    assert_says("error: a dump is under way\r\n", "dump\n");
    assert_says("error: a dump is under way\r\n", "record\n");
    serve();
    for (uint32_t k = 0U; (k < 20000U) && (console.dump_phase != CONSOLE_DUMP_NONE); k++) {
        const char *const said = said_to("");

        TEST_ASSERT_TRUE_MESSAGE(strlen(said) > 0U, "a dump that has begun goes on");
        memcpy(last, said, sizeof last);
    }
    TEST_ASSERT_EQUAL_STRING("dump ends\r\n", last);
    TEST_ASSERT_FALSE(recorder.held);
    assert_says("ok\r\n", "record\n");
}

static void dump_starts(const about_t *about)
{
    console_init(&console, &app, &hardware, about);
    start_dump();
    serve();
    TEST_ASSERT_EQUAL_CHAR(RECORDER_LINE_MARK, said_to("")[0]);
}

TEST(test_a_dump_says_what_its_numbers_mean_and_of_which_image_they_are)
{
    static const uint32_t build[RECORDER_BUILD_WORDS] = {11U, 22U, 33U, 44U, 55U};
    const recorder_about_t *const about = &console.dump.header.about;
    about_t of_an_image = ABOUT;

    of_an_image.build = build;
    dump_starts(&of_an_image);
    TEST_ASSERT_EQUAL_UINT32(100000000U, about->tick_ps);
    TEST_ASSERT_EQUAL_UINT32(20000000U, about->current_full_scale_ua);
    TEST_ASSERT_EQUAL_UINT32(450000000U, about->bus_full_scale_uv);
    TEST_ASSERT_EQUAL_UINT32(2U, about->pole_pairs);
    TEST_ASSERT_EQUAL_UINT32_ARRAY(build, about->build, RECORDER_BUILD_WORDS);
    TEST_ASSERT_EQUAL_STRING("a board", (const char *)about->name); /* the PC is little-endian */
    setUp();
    dump_starts(&ABOUT); /* without a build-id */
    TEST_ASSERT_EACH_EQUAL_UINT32(0U, about->build, RECORDER_BUILD_WORDS);
}

TEST(test_a_dump_waits_for_the_line_and_is_no_kept_recording_meanwhile)
{
    record_fault();
    assert_says("ok\r\n", "dump\n");
    line.room = 1U;
    TEST_ASSERT_EQUAL_size_t(1U, strlen(said_to("")));
    line.room = 0U;
    for (uint32_t k = 0U; k < TEXT_MAX; k++) {
        assert_says("", "");
    }
    line.room = SIZE_MAX;
    TEST_ASSERT_NULL(strstr(said_to("status\n"), "keeps the recording"));
    TEST_ASSERT_EQUAL(CONSOLE_DUMP_SENT, console.dump_phase);
}

TEST(test_what_is_frozen_is_dumped_without_a_tick)
{
    record_fault();
    TEST_ASSERT_TRUE(recorder.frozen);
    hardware.health.tick_lost = true;
    (void)said_to("");
    assert_says("ok\r\n", "dump\n");
}

TEST(test_a_kept_recording_is_said_until_it_is_given_up)
{
    static const char kept[] = ", keeps the recording of a fault: dump or record\r\n";

    record_fault();
    assert_contains(kept, said_to("status\n"));
    assert_says("ok\r\n", "record\n");
    TEST_ASSERT_NULL(strstr(said_to("status\n"), kept));
}

#define MEASURING "error: the motor is being measured; stop ends that\r\n"

/* Until the drive measures. */
static void identifies(void)
{
    ready();
    (void)said_to("speed 1000\n");
    assert_contains("ok\r\n", said_to("identify\n"));
    tick_period();
    (void)said_to("");
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
}

TEST(test_an_identification_is_refused_unless_the_drive_is_ready)
{
    assert_contains("error: the drive is not READY\r\n", said_to("identify\n"));
}

TEST(test_while_the_motor_is_measured_no_other_line_moves_it_and_a_stop_ends_that)
{
    identifies();
    const drive_command_t command = app.in.command;

    assert_contains(MEASURING, said_to("run\n"));
    assert_contains(MEASURING, said_to("speed 10\n"));
    assert_contains(MEASURING, said_to("torque 1\n"));
    assert_contains(MEASURING, said_to("zero\n"));
    assert_contains("error: it is under way\r\n", said_to("identify\n"));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_PROBE, request_taken());
    TEST_ASSERT_EQUAL_UINT8(command.mode, app.in.command.mode);
    TEST_ASSERT_EQUAL_INT32(command.target, app.in.command.target);
    assert_contains("ok\r\n", said_to("stop\n"));
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
    TEST_ASSERT_FALSE(app.out.gate_enable);
}

/* A word of the probe is no speed. */
TEST(test_after_an_identification_a_run_has_the_speed_that_was_asked_for_before)
{
    identifies();
    (void)said_to("stop\n");
    tick_period();
    (void)said_to("run\n");
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, request_taken());
    TEST_ASSERT_EQUAL_INT32(14316558, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, app.in.command.mode);
}

/* The records would wait for the end of the dump, and the current would flow until then. */
TEST(test_a_dump_is_refused_while_the_motor_is_measured)
{
    app_record(&app, &recorder);
    identifies();
    assert_contains(MEASURING, said_to("dump\n"));
    TEST_ASSERT_FALSE(recorder.held);
    TEST_ASSERT_EQUAL(CONSOLE_DUMP_NONE, console.dump_phase);
    (void)said_to("stop\n");
    assert_contains("ok\r\n", said_to("dump\n"));
}

TEST(test_a_motor_is_not_measured_while_a_dump_is_under_way)
{
    start_dump();
    assert_contains("error: a dump is under way\r\n", said_to("identify\n"));
    TEST_ASSERT_EQUAL(IDENTIFY_IDLE, console.identify.phase);
}

/* It gives up the recording of an old fault, so that the next one is recorded. */
TEST(test_while_the_motor_is_measured_recording_can_begin_anew)
{
    app_record(&app, &recorder);
    identifies();
    assert_contains("ok\r\n", said_to("record\n"));
    for (uint32_t k = 0U; (k < 100000U) && (console.identify.windows < 5U); k++) {
        tick(1U);
        (void)said_to("");
    }
    TEST_ASSERT_EQUAL_UINT32(5U, console.identify.windows);
}

TEST(test_the_status_says_that_the_motor_is_measured_until_it_ends)
{
    identifies();
    assert_contains("PROBE, speed 0 rpm, measuring the motor, phases ", said_to("status\n"));
    (void)said_to("stop\n");
    tick_period();
    (void)said_to("");
    assert_says(
        "READY, speed unknown, asked 1000 rpm, phases 0.000 0.000 0.000 A, bus 310.034 V, -50 C, "
        "late 0, load 0 %\r\n",
        "status\n");
}

/* None is lost: the next one begins when the last has been sent. */
TEST(test_records_wait_for_the_line)
{
    ready();
    line.room = 0U;
    (void)said_to("identify\n");
    for (uint32_t k = 0U; k < 10U; k++) {
        tick_period();
        console_step(&console);
    }
    TEST_ASSERT_EQUAL(IDENTIFY_BEGINS, console.identify.phase);
    line.room = SIZE_MAX;
    (void)said_to("");
    assert_contains("identify 2 100000000", said_to(""));
}

/* Nobody reads: after two minutes the gates open all the same. */
TEST(test_a_line_that_is_stuck_does_not_leave_the_current_on)
{
    identifies();
    TEST_ASSERT_TRUE(app.out.gate_enable);
    line.room = 0U;
    console_say(&console, "what is stuck");
    console.identify.began = app.drive.tick - 1200001U;
    console_step(&console);
    TEST_ASSERT_EQUAL_UINT8(0U, request_taken());
    TEST_ASSERT_FALSE(app.out.gate_enable);
    line.room = SIZE_MAX;
    (void)said_to("");
    assert_contains("identify refused: it has not ended within 2 minutes\r\n", said_to(""));
}

TEST(test_a_zero_says_whether_the_rotor_is_known)
{
    ready();
    TEST_ASSERT_EQUAL_STRING(
        "error: the rotor is not known at rest; a start counts from its own zero\r\n",
        said_to("zero\n"));
    app.drive.state = DRIVE_STATE_RUN;
    (void)said_to("");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", said_to("zero\n"));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_ZERO, command_mailbox_take(&app.mailbox).request);
}

TEST(test_the_status_says_the_last_reset_where_the_binding_knows_it)
{
    static const char said[] = ", last reset: ";

    TEST_ASSERT_NULL(strstr(said_to("status\n"), said));
    hardware.reset = (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 3U};
    assert_contains(", last reset: watchdog after exception 3\r\n", said_to("status\n"));
    calibrate();
    TEST_ASSERT_NULL_MESSAGE(strstr(said_to(""), said), "nobody asked, and it has not changed");
}

TEST(test_the_status_says_what_the_input_sees_whoever_asked)
{
    TEST_ASSERT_NULL(strstr(said_to("status\n"), ", input: "));
    console.input = "armed";
    assert_contains(", input: armed\r\n", said_to("status\n"));
    calibrate();
    assert_contains(", input: armed\r\n", said_to(""));
}

/* ---- the black box ---- */

#define NONE "error: there is none\r\n"
#define LINES_MAX (20000U)        /* more than a recording has */
#define SAVING_PASSES_MAX (2000U) /* more than a place of the box has units */

static fault_log_t faults;
static box_t box;

static void begin_box(void)
{
    box_init(&box, &app, &hardware, &ABOUT, &faults, true);
}

/* Until the box has saved the recording of a fault. */
static void save_fault(void)
{
    begin_box();
    record_fault();
    for (uint32_t k = 0U; (k < SAVING_PASSES_MAX) && !box_has_saved(&box); k++) {
        box_step(&box, BOX_UNREAD);
    }
    TEST_ASSERT_TRUE(box_has_saved(&box));
    TEST_ASSERT_FALSE(box_is_saving(&box));
}

static void assert_nothing_to_send(const char *typed)
{
    assert_says(NONE, typed);
    assert_says("", "");
    TEST_ASSERT_EQUAL(CONSOLE_DUMP_NONE, console.dump_phase);
}

TEST(test_without_a_box_and_with_an_empty_one_there_is_nothing_to_send)
{
    assert_nothing_to_send("last\n");
    assert_nothing_to_send("faults\n");
    begin_box();
    assert_nothing_to_send("last\n");
    assert_nothing_to_send("faults\n");
}

/* The line with this number of the saved recording. */
static void assert_line_of_the_box(uint32_t number, const char *said)
{
    uint32_t words[RECORDER_LINE_WORDS];
    char expected[RECORDER_LINE_CHARACTERS + 1U];

    for (uint32_t k = 0U; k < RECORDER_LINE_WORDS; k++) {
        words[k] = box_word(&box, (number * RECORDER_LINE_WORDS) + k);
    }
    recorder_line(number, words, expected);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, said, RECORDER_LINE_CHARACTERS);
    TEST_ASSERT_EQUAL_STRING("\r\n", &said[RECORDER_LINE_CHARACTERS]);
}

/* The recorder keeps its recording: what was sent is the copy in the flash. */
TEST(test_the_saved_recording_is_sent_line_by_line_to_its_end_each_time_it_is_asked_for)
{
    save_fault();
    const uint32_t lines = recorder_lines(box.file_words);

    for (uint32_t times = 0U; times < 2U; times++) {
        assert_says("ok\r\n", "last\n");
        for (uint32_t number = 0U; number < lines; number++) {
            assert_line_of_the_box(number, said_to(""));
        }
        assert_says("dump ends\r\n", "");
        assert_says("", "");
    }
    TEST_ASSERT_TRUE(recorder.held);
}

/* Two faults and a reset between them. */
static void fill_log(void)
{
    begin_box();
    fault_log_fault(&faults, &(fault_t){.id = FAULT_LATE, .value = 11, .limit = 10});
    fault_log_reset(&faults, (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 3U});
    faults.seconds = 7U;
    fault_log_fault(&faults, &(fault_t){.id = FAULT_OVERCURRENT, .value = 16384, .limit = -8192});
}

TEST(test_the_log_of_faults_is_sent_oldest_first_each_time_it_is_asked_for)
{
    fill_log();
    for (uint32_t times = 0U; times < 2U; times++) {
        assert_says("ok\r\n", "faults\n");
        assert_says("1: power-up 1, 0 s: LATE 11, limit 10\r\n", "");
        assert_says("2: power-up 1, 0 s: reset: watchdog after exception 3\r\n", "");
        assert_says("3: power-up 1, 7 s: OVERCURRENT 20.000 A, limit -10.000 A\r\n", "");
        assert_says("", "");
        TEST_ASSERT_EQUAL(CONSOLE_DUMP_NONE, console.dump_phase);
    }
}

static void send_to_the_end(void)
{
    for (uint32_t k = 0U; (k < LINES_MAX) && (console.dump_phase != CONSOLE_DUMP_NONE); k++) {
        (void)said_to("");
    }
    TEST_ASSERT_EQUAL(CONSOLE_DUMP_NONE, console.dump_phase);
}

/* While the answer to `first` is sent, nothing else is that would come between its lines. */
static void assert_sent_alone(const char *first)
{
    static const char *const others[] = {"last\n", "faults\n", "dump\n", "record\n", "identify\n"};

    assert_says("ok\r\n", first);
    const console_dump_t phase = console.dump_phase;

    for (uint32_t k = 0U; k < (sizeof others / sizeof others[0]); k++) {
        assert_says("error: a dump is under way\r\n", others[k]);
        TEST_ASSERT_EQUAL(phase, console.dump_phase);
    }
    send_to_the_end();
}

TEST(test_of_recordings_and_log_one_is_sent_at_a_time)
{
    save_fault();
    assert_sent_alone("last\n");
    assert_sent_alone("faults\n");
    assert_sent_alone("dump\n");
}
