/* SPDX-License-Identifier: MIT */
/*
 * What the background asks of the drive: each changes its part of the command in force, or says why
 * it is refused.
 */
#include "commander.h"
#include "example_app.h"
#include "testing.h"

void setUp(void)
{
    power_on();
    calibrate();
}

static drive_command_t taken(void)
{
    tick_period();
    return app.in.command;
}

TEST(test_run_and_stop_leave_the_speed_and_the_mode)
{
    const drive_command_t before = {
        .target = -77, .mode = (uint8_t)DRIVE_MODE_POSITION, .request = 0U};

    command_mailbox_post(&app.mailbox, &before);
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
    TEST_ASSERT_EQUAL_INT32(-77, taken().target);
    commander_stop(&app, SOURCE_LINK);
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
    TEST_ASSERT_EQUAL_INT32(-77, taken().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_POSITION, taken().mode);
}

TEST(test_a_speed_leaves_the_request)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    (void)commander_set_speed(&app, SOURCE_LINK, EXAMPLE_SPEED_STEP);
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, taken().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
}

TEST(test_a_latched_fault_is_not_run_and_stays_until_it_is_cleared)
{
    fail();
    TEST_ASSERT_EQUAL_STRING("a fault is latched; clear it first",
                             commander_run(&app, SOURCE_LINK));
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    tick_period();
    TEST_ASSERT_NOT_EQUAL(DRIVE_STATE_FAULT, app.drive.state);
}

TEST(test_a_clear_is_in_force_until_the_fault_is_left_and_no_longer)
{
    fail();
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_CLEAR, taken().request);
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
}

TEST(test_where_there_is_no_fault_nothing_is_cleared)
{
    TEST_ASSERT_EQUAL_STRING("there is no fault to clear", commander_clear(&app, SOURCE_LINK));
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
}

TEST(test_a_run_is_not_taken_back)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
}

TEST(test_a_speed_ends_position_mode)
{
    const drive_command_t position = {
        .target = -77, .mode = (uint8_t)DRIVE_MODE_POSITION, .request = 0U};

    command_mailbox_post(&app.mailbox, &position);
    (void)commander_set_speed(&app, SOURCE_LINK, EXAMPLE_SPEED_STEP);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, taken().mode);
    TEST_ASSERT_EQUAL_INT32(EXAMPLE_SPEED_STEP, taken().target);
}

TEST(test_a_torque_ends_speed_mode_and_leaves_the_request)
{
    (void)commander_set_speed(&app, SOURCE_LINK, 77);
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    (void)commander_set_torque(&app, SOURCE_LINK, -123456);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_TORQUE, taken().mode);
    TEST_ASSERT_EQUAL_INT32(-123456, taken().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
}

/*
 * That of the largest current at the flux of the configuration; nothing before there is a
 * configuration.
 */
TEST(test_the_largest_torque_is_that_of_the_largest_current)
{
    app_t none = {.recorder = NULL};

    TEST_ASSERT_EQUAL_INT32(cfg.derating.current_max * cfg.current_loop.emf_q13,
                            commander_torque_max(&app));
    TEST_ASSERT_EQUAL_INT32(0, commander_torque_max(&none));
}

TEST(test_a_stop_is_taken_and_leaves_the_target_where_its_own_is_none)
{
    static const drive_command_t stops[] = {
        {.target = EXAMPLE_SPEED_STEP + 1, .mode = (uint8_t)DRIVE_MODE_SPEED},
        {.target = INT32_MIN, .mode = (uint8_t)DRIVE_MODE_SPEED},
        {.target = INT32_MAX, .mode = (uint8_t)DRIVE_MODE_TORQUE},
        {.target = 0, .mode = 3U},
        {.target = INT32_MAX, .mode = 255U},
        {.target = 77, .mode = (uint8_t)DRIVE_MODE_SPEED}};

    for (uint32_t k = 0U; k < (sizeof stops / sizeof stops[0]); k++) {
        (void)commander_set_speed(&app, SOURCE_LINK, 77);
        TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
        TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
        TEST_ASSERT_NULL(commander_command(&app, &stops[k], false, EXAMPLE_SPEED_STEP));
        TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
        TEST_ASSERT_EQUAL_INT32(77, taken().target);
        TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_SPEED, taken().mode);
    }
}

/* RUN as a PC asks for it, with this ticket. */
static const char *run_with(uint32_t ticket)
{
    const drive_command_t run = {
        .target = 77, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = (uint8_t)DRIVE_REQUEST_RUN};

    return commander_command(&app, &run, commander_take_ticket(&app, ticket), EXAMPLE_SPEED_STEP);
}

/* Whatever ends what was asked for. */
TEST(test_a_ticket_is_good_once_and_until_the_drive_is_commanded_or_fails)
{
    uint32_t ticket = commander_ticket(&app);

    TEST_ASSERT_NULL(run_with(ticket));
    TEST_ASSERT_EQUAL_STRING(COMMANDER_STALE, run_with(ticket));
    for (uint32_t k = 0U; k < 5U; k++) {
        ticket = commander_ticket(&app);
        if (k == 0U) {
            commander_stop(&app, SOURCE_LINK);
        } else if (k == 1U) {
            TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
        } else if (k == 2U) {
            commander_begin_anew(&app);
        } else if (k == 3U) {
            commander_renew_ticket(&app, 0xFFFFFFFEU);
        } else {
            TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
            ticket = commander_ticket(&app);
            app.drive.state = DRIVE_STATE_FAULT;
            commander_step(&app);
            app.drive.state = DRIVE_STATE_READY;
        }
        TEST_ASSERT_EQUAL_STRING(COMMANDER_STALE, run_with(ticket));
        TEST_ASSERT_NULL(run_with(commander_ticket(&app)));
    }
}

