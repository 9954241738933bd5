/* SPDX-License-Identifier: MIT */
/* The line: whose it is, each question with its answer, and a person who still has the console. */
#include "box.h"
#include "commander.h"
#include "drive_words.h"
#include "example_app.h"
#include "flash_model.h"
#include "frame_code.h"
#include "link.h"
#include "link_line.h"
#include "testing.h"

#define HELP \
    "error: the commands are run, stop, clear, speed RPM, torque NM, zero, unlock, status, dump, record, last, faults, identify\r\n"
#define TICKS_OF_PAUSE (20000U) /* 2 s at 10 kHz */
#define PASSES_ALONE (100000U)  /* where no tick runs */
#define PASSES_PAUSE (2000000U)
#define SHORT_WHILE (100U) /* enough for any answer */

static about_t of_image;
static live_config_t live;
static link_t serial;
static recorder_t recorder;
static recorder_entry_t entries[RECORDER_SEGMENTS * RECORDER_ENTRIES_MIN];
static uint8_t tag;

static void pass(void)
{
    control_isr(&app);
    recorder_service(&recorder, &app.drive);
    link_step(&serial);
}

static void passes(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        pass();
    }
}

static void start(void)
{
    static const uint32_t build[RECORDER_BUILD_WORDS] = {0x03020100U, 0x07060504U, 0x0B0A0908U,
                                                         0x0F0E0D0CU, 0x13121110U};

    of_image = ABOUT;
    of_image.identity = (config_identity_t){.schema = 0x33333333U, .board = 0x44444444U};
    of_image.baud = 921600U;
    of_image.build = build;
    live_config_init(&live, &app, &hardware, &of_image, &cfg);
    link_init(&serial, &live);
    TEST_ASSERT_NULL(app_init(&app, &hardware, &live.in_force->cfg));
    TEST_ASSERT_NULL(recorder_init(&recorder, entries, RECORDER_ENTRIES_MIN, 8U));
    app_record(&app, &recorder);
}

/* The line is a person's. */
static void begin(void)
{
    flash_new(0U);
    line_new();
    memset(&app, 0, sizeof app);
    memset(&serial, 0xA5, sizeof serial);
    power_on();
    start();
    passes(EXAMPLE_CALIBRATION_TICKS);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    line_listen();
    tag = 40U;
}

/* What comes within so many passes. */
static void hear(uint32_t count)
{
    passes(count);
    line_listen();
}

/* The answer to a question, behind type and tag; exactly one comes. */
static const line_message_t *ask(uint8_t type, const void *body, uint32_t length)
{
    tag++;
    line_ask(type, tag, body, length);
    hear(SHORT_WHILE);
    const line_message_t *const answer = line_find((uint8_t)(type + LINK_ANSWER));

    if (answer != NULL) {
        TEST_ASSERT_EQUAL_UINT8(tag, answer->bytes[1]);
    }
    return answer;
}

static const uint8_t HELLO[] = {LINK_VERSION, 0x78U, 0x56U, 0x34U, 0x12U};

/* The answer. */
static const line_message_t *hello(void)
{
    const line_message_t *const answer = ask(LINK_HELLO, HELLO, sizeof HELLO);

    TEST_ASSERT_NOT_NULL(answer);
    TEST_ASSERT_TRUE(serial.is_linked);
    return answer;
}

/* The line is the PC's. */
void setUp(void)
{
    begin();
    (void)hello();
}

/* The verdict that came for such a question; "" when it is done. */
static const char *verdict_on(uint8_t type)
{
    static char text[LINK_MESSAGE_BYTES_MAX];
    const line_message_t *const answer = line_find((uint8_t)(type + LINK_ANSWER));

    TEST_ASSERT_NOT_NULL(answer);
    TEST_ASSERT_EQUAL_HEX32(commander_ticket(&app), words_get(&answer->bytes[2]));
    memcpy(text, &answer->bytes[6], answer->length - 6U);
    text[answer->length - 6U] = '\0';
    return text;
}

static void assert_verdict(const char *expected, uint8_t type, const void *body, uint32_t length)
{
    (void)ask(type, body, length);
    TEST_ASSERT_EQUAL_STRING(expected, verdict_on(type));
}

/* With the ticket that counts. */
static void put_command(uint8_t body[10], uint8_t request, uint8_t mode, int32_t target)
{
    body[0] = request;
    body[1] = mode;
    words_put(&body[2], (uint32_t)target);
    words_put(&body[6], commander_ticket(&app));
}

static void assert_command(const char *expected, uint8_t request, uint8_t mode, int32_t target)
{
    uint8_t body[10];

    put_command(body, request, mode, target);
    assert_verdict(expected, LINK_COMMAND, body, sizeof body);
}

static void assert_stream(const char *expected, uint8_t on)
{
    assert_verdict(expected, LINK_STREAM, &on, 1U);
}

#define LINE_BODY (LINK_MESSAGE_BYTES_MAX)

/* The ticket that counts, and a line. Returns its length. */
static uint32_t put_line(uint8_t body[LINE_BODY], const char *typed)
{
    const uint32_t length = (uint32_t)strlen(typed);

    words_put(body, commander_ticket(&app));
    memcpy(&body[4], typed, length);
    return length + 4U;
}

static void ask_line(uint8_t with_tag, const char *typed)
{
    uint8_t body[LINE_BODY];
    const uint32_t length = put_line(body, typed);

    line_ask(LINK_LINE, with_tag, body, length);
}

static void assert_line(const char *typed)
{
    uint8_t body[LINE_BODY];
    const uint32_t length = put_line(body, typed);

    assert_verdict("", LINK_LINE, body, length);
}

static void assert_text(const char *expected, const char *typed)
{
    line_type(typed);
    hear(SHORT_WHILE);
    TEST_ASSERT_EQUAL_STRING(expected, line.text);
}

TEST(test_what_the_line_does_not_take_waits_and_what_does_not_fit_is_cut)
{
    begin();
    line.room = 3U;
    assert_text("ok\r", "stop\n");
    line.room = SIZE_MAX;
    assert_text("\n", "");
    line.room = 0U;
    for (uint32_t k = 0U; k < (TEXT_MAX / 4U); k++) {
        assert_text("", "stop\n");
    }
    line.room = SIZE_MAX;
    hear(SHORT_WHILE);
    TEST_ASSERT_EQUAL_size_t(TEXT_MAX, line.text_length);
    assert_text("ok\r\n", "stop\n");
}

