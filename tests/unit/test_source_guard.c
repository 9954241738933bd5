/* SPDX-License-Identifier: MIT */
/* When nothing is heard of the PC: what stops, how, and what is left as it is. */
#include "commander.h"
#include "example_app.h"
#include "source_guard.h"
#include "testing.h"

#define TIMEOUT (50U)

static source_guard_t guard;
static identify_t identify;
static text_t text;

void setUp(void)
{
    power_on();
    calibrate();
    identify_init(&identify, &app, &ABOUT);
    guard = (source_guard_t){.source = SOURCE_LINK};
}

static bool pass(uint32_t at)
{
    return source_guard_step(&guard, &app, &identify, at, TIMEOUT);
}

/* A frame of the PC that commands the drive. */
static void command_at(uint32_t at)
{
    source_guard_commanded(&guard);
    source_guard_heard(&guard, at);
}

static drive_command_t command(void)
{
    return command_mailbox_take(&app.mailbox);
}

static void run(uint8_t mode)
{
    const drive_command_t asked = {
        .target = EXAMPLE_SPEED_STEP, .mode = mode, .request = DRIVE_REQUEST_RUN};

    command_mailbox_post(&app.mailbox, &asked);
    app.source = SOURCE_LINK;
    tick_period();
    tick(2U);
    TEST_ASSERT_EQUAL(DRIVE_STATE_RUN, app.drive.state);
}

/* As the drive's own speed: nothing turns behind these inputs. */
static void turn(step_t speed)
{
    app.drive.rotor.observer.speed = speed;
    TEST_ASSERT_EQUAL_INT32(speed, drive_speed(&app.drive));
}

/* The PC has commanded a run and is not heard any more. */
static void stop_as_silent(void)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    command_at(100U);
    TEST_ASSERT_TRUE(pass(101U + TIMEOUT));
}

TEST(test_the_speed_becomes_0_after_the_timeout_and_not_before)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    command_at(100U);
    TEST_ASSERT_FALSE(pass(100U + TIMEOUT));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
    TEST_ASSERT_TRUE(pass(101U + TIMEOUT));
    TEST_ASSERT_EQUAL_INT32(0, command().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
}

TEST(test_a_position_is_left_for_speed_0)
{
    run((uint8_t)DRIVE_MODE_POSITION);
    command_at(100U);
    TEST_ASSERT_TRUE(pass(101U + TIMEOUT));
    TEST_ASSERT_EQUAL_INT32(0, command().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, command().mode);
}