/* Whatever leaves FAULT then, nothing asks for a run. */
TEST(test_a_run_ends_with_a_fault)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_LINK));
    app.drive.state = DRIVE_STATE_FAULT;
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(DRIVE_REQUEST_CLEAR, taken().request, "until it is taken");
}

/* Who has cleared a fault goes on without another answer. */
TEST(test_a_clear_that_is_taken_back_leaves_the_ticket)
{
    app.drive.state = DRIVE_STATE_FAULT;
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_LINK));
    const uint32_t ticket = commander_ticket(&app);

    app.drive.state = DRIVE_STATE_READY;
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
    TEST_ASSERT_NULL(run_with(ticket));
}

/* The fault has just come, so the run of the console is still asked for. */
TEST(test_an_input_does_not_clear_the_fault_of_a_run_of_another)
{
    TEST_ASSERT_NULL(commander_run(&app, SOURCE_CONSOLE));
    tick_period();
    fail();
    TEST_ASSERT_EQUAL_STRING(COMMANDER_TAKEN, commander_clear(&app, SOURCE_INPUT));
    TEST_ASSERT_EQUAL(SOURCE_CONSOLE, commander_source(&app));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
    commander_step(&app); /* the fault has ended the run */
    TEST_ASSERT_NULL(commander_clear(&app, SOURCE_INPUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_CLEAR, taken().request);
}

/* ---- where positions count from ---- */

TEST(test_without_a_sensor_there_is_no_zero_at_rest)
{
    TEST_ASSERT_EQUAL_STRING("the rotor is not known at rest; a start counts from its own zero",
                             commander_zero(&app, SOURCE_CONSOLE));
    TEST_ASSERT_EQUAL_UINT8(0U, taken().request);
}

static void run_in(drive_mode_t mode, int32_t target)
{
    const drive_command_t asked = {
        .target = target, .mode = (uint8_t)mode, .request = (uint8_t)DRIVE_REQUEST_RUN};

    command_mailbox_post(&app.mailbox, &asked);
    tick_period();
    app.drive.state = DRIVE_STATE_RUN;
}

TEST(test_a_board_that_did_not_start_knows_no_rotor)
{
    run_in(DRIVE_MODE_SPEED, 0);
    app.drive.cfg = NULL;
    TEST_ASSERT_NOT_NULL(commander_zero(&app, SOURCE_CONSOLE));
    app.drive.cfg = &cfg;
    TEST_ASSERT_NULL(commander_zero(&app, SOURCE_CONSOLE));
}

TEST(test_a_zero_takes_the_command_from_whoever_has_it)
{
    static const source_t before[] = {SOURCE_NONE, SOURCE_CONSOLE, SOURCE_LINK, SOURCE_INPUT};

    for (uint32_t k = 0U; k < 8U; k++) {
        const source_t of = ((k / 4U) == 0U) ? SOURCE_CONSOLE : SOURCE_LINK;
        const uint32_t upsets = app.upsets;

        run_in(DRIVE_MODE_SPEED, 77);
        app.source = before[k % 4U];
        TEST_ASSERT_NULL(commander_zero(&app, of));
        TEST_ASSERT_EQUAL_INT(of, commander_source(&app));
        TEST_ASSERT_NOT_EQUAL_UINT32(upsets, app.upsets);
    }
}

TEST(test_an_input_sets_no_zero_in_the_run_of_another)
{
    run_in(DRIVE_MODE_SPEED, 77);
    app.source = SOURCE_CONSOLE;
    TEST_ASSERT_EQUAL_STRING(COMMANDER_TAKEN, commander_zero(&app, SOURCE_INPUT));
    TEST_ASSERT_EQUAL(SOURCE_CONSOLE, commander_source(&app));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
    app.source = SOURCE_INPUT;
    TEST_ASSERT_NULL(commander_zero(&app, SOURCE_INPUT));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO, taken().request);
}

TEST(test_a_zero_is_in_force_until_the_drive_has_taken_it_and_no_longer)
{
    run_in(DRIVE_MODE_SPEED, 77);
    TEST_ASSERT_NULL(commander_zero(&app, SOURCE_CONSOLE));
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO, taken().request);
    TEST_ASSERT_EQUAL_INT32(77, taken().target);
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
}

TEST(test_a_zero_in_position_mode_asks_the_drive_to_stay)
{
    run_in(DRIVE_MODE_POSITION, 77);
    TEST_ASSERT_NULL(commander_zero(&app, SOURCE_CONSOLE));
    TEST_ASSERT_EQUAL_INT32(0, taken().target);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_MODE_POSITION, taken().mode);
}

TEST(test_a_zero_that_is_not_taken_yet_outlives_the_next_command)
{
    const drive_command_t next = {
        .target = 5, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = (uint8_t)DRIVE_REQUEST_RUN};

    run_in(DRIVE_MODE_SPEED, 77);
    TEST_ASSERT_NULL(commander_zero(&app, SOURCE_CONSOLE));
    TEST_ASSERT_NULL(commander_command(&app, &next, true, EXAMPLE_SPEED_STEP));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO, taken().request);
    TEST_ASSERT_EQUAL_INT32(5, taken().target);
}

TEST(test_a_command_may_run_with_zero_here)
{
    const drive_command_t next = {.target = 5,
                                  .mode = (uint8_t)DRIVE_MODE_POSITION,
                                  .request = (uint8_t)(DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO)};

    run_in(DRIVE_MODE_POSITION, 77);
    TEST_ASSERT_NULL(commander_command(&app, &next, true, EXAMPLE_SPEED_STEP));
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN | DRIVE_REQUEST_ZERO, taken().request);
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, taken().request);
    TEST_ASSERT_EQUAL_INT32(5, taken().target);
}