TEST(test_a_hello_makes_the_line_the_pcs_and_is_answered_with_the_identity)
{
    begin();
    const line_message_t *const answer = hello();
    const uint8_t *const body = &answer->bytes[2];

    TEST_ASSERT_EQUAL_UINT32(2U + LINK_IDENTITY_BYTES, answer->length);
    TEST_ASSERT_EQUAL_UINT8(LINK_VERSION, body[0]);
    TEST_ASSERT_EQUAL_HEX8(LINK_CAN_STREAM | LINK_CAN_STORE, body[1]);
    TEST_ASSERT_EQUAL_UINT32(drive_words_count() | (CONFIG_BLOCK_WORDS << 16U),
                             words_get(&body[2]));
    TEST_ASSERT_EQUAL_UINT8(RECORDER_ENTRIES_MIN, body[6]);
    TEST_ASSERT_EQUAL_UINT8(0U, body[7]);
    TEST_ASSERT_EQUAL_HEX32(0x33333333U, words_get(&body[8]));
    TEST_ASSERT_EQUAL_HEX32(0x44444444U, words_get(&body[12]));
    TEST_ASSERT_EQUAL_UINT32(100000000U, words_get(&body[16]));
    TEST_ASSERT_EQUAL_UINT32(921600U, words_get(&body[20]));
    TEST_ASSERT_EQUAL_UINT32(20000000U, words_get(&body[24]));
    TEST_ASSERT_EQUAL_UINT32(450000000U, words_get(&body[28]));
    for (uint32_t k = 0U; k < 20U; k++) {
        TEST_ASSERT_EQUAL_UINT8(k, body[32U + k]);
    }
    TEST_ASSERT_EQUAL_HEX32(commander_ticket(&app), words_get(&body[52]));
}

TEST(test_a_board_without_recorder_and_build_id_says_so)
{
    const uint8_t segment[7] = {1U, 0U, 0U, 0U, 0U, 0U, 9U};

    of_image.build = NULL;
    live_config_init(&live, &app, &hardware, &of_image, &cfg);
    link_init(&serial, &live);
    app.recorder = NULL;
    const uint8_t *const body = &hello()->bytes[2];
    TEST_ASSERT_EQUAL_HEX8(LINK_CAN_STORE, body[1]);
    TEST_ASSERT_EQUAL_UINT8(0U, body[6]);
    TEST_ASSERT_EACH_EQUAL_UINT8(0U, &body[32], 20U);
    assert_stream("there is no recorder", 1U);
    TEST_ASSERT_EQUAL_UINT32(9U, ask(LINK_STATE, segment, 7U)->length);
    TEST_ASSERT_EQUAL_UINT32(9U, ask(LINK_AGAIN, segment, 7U)->length);
}

TEST(test_a_board_whose_flash_cannot_be_read_says_that_it_cannot_store)
{
    for (uint32_t slot = 0U; slot < HAL_STORE_SLOTS; slot++) {
        for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
            flash.units[slot][unit].half_done = true;
            flash.units[slot][unit].half = HAL_HOST_FLASH_UNREADABLE;
        }
    }
    TEST_ASSERT_EQUAL_HEX8(LINK_CAN_STREAM, hello()->bytes[3]);
}

/* The last frame goes out whole before a person is written to. */
TEST(test_an_answer_to_a_bye_is_whole_on_a_slow_line)
{
    line.room = 3U;
    line_ask(LINK_BYE, 9U, NULL, 0U);
    passes(2U);
    TEST_ASSERT_FALSE(serial.is_linked);
    line_type("stop\n");
    passes(SHORT_WHILE);
    line.room = SIZE_MAX;
    hear(SHORT_WHILE);
    TEST_ASSERT_NOT_NULL(line_find(LINK_BYE + LINK_ANSWER));
    TEST_ASSERT_EQUAL_STRING("ok\r\n", line.text);
}

TEST(test_no_question_but_a_hello_makes_the_line_the_pcs)
{
    begin();
    for (uint8_t type = 0U; type < 16U; type++) {
        if (type != LINK_HELLO) {
            TEST_ASSERT_NULL(ask(type, NULL, 0U));
            TEST_ASSERT_FALSE(serial.is_linked);
            TEST_ASSERT_EQUAL_UINT32(0U, line.count);
        }
    }
    assert_text("ok\r\n", "stop\n");
}

TEST(test_a_line_that_was_begun_when_the_pc_came_is_forgotten)
{
    begin();
    line_type("ru");
    hello();
    TEST_ASSERT_EQUAL_UINT32(2U, ask(LINK_BYE, NULL, 0U)->length);
    TEST_ASSERT_FALSE(serial.is_linked);
    assert_text(HELP, "n\n");
    TEST_ASSERT_EQUAL_UINT32(0U, line.count);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

TEST(test_text_that_is_on_its_way_goes_on_in_frames)
{
    begin();
    line.room = 3U;
    line_type("stop\n");
    pass();
    line.room = SIZE_MAX;
    hello();
    TEST_ASSERT_EQUAL_STRING("ok\r", line.text);
    TEST_ASSERT_EQUAL_STRING("\n", line_said());
}

TEST(test_two_seconds_without_a_frame_give_the_line_back_and_not_less)
{
    passes(TICKS_OF_PAUSE - (2U * SHORT_WHILE));
    TEST_ASSERT_NOT_NULL(ask(LINK_PING, NULL, 0U));
    passes(TICKS_OF_PAUSE - (2U * SHORT_WHILE));
    TEST_ASSERT_TRUE(serial.is_linked);
    passes(2U * SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.is_linked);
    line_listen();
    assert_text("ok\r\n", "stop\n");
}

/* What is no frame does not count as one. */
TEST(test_broken_frames_do_not_keep_the_line)
{
    static const uint8_t ping[] = {LINK_PING, 1U};

    for (uint32_t k = 0U; k < 250U; k++) {
        line_frame(ping, sizeof ping, 1U);
        passes(SHORT_WHILE);
    }
    TEST_ASSERT_FALSE(serial.is_linked);
    line_listen();
    TEST_ASSERT_EQUAL_UINT32(0U, line.count);
}

/* As a cable makes it that is plugged in. */
TEST(test_a_zero_without_a_frame_keeps_a_person_away_for_a_tenth_of_a_second)
{
    begin();
    line_byte(0U);
    assert_text("", "stop\n");
    passes(1001U);
    assert_text("ok\r\n", "stop\n");
}

/* A 0x00, so many ticks later a line of a person, and what is said to that. */
static void assert_behind_a_zero(const char *expected, uint32_t ticks)
{
    begin();
    line_byte(0U);
    passes(ticks);
    assert_text(expected, "stop\n");
}

TEST(test_a_zero_keeps_a_person_away_for_a_tenth_of_a_second_to_the_tick)
{
    const uint32_t tenth = 1000U; /* at 10 kHz */

    assert_behind_a_zero("", tenth);
    assert_behind_a_zero("ok\r\n", tenth + 1U);
}

/* A person is kept away by it anyway. */
TEST(test_a_frame_of_the_pc_that_stops_half_way_for_longer_is_whole_all_the_same)
{
    const size_t behind_the_pause = 3U;

    tag++;
    line_ask(LINK_PING, tag, NULL, 0U);
    line.in_length -= behind_the_pause;
    passes(2U * 1001U);
    line.in_length += behind_the_pause;
    hear(SHORT_WHILE);
    TEST_ASSERT_NOT_NULL(line_find(LINK_PING + LINK_ANSWER));
}

TEST(test_a_frame_that_is_broken_leaves_the_console_as_it_is)
{
    static const uint8_t message[] = {LINK_HELLO, 1U, LINK_VERSION, 0U, 0U, 0U, 0U};

    begin();
    line_frame(message, sizeof message, 1U);
    assert_text("ok\r\n", "stop\n");
    TEST_ASSERT_FALSE(serial.is_linked);
}

TEST(test_a_ping_is_answered_with_the_health)
{
    hardware.health = (hal_health_t){
        .adc_ic = 0x1234U, .late_ticks = 0x01020304U, .load_pct = 250U, .tick_lost = true};
    hardware.reset = (hal_reset_t){.reason = HAL_RESET_WATCHDOG, .exception = 300U};
    serial.stream.lost = 0x0A0B0C0DU;
    const line_message_t *const answer = ask(LINK_PING, NULL, 0U);
    const uint8_t *const body = &answer->bytes[2];

    TEST_ASSERT_EQUAL_UINT32(2U + LINK_HEALTH_BYTES, answer->length);
    TEST_ASSERT_EQUAL_UINT8(100U, body[0]);
    TEST_ASSERT_EQUAL_UINT8(1U, body[1]);
    TEST_ASSERT_EQUAL_HEX32(0x03041234U, words_get(&body[2]));
    TEST_ASSERT_EQUAL_HEX32(0x0C0D0102U, words_get(&body[6]));
    TEST_ASSERT_EQUAL_UINT8(HAL_RESET_WATCHDOG, body[12]);
    TEST_ASSERT_EQUAL_UINT8(255U, body[13]);
    TEST_ASSERT_EQUAL_HEX32(commander_ticket(&app), words_get(&body[14]));
}

TEST(test_the_health_says_who_commands_and_why_the_input_is_lost)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_INPUT));
    TEST_ASSERT_EQUAL_UINT8(0x06U, ask(LINK_PING, NULL, 0U)->bytes[3]);
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    live.in_force->cfg.input = example_input_cfg();
    serial.input.kind = (uint8_t)INPUT_KIND_VOLTAGE;
    serial.input.signal.lost = (uint8_t)INPUT_LOST_HIGH;
    TEST_ASSERT_EQUAL_UINT8(0x04U | (4U << 3U), ask(LINK_PING, NULL, 0U)->bytes[3]);
}

