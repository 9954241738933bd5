/* SPDX-License-Identifier: MIT */
/*
 * Who commands, and how another takes over: every pair of sources with every event, by the rules in
 * words, and through the functions that carry it out.
 */
#include "commander.h"
#include "example_app.h"
#include "testing.h"

void setUp(void)
{
    power_on();
    calibrate();
}

/* The rules of source.h, written a second time. */
static source_result_t by_the_rules(source_t in_command, source_t of, source_event_t event)
{
    const bool beaten =
        (of == SOURCE_INPUT) && (in_command != SOURCE_INPUT) && (in_command != SOURCE_NONE);
    source_result_t result = SOURCE_TAKES;

    if (of == SOURCE_NONE) {
        result = SOURCE_REFUSES; /* it has no events */
    } else if (event == SOURCE_EVENT_STOP) {
        result = SOURCE_STOPS; /* a stop of any source */
    } else if (event == SOURCE_EVENT_LOST) {
        result = (of == in_command) ? SOURCE_RAMPS : SOURCE_REFUSES; /* what it commands itself */
    } else if (beaten) {
        result = SOURCE_REFUSES; /* a person or a PC beats a throttle */
    } else {
        /* the last command counts */
    }
    return result;
}

TEST(test_the_table_has_the_rules_for_every_pair_and_event)
{
    for (int in = 0; in < (int)SOURCES; in++) {
        for (int of = 0; of < (int)SOURCES; of++) {
            for (int event = 0; event < (int)SOURCE_EVENTS; event++) {
                TEST_ASSERT_EQUAL(by_the_rules((source_t)in, (source_t)of, (source_event_t)event),
                                  source_decide((source_t)in, (source_t)of, (source_event_t)event));
            }
        }
    }
}

static uint8_t request(void)
{
    return command_mailbox_take(&app.mailbox).request;
}

static int32_t target(void)
{
    return command_mailbox_take(&app.mailbox).target;
}

/* Brings a source in command, with speed 5; SOURCE_NONE: nobody runs the drive. */
static void put_in_command(source_t source)
{
    commander_begin_anew(&app);
    if (source != SOURCE_NONE) {
        TEST_ASSERT_TRUE(commander_set_speed(&app, source, 5));
        TEST_ASSERT_NULL(commander_run(&app, source));
    }
    TEST_ASSERT_EQUAL(source, commander_source(&app));
}

TEST(test_a_run_of_every_source_over_every_other)
{
    for (int in = 0; in < (int)SOURCES; in++) {
        for (int of = 1; of < (int)SOURCES; of++) {
            const bool may =
                by_the_rules((source_t)in, (source_t)of, SOURCE_EVENT_RUN) == SOURCE_TAKES;

            put_in_command((source_t)in);
            TEST_ASSERT_EQUAL(may, commander_run(&app, (source_t)of) == NULL);
            TEST_ASSERT_EQUAL(may ? of : in, commander_source(&app));
            TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_RUN, request());
        }
    }
}

TEST(test_a_target_of_every_source_over_every_other)
{
    for (int in = 1; in < (int)SOURCES; in++) {
        for (int of = 1; of < (int)SOURCES; of++) {
            const bool may =
                by_the_rules((source_t)in, (source_t)of, SOURCE_EVENT_TARGET) == SOURCE_TAKES;

            put_in_command((source_t)in);
            TEST_ASSERT_EQUAL(may, commander_set_speed(&app, (source_t)of, 77));
            TEST_ASSERT_EQUAL_INT32(may ? 77 : 5, target());
            TEST_ASSERT_EQUAL(may ? of : in, commander_source(&app));
            put_in_command((source_t)in);
            TEST_ASSERT_EQUAL(may, commander_set_torque(&app, (source_t)of, 99));
            TEST_ASSERT_EQUAL_INT32(may ? 99 : 5, target());
        }
    }
}

TEST(test_a_stop_of_every_source_stops_every_other)
{
    for (int in = 0; in < (int)SOURCES; in++) {
        for (int of = 1; of < (int)SOURCES; of++) {
            put_in_command((source_t)in);
            commander_stop(&app, (source_t)of);
            TEST_ASSERT_EQUAL_UINT8(0U, request());
            TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
        }
    }
}

TEST(test_a_command_of_the_link_takes_over_and_one_that_is_refused_does_not)
{
    const drive_command_t run = {.target = 9, .request = (uint8_t)DRIVE_REQUEST_RUN};

    put_in_command(SOURCE_INPUT);
    TEST_ASSERT_NOT_NULL(commander_command(&app, &run, false, 1000));
    TEST_ASSERT_EQUAL(SOURCE_INPUT, commander_source(&app));
    TEST_ASSERT_NULL(commander_command(&app, &run, true, 1000));
    TEST_ASSERT_EQUAL(SOURCE_LINK, commander_source(&app));
    TEST_ASSERT_EQUAL_INT32(9, target());
}

TEST(test_every_source_may_clear_a_fault)
{
    for (int of = 1; of < (int)SOURCES; of++) {
        fail();
        TEST_ASSERT_NULL(commander_clear(&app, (source_t)of));
        TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_CLEAR, request());
        TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
        tick_period();
        commander_step(&app);
        calibrate();
    }
}

/* Afterwards the input has to be seen at rest. What the input does itself is no upset to it. */
TEST(test_what_others_command_each_stop_and_each_fault_is_an_upset)
{
    for (int of = 1; of < (int)SOURCES; of++) {
        const uint32_t own = (of == (int)SOURCE_INPUT) ? 0U : 1U;
        uint32_t before = 0U;

        commander_begin_anew(&app);
        before = app.upsets;
        (void)commander_set_speed(&app, (source_t)of, 5);
        TEST_ASSERT_EQUAL_UINT32(before + own, app.upsets);
        TEST_ASSERT_NULL(commander_run(&app, (source_t)of));
        TEST_ASSERT_EQUAL_UINT32(before + (2U * own), app.upsets);
        commander_stop(&app, (source_t)of);
        TEST_ASSERT_EQUAL_UINT32(before + (2U * own) + 1U, app.upsets);
    }
    const uint32_t before = app.upsets;

    app.drive.state = DRIVE_STATE_FAULT;
    commander_step(&app);
    commander_step(&app);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, app.upsets);
}

TEST(test_a_fault_leaves_nobody_in_command)
{
    put_in_command(SOURCE_LINK);
    app.drive.state = DRIVE_STATE_FAULT;
    commander_step(&app);
    TEST_ASSERT_EQUAL(SOURCE_NONE, commander_source(&app));
}

TEST(test_each_source_has_a_name)
{
    TEST_ASSERT_EQUAL_STRING("nobody", source_name(SOURCE_NONE));
    TEST_ASSERT_EQUAL_STRING("console", source_name(SOURCE_CONSOLE));
    TEST_ASSERT_EQUAL_STRING("link", source_name(SOURCE_LINK));
    TEST_ASSERT_EQUAL_STRING("input", source_name(SOURCE_INPUT));
}