TEST(test_the_request_ends_when_the_motor_is_at_rest)
{
    const step_t least = cfg.speed_loop.speed_max / 256;

    stop_as_silent();
    turn(-least);
    TEST_ASSERT_FALSE(pass(102U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
    turn(-(least - 1));
    TEST_ASSERT_FALSE(pass(103U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(0U, command().request);
}

/* It would end a later request otherwise. */
TEST(test_a_request_that_somebody_else_has_ended_is_not_ended_again)
{
    stop_as_silent();
    turn(cfg.speed_loop.speed_max / 2);
    commander_stop(&app, SOURCE_LINK);
    TEST_ASSERT_FALSE(pass(102U + TIMEOUT));
    run((uint8_t)DRIVE_MODE_SPEED);
    turn(0);
    TEST_ASSERT_FALSE(pass(103U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
}

TEST(test_a_time_of_0_never_runs_out)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    command_at(100U);
    TEST_ASSERT_FALSE(source_guard_step(&guard, &app, &identify, 100U + 0x7FFFFFFFU, 0U));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
}

TEST(test_the_time_is_counted_across_the_wrap_of_the_ticks)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    command_at(UINT32_MAX - 10U);
    TEST_ASSERT_FALSE(pass(TIMEOUT - 11U));
    TEST_ASSERT_TRUE(pass(TIMEOUT));
}

TEST(test_without_a_pc_and_after_its_leave_nothing_is_watched)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    TEST_ASSERT_FALSE(pass(1000U));
    command_at(1000U);
    source_guard_leave(&guard);
    TEST_ASSERT_FALSE(pass(2000U));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
}

/* Somebody looks at a motor that another source runs. */
TEST(test_a_pc_that_only_reads_is_not_waited_for)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    source_guard_heard(&guard, 100U);
    TEST_ASSERT_FALSE(pass(101U + TIMEOUT));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
}

/* Frames that do not command are heard too. */
TEST(test_a_pc_that_goes_on_reading_keeps_its_command_alive)
{
    run((uint8_t)DRIVE_MODE_SPEED);
    command_at(100U);
    source_guard_heard(&guard, 140U);
    TEST_ASSERT_FALSE(pass(140U + TIMEOUT));
    TEST_ASSERT_TRUE(pass(141U + TIMEOUT));
}

/* A person starts the motor afterwards: nobody promised to be heard. */
TEST(test_a_stop_comes_once_and_the_next_command_watches_again)
{
    stop_as_silent();
    turn(0);
    (void)pass(102U + TIMEOUT);
    run((uint8_t)DRIVE_MODE_SPEED);
    turn(0);
    TEST_ASSERT_FALSE(pass(1000U));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
    command_at(1000U);
    TEST_ASSERT_TRUE(pass(1001U + TIMEOUT));
}

TEST(test_a_command_gives_a_stop_up)
{
    stop_as_silent();
    command_at(102U + TIMEOUT);
    turn(0);
    TEST_ASSERT_FALSE(pass(103U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
}

/* Somebody else has the motor now, and it may rest in that run. */
TEST(test_a_leave_gives_a_stop_up)
{
    stop_as_silent();
    source_guard_leave(&guard);
    turn(0);
    TEST_ASSERT_FALSE(pass(102U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
}

TEST(test_a_command_from_before_the_silence_does_not_count_behind_it)
{
    const uint32_t before = commander_ticket(&app);

    (void)commander_set_speed(&app, SOURCE_LINK, EXAMPLE_SPEED_STEP);
    command_at(100U);
    TEST_ASSERT_FALSE(pass(101U + TIMEOUT));
    TEST_ASSERT_FALSE(commander_take_ticket(&app, before));
}

TEST(test_a_drive_that_is_not_asked_to_run_is_left_alone)
{
    (void)commander_set_speed(&app, SOURCE_LINK, EXAMPLE_SPEED_STEP);
    command_at(100U);
    TEST_ASSERT_FALSE(pass(101U + TIMEOUT));
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, command().target);
    TEST_ASSERT_EQUAL_UINT8(0U, command().request);
}

/* The measurement that the source has begun ends at once, and says who is silent. */
static void measurement_ends(source_t source, const char *says)
{
    setUp();
    text.length = 0U;
    guard.source = source;
    TEST_ASSERT_NULL(identify_start(&identify));
    identify_step(&identify, &text);
    command_at(100U);
    tick_period();
    TEST_ASSERT_EQUAL(DRIVE_STATE_PROBE, app.drive.state);
    TEST_ASSERT_TRUE(pass(101U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(0U, command().request);
    text.length = 0U;
    identify_step(&identify, &text);
    TEST_ASSERT_EQUAL_STRING_LEN(says, text.characters, text.length);
    TEST_ASSERT_FALSE(identify_is_busy(&identify));
}

TEST(test_a_measurement_of_the_motor_ends_at_once_and_names_the_source)
{
    measurement_ends(SOURCE_LINK, "identify refused: the link is silent\r\n");
    measurement_ends(SOURCE_CONSOLE, "identify refused: nothing is typed\r\n");
    measurement_ends(SOURCE_INPUT, "identify refused: the input is silent\r\n");
}

/* It began to stop nothing that would have to come to rest. */
TEST(test_a_run_behind_a_measurement_that_was_ended_goes_on)
{
    TEST_ASSERT_NULL(identify_start(&identify));
    identify_step(&identify, &text);
    command_at(100U);
    TEST_ASSERT_TRUE(pass(101U + TIMEOUT));
    identify_step(&identify, &text);
    tick_period();
    run((uint8_t)DRIVE_MODE_SPEED);
    turn(0);
    TEST_ASSERT_FALSE(pass(102U + TIMEOUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, command().request);
}