TEST(test_a_message_of_a_wrong_length_or_no_type_is_refused_and_does_nothing)
{
    static const struct {
        uint8_t type;
        uint8_t length;
    } right[] = {{LINK_HELLO, 5U},    {LINK_BYE, 0U},    {LINK_PING, 0U},  {LINK_COMMAND, 10U},
                 {LINK_READ, 3U},     {LINK_WRITE, 7U},  {LINK_APPLY, 4U}, {LINK_STORE, 0U},
                 {LINK_DEFAULTS, 0U}, {LINK_STREAM, 1U}, {LINK_STATE, 7U}, {LINK_AGAIN, 7U},
                 {LINK_BOX, 4U}};
    static const uint8_t none[] = {0U, LINK_BOX + 1U, 0x7FU, 0x80U, 0xC0U, 0xFFU};
    uint8_t body[11] = {1U, 0U, 1U};

    for (uint32_t k = 0U; k < (sizeof right / sizeof right[0]); k++) {
        for (uint32_t length = 0U; length < sizeof body; length++) {
            if (length != right[k].length) {
                TEST_ASSERT_NULL(ask(right[k].type, body, length));
                TEST_ASSERT_NOT_NULL(line_find(LINK_REFUSED));
                TEST_ASSERT_EQUAL_UINT8(tag, line_find(LINK_REFUSED)->bytes[1]);
                TEST_ASSERT_EQUAL_UINT8(right[k].type, line_find(LINK_REFUSED)->bytes[2]);
            }
        }
    }
    for (uint32_t length = 0U; length < 4U; length++) {
        TEST_ASSERT_NULL_MESSAGE(ask(LINK_LINE, body, length), "a line without a ticket");
    }
    for (uint32_t k = 0U; k < sizeof none; k++) {
        line_ask(none[k], 1U, NULL, 0U);
        passes(SHORT_WHILE);
        line_listen();
        TEST_ASSERT_EQUAL_UINT8(none[k], line_find(LINK_REFUSED)->bytes[2]);
    }
    TEST_ASSERT_TRUE(serial.is_linked);
    TEST_ASSERT_FALSE(serial.stream.on);
}

TEST(test_a_command_reaches_the_drive_as_a_whole)
{
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, EXAMPLE_SPEED_STEP);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, app.in.command.target);
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_POSITION, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_POSITION, app.in.command.mode);
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_TORQUE, -commander_torque_max(&app));
    TEST_ASSERT_EQUAL_INT32(-commander_torque_max(&app), app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_TORQUE, app.in.command.mode);
    assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

TEST(test_a_command_that_is_refused_changes_nothing)
{
    const char *const too_fast = "the speed is beyond that of the motor";
    const char *const request =
        "the requests are 0, stop, 1, run, 2, clear, and 9, run with zero here";

    assert_command("", 0U, DRIVE_MODE_SPEED, 77);
    assert_command(too_fast, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, EXAMPLE_SPEED_STEP + 1);
    assert_command(too_fast, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, -EXAMPLE_SPEED_STEP - 1);
    assert_command(too_fast, DRIVE_REQUEST_CLEAR, DRIVE_MODE_SPEED, INT32_MIN);
    assert_command("the modes are 0, speed, 1, position, and 2, torque", DRIVE_REQUEST_RUN, 3U, 0);
    assert_command("the torque is beyond that of the motor", DRIVE_REQUEST_RUN, DRIVE_MODE_TORQUE,
                   commander_torque_max(&app) + 1);
    assert_command("the torque is beyond that of the motor", DRIVE_REQUEST_RUN, DRIVE_MODE_TORQUE,
                   INT32_MIN);
    assert_command(request, DRIVE_REQUEST_PROBE, DRIVE_MODE_SPEED, 0);
    assert_command(request, 3U, DRIVE_MODE_SPEED, 0);
    assert_command("there is no fault to clear", DRIVE_REQUEST_CLEAR, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_EQUAL_INT32(77, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
}

TEST(test_a_latched_fault_is_not_run_and_is_cleared_by_a_command)
{
    fail();
    assert_command("a fault is latched; clear it first", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 0);
    assert_command("", DRIVE_REQUEST_CLEAR, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

TEST(test_while_the_motor_is_measured_only_a_stop_is_taken)
{
    assert_line("identify");
    TEST_ASSERT_TRUE(identify_is_busy(&serial.console.identify));
    for (uint8_t request = DRIVE_REQUEST_RUN; request <= (DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO);
         request++) {
        uint8_t body[10];

        put_command(body, request, (uint8_t)DRIVE_MODE_SPEED, 0);
        (void)ask(LINK_COMMAND, body, sizeof body);
        TEST_ASSERT_TRUE(verdict_on(LINK_COMMAND)[0] != '\0');
        TEST_ASSERT_TRUE(identify_is_busy(&serial.console.identify));
    }
    assert_command("the motor is being measured; stop ends that", DRIVE_REQUEST_RUN,
                   DRIVE_MODE_SPEED, 0);
    assert_verdict("the motor is being measured; stop ends that", LINK_DEFAULTS, NULL, 0U);
    TEST_ASSERT_TRUE(identify_is_busy(&serial.console.identify));
    assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_FALSE(identify_is_busy(&serial.console.identify));
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

TEST(test_a_line_is_done_by_the_console_whose_answer_comes_as_text)
{
    assert_line("speed 1000");
    TEST_ASSERT_EQUAL_STRING("ok\r\n", line_said());
    TEST_ASSERT_EQUAL_STRING("", line.text + line.text_length);
    assert_line("status");
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "READY, speed unknown, asked 1000 rpm, "));
    assert_line("");
    TEST_ASSERT_EQUAL_STRING("", line_said());
    assert_line("a line that is longer than a line of the console may be, and no command");
    TEST_ASSERT_EQUAL_STRING(HELP, line_said());
}

TEST(test_a_change_of_state_is_said_in_frames)
{
    fail();
    hear(SHORT_WHILE);
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "FAULT by BREAK"));
}

static void read_words(uint32_t first, uint32_t count, uint32_t expected)
{
    const uint8_t body[] = {(uint8_t)(first & 0xFFU), (uint8_t)(first >> 8U), (uint8_t)count};
    const line_message_t *const answer = ask(LINK_READ, body, sizeof body);

    TEST_ASSERT_NOT_NULL(answer);
    TEST_ASSERT_EQUAL_UINT32(5U + (4U * expected), answer->length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(body, &answer->bytes[2], 2U);
    TEST_ASSERT_EQUAL_UINT8(expected, answer->bytes[4]);
    for (uint32_t k = 0U; k < expected; k++) {
        TEST_ASSERT_EQUAL_HEX32(config_block_word(live.in_force, first + k),
                                words_get(&answer->bytes[5U + (4U * k)]));
    }
}

TEST(test_the_block_in_force_is_read_as_far_as_it_goes)
{
    for (uint32_t first = 0U; first < CONFIG_BLOCK_WORDS; first += LINK_READ_WORDS_MAX) {
        const uint32_t left = CONFIG_BLOCK_WORDS - first;

        read_words(first, 255U, (left < LINK_READ_WORDS_MAX) ? left : LINK_READ_WORDS_MAX);
    }
    read_words(CONFIG_BLOCK_WORDS, 1U, 0U);
    read_words(65535U, 32U, 0U);
    read_words(3U, 0U, 0U);
    read_words(3U, 1U, 1U);
}

/* All words that differ from those in force, then the apply; its verdict. */
static const char *change_to(const drive_cfg_t *settings)
{
    const config_block_t *const now = live.in_force;
    drive_cfg_t sealed = *settings;
    config_block_t wanted;
    uint8_t crc[4];

    sealed.crc = config_guard_crc(&sealed);
    config_block_make(&wanted, &now->identity, &now->about, &sealed);
    for (uint32_t at = 0U; at < CONFIG_BLOCK_WORDS; at++) {
        uint8_t body[7] = {(uint8_t)(at & 0xFFU), (uint8_t)(at >> 8U), 1U};

        if (config_block_word(&wanted, at) != config_block_word(now, at)) {
            words_put(&body[3], config_block_word(&wanted, at));
            assert_verdict("", LINK_WRITE, body, sizeof body);
        }
    }
    words_put(crc, sealed.crc);
    (void)ask(LINK_APPLY, crc, sizeof crc);
    return verdict_on(LINK_APPLY);
}

TEST(test_a_gain_is_changed_while_the_motor_runs_and_the_image_comes_back)
{
    drive_cfg_t settings = live.in_force->cfg;

    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    settings.observer.kappa_p++;
    TEST_ASSERT_EQUAL_STRING("", change_to(&settings));
    TEST_ASSERT_EQUAL_INT32(settings.observer.kappa_p, app.drive.cfg->observer.kappa_p);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
    assert_verdict("", LINK_DEFAULTS, NULL, 0U);
    TEST_ASSERT_EQUAL_INT32(cfg.observer.kappa_p, app.drive.cfg->observer.kappa_p);
}

TEST(test_a_setting_that_cannot_change_in_run_is_named)
{
    drive_cfg_t settings = live.in_force->cfg;

    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    settings.speed_shift++;
    TEST_ASSERT_EQUAL_STRING("speed_shift cannot change while the drive runs; stop the drive first",
                             change_to(&settings));
    assert_verdict("the drive does not rest with open gates; stop it first", LINK_STORE, NULL, 0U);
}

static void assert_locked(void)
{
    drive_cfg_t settings = live.in_force->cfg;

    settings.supervision.late_max++;
    TEST_ASSERT_EQUAL_STRING(
        "supervision.late_max protects less than what is in force; stop the drive and unlock first",
        change_to(&settings));
}

TEST(test_what_one_session_has_unlocked_is_locked_for_the_next)
{
    assert_line("unlock");
    (void)ask(LINK_BYE, NULL, 0U);
    TEST_ASSERT_FALSE(app.unlocked);
    hello();
    assert_locked();
    assert_line("unlock");
    passes(TICKS_OF_PAUSE + SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.is_linked);
    TEST_ASSERT_FALSE(app.unlocked);
    hello();
    assert_locked();
    assert_line("unlock");
    hello(); /* a PC that begins anew without a word of farewell */
    assert_locked();
}

TEST(test_the_block_in_force_is_stored)
{
    drive_cfg_t settings = live.in_force->cfg;

    settings.observer.kappa_p++;
    TEST_ASSERT_EQUAL_STRING("", change_to(&settings));
    const config_block_t wanted = *live.in_force;
    TEST_ASSERT_EQUAL_INT32(settings.observer.kappa_p, wanted.cfg.observer.kappa_p);
    assert_verdict("", LINK_STORE, NULL, 0U);
    live_config_init(&live, &app, &hardware, &of_image, &cfg);
    TEST_ASSERT_EQUAL_MEMORY(&wanted, live.in_force, sizeof wanted);
}

TEST(test_a_store_that_comes_again_stores_once)
{
    drive_cfg_t settings = live.in_force->cfg;

    settings.observer.kappa_p++;
    TEST_ASSERT_EQUAL_STRING("", change_to(&settings));
    assert_verdict("", LINK_STORE, NULL, 0U);
    for (uint32_t slot = 0U; slot < 2U; slot++) {
        TEST_ASSERT_TRUE(hal_store_erase(&hardware, slot));
    }
    tag--;
    assert_verdict("", LINK_STORE, NULL, 0U);
    live_config_init(&live, &app, &hardware, &of_image, &cfg);
    TEST_ASSERT_EQUAL_INT32(cfg.observer.kappa_p, live.in_force->cfg.observer.kappa_p);
}

TEST(test_words_beyond_the_block_are_refused_by_their_verdict)
{
    static const uint32_t first[] = {CONFIG_BLOCK_WORDS - 1U, 0xFFFFU};

    for (uint32_t k = 0U; k < 2U; k++) {
        const uint8_t body[11] = {(uint8_t)(first[k] & 0xFFU), (uint8_t)(first[k] >> 8U), 2U};

        assert_verdict("the block has no such word", LINK_WRITE, body, sizeof body);
    }
}

static void assert_entries_of_a_message(uint8_t most)
{
    assert_stream("", most);
    hear(300U);
    TEST_ASSERT_NOT_NULL(line_find(LINK_FRAMES));
    for (uint32_t k = 0U; k < line.count; k++) {
        if (line.messages[k].bytes[0] == (uint8_t)LINK_FRAMES) {
            TEST_ASSERT_LESS_OR_EQUAL_UINT8(most, line.messages[k].bytes[8]);
        }
    }
}

TEST(test_a_stream_of_short_messages_has_as_many_entries_as_were_asked_for_at_most)
{
    const uint8_t least = 2U; /* 1 asks for full ones */

    assert_entries_of_a_message(least);
    assert_entries_of_a_message(5U);
}

TEST(test_a_stream_sends_segments_and_frames_until_it_is_ended)
{
    assert_stream("", 1U);
    hear(1000U);
    TEST_ASSERT_NOT_NULL(line_find(LINK_SEGMENT));
    TEST_ASSERT_NOT_NULL(line_find(LINK_FRAMES));
    assert_stream("", 0U);
    hear(1000U);
    TEST_ASSERT_EQUAL_UINT32(0U, line.count);
}

TEST(test_a_stream_ends_with_the_link_and_a_fault_is_recorded_again)
{
    assert_stream("", 1U);
    TEST_ASSERT_NOT_NULL(ask(LINK_BYE, NULL, 0U));
    TEST_ASSERT_FALSE(serial.stream.on);
    hello();
    assert_stream("", 1U);
    passes(TICKS_OF_PAUSE + SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.stream.on);
    fail();
    passes(200U);
    TEST_ASSERT_TRUE(recorder.frozen);
}

/* Another PC, or the same one anew: it has not asked for it. */
TEST(test_a_hello_ends_the_stream_of_before)
{
    assert_stream("", 1U);
    hello();
    TEST_ASSERT_FALSE(serial.stream.on);
    hear(1000U);
    TEST_ASSERT_EQUAL_UINT32(0U, line.count);
}

/* Whoever wrote them is gone: the words that are there may be of any block. */
TEST(test_a_hello_ends_the_preparation_of_a_block)
{
    uint8_t word[7] = {30U, 0U, 1U};
    uint8_t crc[4];

    words_put(crc, live.in_force->cfg.crc);
    words_put(&word[3], config_block_word(live.in_force, 30U));
    assert_verdict("", LINK_WRITE, word, sizeof word);
    hello();
    assert_verdict("no block was prepared", LINK_APPLY, crc, sizeof crc);
}

TEST(test_a_recording_of_a_fault_is_kept_and_no_stream_begins_before_it_is_given_up)
{
    const char *const kept = "the recording of a fault is kept until it is read";

    fail();
    passes(1U); /* before it is frozen, too */
    assert_stream(kept, 1U);
    passes(200U);
    assert_stream(kept, 1U);
    assert_line(
        "record"); /* it stays frozen until the drive leaves FAULT, but nobody waits for it */
    assert_stream("", 1U);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
}

/*
 * A run, some other message, and what comes between them; then the run once more, as a line that
 * delays makes of it.
 */
static void assert_late_run(const char *between)
{
    uint8_t body[10];

    put_command(body, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    assert_verdict("", LINK_COMMAND, body, sizeof body);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
    if (between != NULL) {
        assert_line(between);
    } else {
        assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    }
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    assert_verdict(COMMANDER_STALE, LINK_COMMAND, body, sizeof body);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

TEST(test_a_run_that_comes_again_behind_a_stop_starts_nothing)
{
    assert_late_run(NULL);
    assert_late_run("stop");
}

TEST(test_a_run_of_before_a_hello_starts_nothing)
{
    uint8_t body[10];

    put_command(body, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    hello();
    assert_verdict(COMMANDER_STALE, LINK_COMMAND, body, sizeof body);
    (void)ask(LINK_BYE, NULL, 0U);
    hello();
    assert_verdict(COMMANDER_STALE, LINK_COMMAND, body, sizeof body);
}

/*
 * An adapter may hold a message back while the board is switched off and on. Each session of a PC
 * has another salt.
 */
TEST(test_a_run_of_before_the_board_was_switched_off_starts_nothing)
{
    static const uint8_t again[] = {LINK_VERSION, 0x79U, 0x56U, 0x34U, 0x12U};
    uint8_t body[10];

    put_command(body, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    begin();
    TEST_ASSERT_NOT_NULL(ask(LINK_HELLO, again, sizeof again));
    assert_verdict(COMMANDER_STALE, LINK_COMMAND, body, sizeof body);
}

/*
 * The line was a person's meanwhile. The hello is the same, as a line that delays makes of it, and
 * makes no ticket itself.
 */
TEST(test_a_run_of_before_a_pause_starts_nothing)
{
    uint8_t body[10];

    put_command(body, DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    passes(TICKS_OF_PAUSE + SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.is_linked);
    tag--;
    hello();
    assert_verdict(COMMANDER_STALE, LINK_COMMAND, body, sizeof body);
}

/* The first answer may still come, with a ticket that has to count. */
TEST(test_a_hello_that_comes_again_makes_no_other_ticket)
{
    hello();
    const uint32_t ticket = commander_ticket(&app);

    tag--;
    hello();
    TEST_ASSERT_EQUAL_HEX32(ticket, commander_ticket(&app));
    hello();
    TEST_ASSERT_NOT_EQUAL_HEX32(ticket, commander_ticket(&app));
}

TEST(test_a_line_that_comes_late_commands_nothing_unless_it_is_a_stop)
{
    static const char *const commands[] = {"run", "speed 30", "torque 0.1", "clear", "identify"};
    uint8_t body[LINE_BODY];
    uint32_t length;

    for (uint32_t k = 0U; k < (sizeof commands / sizeof commands[0]); k++) {
        length = put_line(body, commands[k]);
        assert_line("stop");
        assert_verdict("", LINK_LINE, body, length);
        TEST_ASSERT_EQUAL_STRING("error: " COMMANDER_STALE "\r\n", line_said());
        TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    }
    length = put_line(body, "stop");
    assert_line("run");
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
    assert_verdict("", LINK_LINE, body, length);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

/* Its answer was lost: the PC asks again with the same tag. */
TEST(test_a_question_that_comes_again_is_done_once_and_answered_as_before)
{
    uint8_t body[10];

    fail();
    passes(SHORT_WHILE);
    put_command(body, DRIVE_REQUEST_CLEAR, DRIVE_MODE_SPEED, 0);
    assert_verdict("", LINK_COMMAND, body, sizeof body);
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
    tag--;
    assert_verdict("", LINK_COMMAND, body, sizeof body);
    put_command(body, DRIVE_REQUEST_CLEAR, DRIVE_MODE_SPEED, 0);
    assert_verdict("there is no fault to clear", LINK_COMMAND, body, sizeof body);
    tag--;
    assert_verdict("there is no fault to clear", LINK_COMMAND, body, sizeof body);
    hello();
    tag = (uint8_t)(tag - 2U); /* of another session */
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
}

TEST(test_a_line_that_comes_again_is_typed_once)
{
    uint8_t body[LINE_BODY];
    const uint32_t length = put_line(body, "speed 30");

    assert_verdict("", LINK_LINE, body, length);
    (void)commander_set_speed(&app, SOURCE_LINK, 77);
    tag--;
    assert_verdict("", LINK_LINE, body, length);
    TEST_ASSERT_EQUAL_INT32(77, command_mailbox_take(&app.mailbox).target);
    assert_line("speed 30");
    TEST_ASSERT_NOT_EQUAL_INT32(77, command_mailbox_take(&app.mailbox).target);
}

/* A PC that counts its tags wrong, or an old message between two of them. */
TEST(test_a_stop_with_the_tag_of_the_run_before_it_stops)
{
    hello();
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
    tag--;
    assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

/* Whoever has started the motor meanwhile. */
TEST(test_a_stop_that_comes_again_is_obeyed_again)
{
    hello();
    assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    command_mailbox_post(&app.mailbox, &(drive_command_t){.request = DRIVE_REQUEST_RUN});
    passes(SHORT_WHILE);
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_READY, app.drive.state);
    tag--;
    assert_command("", 0U, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_EQUAL(DRIVE_STATE_READY, app.drive.state);
}

#define DUMPS "a dump is under way; ask again when it has ended"

/* The one of before ends as well: whoever asked knows of none from now on. */
TEST(test_no_stream_begins_or_goes_on_while_a_dump_is_under_way)
{
    const uint8_t on = 1U;

    assert_stream("", on);
    ask_line(1U, "dump");
    line_ask(LINK_STREAM, 2U, &on, 1U);
    hear(20U * SHORT_WHILE);
    TEST_ASSERT_EQUAL_STRING(DUMPS, verdict_on(LINK_STREAM));
    TEST_ASSERT_FALSE(serial.stream.on);
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "dump ends"));
}

#define WORD_BODY (7U)
#define CRC_BODY (4U)

/* A word of the block and its CRC, as they are in force. */
static void put_change(uint8_t word[WORD_BODY], uint8_t crc[CRC_BODY])
{
    const uint32_t at = 30U; /* any word */

    word[0] = (uint8_t)at;
    word[1] = 0U;
    word[2] = 1U;
    words_put(&word[3], config_block_word(live.in_force, at));
    words_put(crc, live.in_force->cfg.crc);
}

static void ask_about_the_block(void)
{
    uint8_t word[WORD_BODY];
    uint8_t crc[CRC_BODY];

    put_change(word, crc);
    line_ask(LINK_WRITE, 2U, word, sizeof word);
    line_ask(LINK_APPLY, 3U, crc, sizeof crc);
    line_ask(LINK_DEFAULTS, 4U, NULL, 0U);
    line_ask(LINK_STORE, 5U, NULL, 0U);
}

static void assert_block_stays(const char *why)
{
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", verdict_on(LINK_STORE), "a store is no change");
    TEST_ASSERT_EQUAL_STRING(why, verdict_on(LINK_WRITE));
    TEST_ASSERT_EQUAL_STRING(why, verdict_on(LINK_APPLY));
    TEST_ASSERT_EQUAL_STRING(why, verdict_on(LINK_DEFAULTS));
}

static void assert_block_changes(void)
{
    uint8_t word[WORD_BODY];
    uint8_t crc[CRC_BODY];

    put_change(word, crc);
    assert_verdict("", LINK_WRITE, word, sizeof word);
    assert_verdict("", LINK_APPLY, crc, sizeof crc);
}

/* The dump reads the block that is not in force, where the words would go. */
TEST(test_no_block_is_changed_while_a_dump_is_under_way)
{
    ask_line(1U, "dump");
    ask_about_the_block();
    hear(20U * SHORT_WHILE);
    assert_block_stays(DUMPS);
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "dump ends"));
    assert_block_changes();
}

TEST(test_a_segments_state_is_read_in_pieces)
{
    uint8_t body[7] = {0U, 0U, 0U, 0U, 0U, 0U, LINK_READ_WORDS_MAX};
    recorder_view_t view = {0};
    drive_t copy = {0};

    for (uint32_t first = 0U; first < drive_words_count(); first += LINK_READ_WORDS_MAX) {
        const uint32_t number = recorder_newest(&recorder);

        words_put(body, number);
        body[4] = (uint8_t)(first & 0xFFU);
        body[5] = (uint8_t)(first >> 8U);
        line_ask(LINK_STATE, 1U, body, sizeof body);
        link_step(&serial);
        line_listen();
        TEST_ASSERT_TRUE(recorder_find(&recorder, number, &view));
        const line_message_t *const answer = line_find(LINK_STATE + LINK_ANSWER);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(body, &answer->bytes[2], 6U);
        for (uint32_t k = 0U; k < answer->bytes[8]; k++) {
            drive_words_set(&copy, first + k, words_get(&answer->bytes[9U + (4U * k)]));
        }
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(view.state), drive_words_hash(&copy));
}

/* A slow line takes longer for the pieces than the ring has the segment. */
TEST(test_a_state_that_is_being_read_stays_when_the_ring_has_lost_its_segment)
{
    uint8_t body[7] = {0U, 0U, 0U, 0U, LINK_READ_WORDS_MAX, 0U, LINK_READ_WORDS_MAX};
    recorder_view_t view = {0};
    const uint32_t number = recorder_newest(&recorder);

    words_put(body, number);
    const uint32_t length = ask(LINK_STATE, body, 7U)->length;
    passes((RECORDER_SEGMENTS + 1U) * RECORDER_ENTRIES_MIN);
    TEST_ASSERT_FALSE(recorder_find(&recorder, number, &view));
    TEST_ASSERT_EQUAL_UINT32(9U + (4U * LINK_READ_WORDS_MAX), length);
    TEST_ASSERT_EQUAL_UINT32(length, ask(LINK_STATE, body, 7U)->length);
}

TEST(test_a_segment_that_is_not_there_has_no_state_and_no_entries)
{
    uint8_t body[7] = {0xFFU, 0xFFU, 0xFFU, 0x7FU, 0U, 0U, 9U};

    TEST_ASSERT_EQUAL_UINT32(9U, ask(LINK_STATE, body, 7U)->length);
    TEST_ASSERT_EQUAL_UINT32(9U, ask(LINK_AGAIN, body, 7U)->length);
}

TEST(test_entries_are_sent_again)
{
    uint8_t body[7] = {0U, 0U, 0U, 0U, 0U, 0U, 9U};
    recorder_entry_t decoded[FRAME_CODE_ENTRIES_MAX];

    words_put(body, recorder_newest(&recorder) - 1U);
    line_ask(LINK_AGAIN, 1U, body, sizeof body);
    link_step(&serial);
    line_listen();
    const line_message_t *const answer = line_find(LINK_AGAIN + LINK_ANSWER);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(body, &answer->bytes[2], sizeof body);
    TEST_ASSERT_TRUE(frame_code_decode(&answer->bytes[9], answer->length - 9U, decoded, 9U));
}

static void with_timeout(uint32_t timeout)
{
    drive_cfg_t settings = live.in_force->cfg;

    settings.link.timeout_ticks = timeout;
    TEST_ASSERT_EQUAL_STRING("", change_to(&settings));
}

TEST(test_a_silent_pc_brings_the_motor_to_rest_when_the_configuration_says_so)
{
    with_timeout(500U);
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 1000000);
    passes(400U - SHORT_WHILE);
    TEST_ASSERT_EQUAL_INT32(1000000, app.in.command.target);
    passes(250U);
    TEST_ASSERT_EQUAL_INT32(0, app.in.command.target);
    line_listen();
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "the link is silent: the drive stops\r\n"));
}

TEST(test_without_a_timeout_a_motor_runs_on_when_the_pc_is_gone)
{
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 0);
    passes(2U * TICKS_OF_PAUSE);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
}

/* At speed 0: no motor turns behind these inputs, and another one would be a fault. */
static void lose_the_pc_in_run(void)
{
    with_timeout(TICKS_OF_PAUSE + 5000U);
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 0);
    hear(TICKS_OF_PAUSE + SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.is_linked);
}

/* The PC is gone, and the line is a person's, who commands the drive himself. */
TEST(test_a_person_who_commands_the_drive_ends_the_watching_for_the_pc)
{
    lose_the_pc_in_run();
    assert_text("ok\r\n", "speed 0\n");
    passes(6000U);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command_mailbox_take(&app.mailbox).request);
}

/* Who looks, or asks for what is refused, has not taken the motor over. */
TEST(test_a_line_that_does_not_command_the_drive_leaves_it_watched)
{
    lose_the_pc_in_run();
    line_type("status\nspeed 999999\nx\n");
    passes(6000U);
    TEST_ASSERT_EQUAL_UINT8(0U, command_mailbox_take(&app.mailbox).request);
}

/* ---- a person who types nothing ---- */

#define TYPED_TIMEOUT (1000U)

/*
 * The line is a person's, and that person has started the motor. At speed 0: no motor turns behind
 * these inputs.
 */
static void run_by_a_person(void)
{
    drive_cfg_t settings = live.in_force->cfg;

    settings.console.timeout_ticks = TYPED_TIMEOUT;
    TEST_ASSERT_EQUAL_STRING("", change_to(&settings));
    TEST_ASSERT_NOT_NULL(ask(LINK_BYE, NULL, 0U));
    line_type("speed 0\nrun\n");
    hear(200U);
    TEST_ASSERT_EQUAL(SOURCE_CONSOLE, commander_source(&app));
}

TEST(test_the_motor_of_a_person_who_types_nothing_comes_to_rest_and_that_is_said)
{
    run_by_a_person();
    passes(TYPED_TIMEOUT - 300U);
    TEST_ASSERT_EQUAL(SOURCE_CONSOLE, commander_source(&app));
    hear(400U);
    TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
    TEST_ASSERT_NOT_NULL(
        strstr(line.text, "nothing is typed: the drive stops; Enter keeps it running\r\n"));
}

TEST(test_enter_keeps_the_motor_of_a_person_running)
{
    run_by_a_person();
    for (uint32_t k = 0U; k < 5U; k++) {
        passes(TYPED_TIMEOUT - 300U);
        line_type("\n");
        hear(10U);
        TEST_ASSERT_EQUAL(SOURCE_CONSOLE, commander_source(&app));
    }
}

/* A PC has taken the motor over, and has a time-out of its own. */
TEST(test_a_person_whose_motor_a_pc_has_taken_is_not_waited_for)
{
    run_by_a_person();
    hello();
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 0);
    passes(2U * TYPED_TIMEOUT);
    TEST_ASSERT_EQUAL(SOURCE_LINK, commander_source(&app));
}

/* In this time nobody is heard, and the link lasts. */
#define SHORT_TIMEOUT (500U)

/* Somebody else runs the motor. */
static void run_by_another(void)
{
    command_mailbox_post(&app.mailbox, &(drive_command_t){.request = DRIVE_REQUEST_RUN});
}

static void assert_request_behind_the_timeout(uint8_t expected)
{
    passes(SHORT_TIMEOUT + (4U * SHORT_WHILE));
    line_listen();
    TEST_ASSERT_EQUAL_UINT8(expected, command_mailbox_take(&app.mailbox).request);
}

TEST(test_a_pc_that_takes_its_leave_is_not_waited_for)
{
    with_timeout(SHORT_TIMEOUT);
    assert_command("", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED, 0);
    TEST_ASSERT_NOT_NULL(ask(LINK_BYE, NULL, 0U));
    assert_request_behind_the_timeout(DRIVE_REQUEST_RUN);
}

TEST(test_a_pc_whose_command_is_refused_is_not_waited_for)
{
    with_timeout(SHORT_TIMEOUT);
    run_by_another();
    assert_command("the speed is beyond that of the motor", DRIVE_REQUEST_RUN, DRIVE_MODE_SPEED,
                   EXAMPLE_SPEED_STEP + 1);
    assert_request_behind_the_timeout(DRIVE_REQUEST_RUN);
}

TEST(test_a_line_of_the_pc_is_a_command_to_wait_for_only_if_it_commands_the_drive)
{
    with_timeout(SHORT_TIMEOUT);
    run_by_another();
    assert_line("status");
    assert_request_behind_the_timeout(DRIVE_REQUEST_RUN);
    assert_line("speed 0");
    assert_request_behind_the_timeout(0U);
}

TEST(test_a_question_waits_while_a_frame_is_on_its_way)
{
    line.room = 0U;
    line_ask(LINK_PING, 1U, NULL, 0U);
    passes(2U);
    line_ask(LINK_PING, 2U, NULL, 0U);
    line_ask(LINK_PING, 3U, NULL, 0U);
    passes(2U);
    line.room = SIZE_MAX;
    hear(SHORT_WHILE);
    TEST_ASSERT_EQUAL_UINT32(3U, line.count);
    for (uint32_t k = 0U; k < 3U; k++) {
        TEST_ASSERT_EQUAL_UINT8(k + 1U, line.messages[k].bytes[1]);
    }
}

static void start_without_ticks(void)
{
    memset(&app, 0, sizeof app);
    hardware.ticks = 0U;
    link_init(&serial, &live);
}

static void passes_without_ticks(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        link_step(&serial);
    }
    line_listen();
}

/* The configuration was refused, and the application never began: it is zero. */
TEST(test_a_board_that_does_not_start_is_asked_why_all_the_same)
{
    start_without_ticks();
    link_say(&serial, "cannot start:");
    line_ask(LINK_HELLO, 1U, HELLO, sizeof HELLO);
    line_ask(LINK_PING, 2U, NULL, 0U);
    ask_line(3U, "status");
    line_ask(LINK_DEFAULTS, 4U, NULL, 0U);
    passes_without_ticks(SHORT_WHILE);
    TEST_ASSERT_NOT_NULL(line_find(LINK_HELLO + LINK_ANSWER));
    TEST_ASSERT_NOT_NULL(line_find(LINK_DEFAULTS + LINK_ANSWER));
    TEST_ASSERT_NOT_NULL(strstr(line_said(), "INIT, speed"));
}

TEST(test_without_ticks_a_zero_does_not_keep_a_person_away_for_ever)
{
    start_without_ticks();
    line_byte(0U);
    passes_without_ticks(PASSES_ALONE);
    line_type("stop\n");
    passes_without_ticks(SHORT_WHILE);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", line.text, "a frame may still come");
    line_new();
    passes_without_ticks(PASSES_ALONE + 2U);
    line_type("stop\n");
    passes_without_ticks(SHORT_WHILE);
    TEST_ASSERT_EQUAL_STRING("ok\r\n", line.text);
}

TEST(test_without_ticks_a_pc_that_is_gone_gives_the_line_back_and_one_that_asks_keeps_it)
{
    start_without_ticks();
    line_ask(LINK_HELLO, 1U, HELLO, sizeof HELLO);
    passes_without_ticks(PASSES_PAUSE - SHORT_WHILE);
    line_ask(LINK_PING, 2U, NULL, 0U);
    passes_without_ticks(PASSES_PAUSE - SHORT_WHILE);
    TEST_ASSERT_TRUE(serial.is_linked);
    line_frame(HELLO, sizeof HELLO, 1U); /* broken: nobody is heard by it */
    passes_without_ticks(2U * SHORT_WHILE);
    TEST_ASSERT_FALSE(serial.is_linked);
}

/* ---- an input ---- */

#define REST_COUNT (2048U) /* of the potentiometer of example_input_cfg(): its middle */
#define HALF_COUNT (3000U)
#define LOST_INPUT "the input is lost: its voltage is below its range: the drive stops\r\n"

static void passes_with_throttle(uint32_t count, uint32_t throttle)
{
    hardware.inputs.throttle = (uint16_t)throttle;
    for (uint32_t k = 0U; k < count; k++) {
        hardware.inputs.conversions++;
        pass();
    }
}

/* With so flat a slope that the target stays 0: no motor turns behind these inputs. */
static void run_by_the_input(void)
{
    power_on();
    cfg.input = example_input_cfg();
    cfg.input.slope_q30 = 1;
    cfg.crc = config_guard_crc(&cfg);
    start();
    passes(EXAMPLE_CALIBRATION_TICKS);
    passes_with_throttle(cfg.input.arm_ticks + (4U * SHORT_WHILE), REST_COUNT);
    passes_with_throttle(4U * SHORT_WHILE, HALF_COUNT);
    TEST_ASSERT_EQUAL(SOURCE_INPUT, commander_source(&app));
}

TEST(test_the_loss_of_the_input_that_runs_the_motor_is_said_once_with_its_reason)
{
    run_by_the_input();
    line_listen();
    passes_with_throttle(cfg.input.timeout_ticks, 0U);
    line_listen();
    TEST_ASSERT_EQUAL_STRING("", line.text);
    passes_with_throttle(cfg.input.timeout_ticks, 0U);
    line_listen();
    TEST_ASSERT_EQUAL_STRING_LEN(LOST_INPUT, line.text, strlen(LOST_INPUT));
    TEST_ASSERT_NULL(strstr(&line.text[strlen(LOST_INPUT)], "is lost"));
    TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
}

/* ---- the black box ---- */

#define SAVING_PASSES_MAX (2000U) /* more than a place of the box has units */

static fault_log_t log_;
static box_t box;

static void begin_box(void)
{
    box_init(&box, &app, &hardware, &live.about, &log_, true);
}

static uint32_t word_of_the_box(uint8_t part, uint32_t at)
{
    return (part == LINK_BOX_LOG) ? fault_log_word(&log_, at) : box_word(&box, at);
}

static void assert_read_in_pieces(uint8_t part, uint32_t words)
{
    for (uint32_t first = 0U; first < words; first += LINK_READ_WORDS_MAX) {
        const uint32_t left = words - first;
        const uint32_t count = (left < LINK_READ_WORDS_MAX) ? left : LINK_READ_WORDS_MAX;
        const uint8_t body[] = {part, (uint8_t)(first & 0xFFU), (uint8_t)(first >> 8U),
                                LINK_READ_WORDS_MAX};
        const line_message_t *const answer = ask(LINK_BOX, body, sizeof body);

        TEST_ASSERT_EQUAL_UINT32(3U + (4U * count), answer->length - 2U);
        TEST_ASSERT_EQUAL_UINT32(count, answer->bytes[4]);
        for (uint32_t k = 0U; k < count; k++) {
            TEST_ASSERT_EQUAL_HEX32(word_of_the_box(part, first + k),
                                    words_get(&answer->bytes[5U + (4U * k)]));
        }
    }
}

/* To where the box writes the recording of a fault. */
static void begin_saving(void)
{
    begin_box();
    fail();
    for (uint32_t k = 0U; (k < SAVING_PASSES_MAX) && (box.phase != BOX_WRITES); k++) {
        pass();
    }
    TEST_ASSERT_EQUAL(BOX_WRITES, box.phase);
}

static void end_saving(void)
{
    for (uint32_t k = 0U; (k < SAVING_PASSES_MAX) && box_is_saving(&box); k++) {
        pass();
    }
    TEST_ASSERT_TRUE(box_has_saved(&box));
}

TEST(test_log_and_recording_of_the_black_box_are_read_in_pieces)
{
    begin_saving();
    end_saving();
    TEST_ASSERT_EQUAL_HEX32(RECORDER_MAGIC, box_word(&box, 0U));
    assert_read_in_pieces(LINK_BOX_LOG, FAULT_LOG_WORDS);
    assert_read_in_pieces(LINK_BOX_RECORDING, box.file_words);
    app.box = NULL;
}

/* The box reads the block that is not in force, if the recording began with it. */
TEST(test_no_block_is_changed_while_the_recording_of_a_fault_is_saved)
{
    begin_saving();
    ask_about_the_block();
    hear(SHORT_WHILE);
    TEST_ASSERT_TRUE(box_is_saving(&box));
    assert_block_stays("the recording of a fault is being saved; ask again");
    end_saving();
    assert_block_changes();
    app.box = NULL;
}

TEST(test_without_a_recording_a_box_or_a_known_part_there_are_no_words)
{
    const uint8_t parts[] = {LINK_BOX_LOG, LINK_BOX_RECORDING, 9U};

    begin_box();
    for (uint32_t k = 1U; k < sizeof parts; k++) {
        const uint8_t body[] = {parts[k], 0U, 0U, 8U};

        TEST_ASSERT_EQUAL_UINT32(0U, ask(LINK_BOX, body, sizeof body)->bytes[4]);
    }
    app.box = NULL;
    const uint8_t body[] = {LINK_BOX_LOG, 0U, 0U, 8U};
    TEST_ASSERT_EQUAL_UINT32(0U, ask(LINK_BOX, body, sizeof body)->bytes[4]);
}

TEST(test_a_fault_is_noted_in_the_pass_that_sees_it_also_while_a_saved_recording_is_sent)
{
    static const console_dump_t phases[] = {CONSOLE_DUMP_NONE, CONSOLE_DUMP_SENT,
                                            CONSOLE_LAST_SENT};

    for (uint32_t k = 0U; k < (sizeof phases / sizeof phases[0]); k++) {
        start();
        begin_box();
        fault_log_init(&log_);
        app.drive.state = DRIVE_STATE_FAULT;
        app.drive.fault.id = FAULT_STALL;
        serial.console.dump_phase = phases[k];
        link_step(&serial);
        TEST_ASSERT_EQUAL_UINT32(1U, fault_log_size(&log_));
        app.box = NULL;
    }
}
