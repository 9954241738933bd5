/* SPDX-License-Identifier: MIT */
/*
 * Flight recorder: what it keeps is the run, however interrupt and background meet, also through
 * changes of the configuration; and a reader that follows the ring sees all of it.
 */
#define _POSIX_C_SOURCE 200809L /* signals and their timer */

#include "drive_words.h"
#include "recorded_run.h"
#include "recorder.h"
#include "testing.h"

#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <time.h>

#define LONG_RUN (5000U)

static recorded_run_t run;
static drive_cfg_t other_cfg; /* takes turns with run.cfg */

#define READ_SEGMENTS (64U)

/* What a reader has of each segment, by its number. */
static struct {
    recorder_entry_t entries[READ_SEGMENTS][RUN_SEGMENT_ENTRIES];
    uint32_t counts[READ_SEGMENTS];
} reader;

void setUp(void)
{
    recorded_run_start(&run);
    (void)memset(&reader, 0, sizeof(reader));
}

/* Configuration of a change in the history. */
static const drive_cfg_t *config_of(const recorder_history_t *history,
                                    const recorder_entry_t *change)
{
    const drive_cfg_t *const begin = recorder_begin_state(&run.recorder, history)->cfg;
    const drive_cfg_t *const further = recorder_further_config(&run.recorder, history);
    const drive_cfg_t *found = begin;

    if (change->word[3] != begin->crc) {
        TEST_ASSERT_NOT_NULL(further);
        found = further;
    }
    TEST_ASSERT_EQUAL_HEX32(change->word[3], found->crc);
    TEST_ASSERT_EQUAL_HEX32(config_guard_crc(found), found->crc);
    return found;
}

/* Runs the history again; how many ticks it has. */
static uint32_t replay(void)
{
    const recorder_history_t history = recorder_history(&run.recorder);
    drive_t drive = *recorder_begin_state(&run.recorder, &history);
    recorder_frame_t frame = {0};
    uint32_t ticks = 0U;

    for (uint32_t at = 0U; at < history.entries; at++) {
        const recorder_entry_t *const entry = recorder_entry(&run.recorder, &history, at);

        if (recorder_unpack(entry, &frame)) {
            drive_out_t out = {0};

            drive_step(&drive, &frame.in, &out);
            TEST_ASSERT_EQUAL_UINT16_ARRAY(out.compare.phase, frame.out.compare.phase, 3U);
            TEST_ASSERT_EQUAL_INT(out.gate_enable, frame.out.gate_enable);
            ticks++;
        } else if (entry->word[3] != drive.cfg->crc) {
            drive_change(&drive, config_of(&history, entry));
        } else {
            /* of the inputs */
        }
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(recorder_end_state(&run.recorder)),
                            drive_words_hash(&drive));
    return ticks;
}

/* Returns how many ticks the history has. */
static uint32_t fail_and_freeze(void)
{
    recorded_run_fail(&run);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, run.drive.state);
    recorded_run_ticks(&run, RUN_POST_TICKS + 1U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    return replay();
}

/* A long run that ends with a fault; how many ticks its history has. */
static uint32_t record_fault(void)
{
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_TRUE(run.out.gate_enable);
    const uint32_t ticks = fail_and_freeze();

    TEST_ASSERT_GREATER_THAN_UINT32(0U, ticks);
    return ticks;
}

/* The background does not come for so long that the segment is full. */
static void miss_background(void)
{
    for (uint32_t k = 0U; k < RUN_SEGMENT_ENTRIES; k++) {
        recorded_run_noise(&run);
        recorded_run_interrupt(&run);
    }
}

/*
 * The margin is left over in each segment, a change begins it, and the last one keeps the ticks of
 * a slow period free.
 */
TEST(test_all_but_one_segments_of_history_are_there_whenever_it_ends)
{
    const uint32_t ring = (RECORDER_SEGMENTS - 1U) * (RUN_SEGMENT_ENTRIES - RECORDER_MARGIN - 1U);
    const uint32_t least = ring - run.cfg.slow_ticks;

    for (uint32_t k = 0U; k < (2U * RUN_SEGMENT_ENTRIES); k += 7U) {
        setUp();
        recorded_run_ticks(&run, LONG_RUN + k);
        TEST_ASSERT_TRUE(run.out.gate_enable);
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(least, fail_and_freeze());
    }
}

TEST(test_freezes_after_the_fault_and_the_ticks_behind_it)
{
    recorded_run_ticks(&run, LONG_RUN);
    recorded_run_fail(&run);
    recorded_run_ticks(&run, RUN_POST_TICKS);
    TEST_ASSERT_FALSE(run.recorder.frozen);
    recorded_run_ticks(&run, 1U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(run.drive.fault.tick + RUN_POST_TICKS + 1U,
                             recorder_end_state(&run.recorder)->tick);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_EQUAL_UINT32(run.drive.fault.tick + RUN_POST_TICKS + 1U,
                             recorder_end_state(&run.recorder)->tick);
}

/* A fault is seen even if it is there before anything was recorded, or comes again at once. */
TEST(test_fault_in_the_first_tick_is_recorded)
{
    run.in.adc_bus = 4095U;
    recorded_run_interrupt(&run);
    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, run.drive.state);
    recorded_run_ticks(&run, RUN_POST_TICKS + 3U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, replay());
}

static void clear(void)
{
    run.in.command.request = DRIVE_REQUEST_CLEAR;
    recorded_run_ticks(&run, 2U);
    run.in.command.request = DRIVE_REQUEST_RUN;
}

TEST(test_what_was_read_is_there_again_until_the_fault_is_left_and_then_it_begins_anew)
{
    const uint32_t ticks = record_fault();

    recorder_release(&run.recorder);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(ticks, replay());
    clear();
    TEST_ASSERT_FALSE(run.recorder.frozen);
    (void)record_fault();
    TEST_ASSERT_GREATER_THAN_UINT32(2U * LONG_RUN, recorder_end_state(&run.recorder)->tick);
}

TEST(test_a_recording_of_a_fault_stays_until_it_is_released)
{
    const uint32_t ticks = record_fault();

    clear();
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(ticks, replay());
    recorder_release(&run.recorder);
    recorded_run_ticks(&run, 1U);
    TEST_ASSERT_FALSE(run.recorder.frozen);
}

TEST(test_holding_freezes_without_a_fault)
{
    recorded_run_ticks(&run, LONG_RUN);
    recorder_hold(&run.recorder, &run.drive);
    recorded_run_ticks(&run, 2U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_RUN, recorder_end_state(&run.recorder)->state);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, replay());
}

/* After a fault the ticks behind it belong to the recording. */
TEST(test_holding_does_not_cut_off_what_follows_a_fault)
{
    recorded_run_ticks(&run, LONG_RUN);
    recorded_run_fail(&run);
    recorder_hold(&run.recorder, &run.drive);
    recorded_run_ticks(&run, RUN_POST_TICKS + 1U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(run.drive.fault.tick + RUN_POST_TICKS + 1U,
                             recorder_end_state(&run.recorder)->tick);
}

/* The background comes in every other tick, at random: within the margin it does. */
TEST(test_history_is_the_run_with_a_background_that_comes_irregularly)
{
    seeded_t chance = {99U};

    for (uint32_t round = 0U; round < 20U; round++) {
        setUp();
        for (uint32_t k = 0U; k < LONG_RUN; k++) {
            const bool away = seeded_in(&chance, 0, 1) != 0;

            recorded_run_noise(&run);
            recorded_run_interrupt(&run);
            if (!away) {
                recorder_service(&run.recorder, &run.drive);
            }
        }
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(2U * (RUN_SEGMENT_ENTRIES - RECORDER_MARGIN),
                                            fail_and_freeze());
    }
}

/* The next tick of the drive goes unrecorded, as if it had come while the state was copied. */
TEST(test_snapshot_of_another_tick_is_rejected)
{
    const uint32_t current = run.recorder.current;

    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_TRUE(run.recorder.offered);
    recorded_run_noise(&run);
    drive_step(&run.drive, &run.in, &run.out);
    recorded_run_interrupt(&run);
    TEST_ASSERT_FALSE(run.recorder.offered);
    TEST_ASSERT_EQUAL_UINT32(current, run.recorder.current);
    (void)record_fault();
}

/* First and last word of the state that change in a tick. */
static void interrupt_by_signal(int number)
{
    volatile drive_t *const live = &run.drive;

    (void)number;
    live->tick++;
    live->fault.tick = live->tick;
}

static timer_t start_interrupts(long period_ns)
{
    const struct itimerspec period = {{0, period_ns}, {0, period_ns}};
    struct sigaction action = {.sa_handler = interrupt_by_signal};
    timer_t timer;

    TEST_ASSERT_EQUAL_INT(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL_INT(0, timer_create(CLOCK_MONOTONIC, NULL, &timer));
    TEST_ASSERT_EQUAL_INT(0, timer_settime(timer, 0, &period, NULL));
    return timer;
}

/* A timer's signal comes between any two instructions, as an interrupt does. */
TEST(test_offered_is_only_a_state_that_no_tick_came_into)
{
    const timer_t timer = start_interrupts(100000L);
    const time_t start = time(NULL);
    recorder_t *const recorder = &run.recorder;
    uint32_t offers = 0U;
    uint32_t rejected = 0U;

    run.drive.fault.tick = run.drive.tick;
    while (((offers < 100U) || (rejected < 10U)) && (difftime(time(NULL), start) < 60.0)) {
        recorder->offered = false;
        recorder_service(recorder, &run.drive);
        if (recorder->offered) {
            const drive_t *const state = &recorder->states[recorder->next];

            TEST_ASSERT_EQUAL_UINT32(recorder->next_tick, state->tick);
            TEST_ASSERT_EQUAL_UINT32(recorder->next_tick, state->fault.tick);
            offers++;
        } else {
            rejected++;
        }
    }
    TEST_ASSERT_EQUAL_INT(0, timer_delete(timer));
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(100U, offers);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(10U, rejected);
}

TEST(test_an_open_offer_stays_as_it_is_until_a_tick_decides)
{
    drive_t offered;

    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_TRUE(run.recorder.offered);
    offered = run.recorder.states[run.recorder.next];
    run.drive.motion.speed_reference++;
    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_TRUE(run.recorder.offered);
    TEST_ASSERT_EQUAL_INT32(offered.motion.speed_reference,
                            run.recorder.states[run.recorder.next].motion.speed_reference);
}

TEST(test_offer_that_came_too_late_does_not_end_a_segment)
{
    recorded_run_ticks(&run, 2U);
    const uint32_t current = run.recorder.current;
    while (!run.recorder.offered) {
        recorded_run_ticks(&run, 1U);
    }
    drive_step(&run.drive, &run.in, &run.out);
    recorded_run_interrupt(&run);
    TEST_ASSERT_EQUAL_UINT32(current, run.recorder.current);
    TEST_ASSERT_FALSE(run.recorder.offered);
}

/* Without a background the segment fills up; what follows begins after the gap. */
TEST(test_history_begins_behind_a_gap)
{
    recorded_run_ticks(&run, LONG_RUN);
    miss_background();
    const uint32_t first = run.drive.tick;
    recorded_run_ticks(&run, 30U);
    TEST_ASSERT_GREATER_THAN_UINT32(30U, fail_and_freeze());
    const recorder_history_t history = recorder_history(&run.recorder);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(first, recorder_begin_state(&run.recorder, &history)->tick);
}

TEST(test_commands_and_temperature_change_in_the_tick_in_which_the_drive_reads_them)
{
    seeded_t chance = {7U};

    for (uint32_t k = 0U; k < LONG_RUN; k++) {
        recorded_run_noise(&run);
        run.in.angle = (uint16_t)seeded_in(&chance, 0, 1);
        run.in.adc_temperature = (uint16_t)(700 + seeded_in(&chance, 0, 1));
        if (drive_reads_slow_inputs(&run.drive)) {
            run.in.command.target = seeded_in(&chance, -2, 2) * 1000000;
            run.in.command.mode = (uint8_t)seeded_in(&chance, 0, 255);
        }
        recorded_run_interrupt(&run);
        recorder_service(&run.recorder, &run.drive);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, fail_and_freeze());
}

static recorder_frame_t recorded(const drive_in_t *in, const drive_out_t *out)
{
    recorder_frame_t frame;

    setUp();
    (void)memset(&frame, 0x55, sizeof(frame));
    recorder_service(&run.recorder, &run.drive);
    run.drive.tick++;
    recorder_step(&run.recorder, &run.drive, in, out);
    TEST_ASSERT_FALSE(recorder_unpack(&run.entries[0], &frame));
    TEST_ASSERT_TRUE(recorder_unpack(&run.entries[1], &frame));
    return frame;
}

static void assert_comes_back(const drive_in_t *in, const drive_out_t *out)
{
    const recorder_frame_t back = recorded(in, out);

    TEST_ASSERT_EQUAL_HEX16(in->adc_ia, back.in.adc_ia);
    TEST_ASSERT_EQUAL_HEX16(in->adc_ib, back.in.adc_ib);
    TEST_ASSERT_EQUAL_HEX16(in->adc_bus, back.in.adc_bus);
    TEST_ASSERT_EQUAL_HEX16(in->flags, back.in.flags);
    TEST_ASSERT_EQUAL_HEX16(in->adc_temperature, back.in.adc_temperature);
    TEST_ASSERT_EQUAL_HEX16(in->angle, back.in.angle);
    TEST_ASSERT_EQUAL_INT32(in->command.target, back.in.command.target);
    TEST_ASSERT_EQUAL_HEX8(in->command.mode, back.in.command.mode);
    TEST_ASSERT_EQUAL_HEX8(in->command.request, back.in.command.request);
    TEST_ASSERT_EQUAL_HEX16_ARRAY(out->compare.phase, back.out.compare.phase, 3U);
    TEST_ASSERT_EQUAL_INT(out->gate_enable, back.out.gate_enable);
}

TEST(test_every_bit_of_a_frame_comes_back)
{
    const drive_in_t none = {0};
    const drive_in_t all = {0xFFFFU, 0xFFFFU, 0xFFFFU, 0xFFFFU, {-1, 0xFFU, 0xFFU},
                            0xFFFFU, 0xFFFFU};
    const drive_in_t mixed = {0x0102U, 0x0304U, 0x0506U, 0x0708U, {0x090A0B0C, 0x0DU, 0x0EU},
                              0x0F10U, 0x1112U};
    const drive_out_t out_none = {{{0U, 0U, 0U}}, false};
    const drive_out_t out_all = {{{0x7FFFU, 0x7FFFU, 0x7FFFU}}, true};
    const drive_out_t out_mixed = {{{0x1314U, 0x1516U, 0x1718U}}, true};

    assert_comes_back(&none, &out_all);
    assert_comes_back(&all, &out_none);
    assert_comes_back(&mixed, &out_mixed);
}

TEST(test_nothing_frozen_has_no_history)
{
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
}

TEST(test_drive_does_the_same_with_and_without_a_recorder)
{
    drive_t alone;
    drive_out_t out = {0};

    TEST_ASSERT_NULL(drive_init(&alone, &run.cfg));
    for (uint32_t k = 0U; k < LONG_RUN; k++) {
        recorded_run_ticks(&run, 1U);
        drive_step(&alone, &run.in, &out);
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&alone), drive_words_hash(&run.drive));
}

/* As control_isr() does it. A number makes a configuration; those of the last two are there. */
static uint32_t change_to(int32_t number)
{
    const drive_cfg_t *const before = run.drive.cfg;
    drive_cfg_t *const next = (before == &run.cfg) ? &other_cfg : &run.cfg;

    *next = *before;
    next->current_loop.pi_d.kp = number;
    next->crc = config_guard_crc(next);
    drive_change(&run.drive, next);
    recorder_change(&run.recorder, before);
    return next->crc;
}

static void hold_and_freeze(void)
{
    recorder_hold(&run.recorder, &run.drive);
    recorded_run_ticks(&run, 3U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
}

/* Ticks up to the first one of the next segment. */
static void enter_next_segment(void)
{
    const uint32_t number = recorder_newest(&run.recorder);

    while (recorder_newest(&run.recorder) == number) {
        recorded_run_ticks(&run, 1U);
    }
}

TEST(test_history_is_the_run_through_a_change_of_the_configuration)
{
    for (uint32_t k = 0U; k < RUN_SEGMENT_ENTRIES; k++) {
        recorder_history_t history;
        uint32_t crc = 0U;

        setUp();
        recorded_run_ticks(&run, LONG_RUN + k);
        crc = change_to(1);
        recorded_run_ticks(&run, RUN_SEGMENT_ENTRIES);
        TEST_ASSERT_GREATER_THAN_UINT32(RUN_SEGMENT_ENTRIES, fail_and_freeze());
        history = recorder_history(&run.recorder);
        TEST_ASSERT_NOT_NULL(recorder_further_config(&run.recorder, &history));
        TEST_ASSERT_EQUAL_HEX32(crc, recorder_further_config(&run.recorder, &history)->crc);
    }
}

TEST(test_history_is_the_run_through_a_change_and_back)
{
    const int32_t own = run.cfg.current_loop.pi_d.kp;

    recorded_run_ticks(&run, LONG_RUN);
    (void)change_to(1);
    recorded_run_ticks(&run, 10U);
    TEST_ASSERT_EQUAL_HEX32(config_guard_crc(&run.cfg), change_to(own));
    recorded_run_ticks(&run, 10U);
    TEST_ASSERT_GREATER_THAN_UINT32(RUN_SEGMENT_ENTRIES, fail_and_freeze());
}

/* A segment names the configuration that it changes to again in each change that comes later. */
TEST(test_history_is_the_run_through_a_command_behind_a_change_of_the_configuration)
{
    const uint32_t first = run.cfg.crc;

    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    (void)change_to(1);
    recorded_run_ticks(&run, run.cfg.slow_ticks);
    run.in.command.target += 1000;
    recorded_run_ticks(&run, 2U * run.cfg.slow_ticks);
    hold_and_freeze();
    const recorder_history_t history = recorder_history(&run.recorder);
    TEST_ASSERT_EQUAL_HEX32(first, recorder_begin_state(&run.recorder, &history)->cfg->crc);
    TEST_ASSERT_GREATER_THAN_UINT32(RUN_SEGMENT_ENTRIES, replay());
}

TEST(test_history_without_a_change_has_no_further_configuration)
{
    recorded_run_ticks(&run, 10U);
    (void)change_to(1);
    recorded_run_ticks(&run, LONG_RUN); /* long ago */
    TEST_ASSERT_GREATER_THAN_UINT32(RUN_SEGMENT_ENTRIES, fail_and_freeze());
    const recorder_history_t history = recorder_history(&run.recorder);
    TEST_ASSERT_NULL(recorder_further_config(&run.recorder, &history));
}

TEST(test_history_begins_behind_a_configuration_that_was_overwritten)
{
    recorded_run_ticks(&run, LONG_RUN);
    const uint32_t second = change_to(1);
    enter_next_segment();
    recorded_run_ticks(&run, 10U);
    (void)change_to(2);
    recorded_run_ticks(&run, 10U);
    hold_and_freeze();
    const recorder_history_t history = recorder_history(&run.recorder);
    TEST_ASSERT_EQUAL_HEX32(second, recorder_begin_state(&run.recorder, &history)->cfg->crc);
    TEST_ASSERT_GREATER_THAN_UINT32(20U, replay());
}

TEST(test_two_changes_within_the_last_segment_leave_no_history)
{
    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    (void)change_to(1);
    recorded_run_ticks(&run, 5U);
    (void)change_to(2);
    recorded_run_ticks(&run, 5U);
    hold_and_freeze();
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
}

/* The first is there again at the end, and the second is not. */
TEST(test_a_configuration_between_two_that_are_there_is_not_taken_for_one_of_them)
{
    const int32_t own = run.cfg.current_loop.pi_d.kp;

    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    (void)change_to(1);
    recorded_run_ticks(&run, 5U);
    (void)change_to(own);
    recorded_run_ticks(&run, 5U);
    (void)change_to(2);
    enter_next_segment();
    hold_and_freeze();
    const uint32_t ticks = replay();
    TEST_ASSERT_GREATER_THAN_UINT32(0U, ticks);
    TEST_ASSERT_LESS_THAN_UINT32(RUN_SEGMENT_ENTRIES, ticks);
}

TEST(test_a_change_without_room_is_in_the_next_segment)
{
    recorded_run_ticks(&run, LONG_RUN);
    miss_background();
    const uint32_t crc = change_to(1);
    recorded_run_interrupt(&run);
    recorded_run_ticks(&run, 30U);
    TEST_ASSERT_GREATER_THAN_UINT32(30U, fail_and_freeze());
    const recorder_history_t history = recorder_history(&run.recorder);
    TEST_ASSERT_EQUAL_HEX32(crc, recorder_begin_state(&run.recorder, &history)->cfg->crc);
    TEST_ASSERT_NULL(recorder_further_config(&run.recorder, &history));
}

/* Reads what is new; the last segment was perhaps completed since. */
static void read_on(void)
{
    const uint32_t newest = recorder_newest(&run.recorder);

    for (uint32_t number = (newest > 1U) ? (newest - 1U) : newest; number <= newest; number++) {
        recorder_view_t view = {0};

        TEST_ASSERT_LESS_THAN_UINT32(READ_SEGMENTS, number);
        if (recorder_find(&run.recorder, number, &view)) {
            uint32_t *const count = &reader.counts[number];

            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(*count, view.entries);
            TEST_ASSERT_EQUAL_INT((number != newest) || run.recorder.frozen, view.complete);
            while (*count < view.entries) {
                reader.entries[number][*count] = view.first[*count];
                (*count)++;
            }
        }
    }
}

static void follow(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        recorded_run_ticks(&run, 1U);
        read_on();
    }
}

TEST(test_a_reader_that_follows_has_the_entries_of_the_history)
{
    uint32_t segments = 0U;

    recorder_follow(&run.recorder, true);
    follow(LONG_RUN);
    hold_and_freeze();
    read_on();
    const recorder_history_t history = recorder_history(&run.recorder);
    while ((segments < RECORDER_SEGMENTS) && (history.of_segment[segments] > 0U)) {
        segments++;
    }
    TEST_ASSERT_EQUAL_UINT32(RECORDER_SEGMENTS, segments);
    const uint32_t number = (recorder_newest(&run.recorder) + 1U) - segments;
    for (uint32_t k = 0U, at = 0U; k < segments; k++) {
        TEST_ASSERT_EQUAL_UINT32(history.of_segment[k], reader.counts[number + k]);
        for (uint32_t e = 0U; e < history.of_segment[k]; e++) {
            TEST_ASSERT_EQUAL_MEMORY(recorder_entry(&run.recorder, &history, at),
                                     &reader.entries[number + k][e], sizeof(recorder_entry_t));
            at++;
        }
    }
}

/* From the state of each segment its frames lead to the state of the next. */
TEST(test_segments_that_follow_each_other_are_the_run)
{
    recorder_view_t view = {0};
    drive_t drive = run.drive;
    recorder_frame_t frame = {0};

    follow(LONG_RUN);
    for (uint32_t number = recorder_newest(&run.recorder) - 2U;
         number <= recorder_newest(&run.recorder); number++) {
        TEST_ASSERT_TRUE(recorder_find(&run.recorder, number, &view));
        TEST_ASSERT_TRUE(view.follows);
        TEST_ASSERT_EQUAL_HEX32(run.cfg.crc, view.config_crc);
        if (drive.tick != 0U) {
            TEST_ASSERT_EQUAL_HEX32(drive_words_hash(view.state), drive_words_hash(&drive));
        }
        drive = *view.state;
        for (uint32_t e = 0U; e < view.entries; e++) {
            drive_out_t out = {0};

            if (recorder_unpack(&view.first[e], &frame)) {
                drive_step(&drive, &frame.in, &out);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.drive), drive_words_hash(&drive));
}

TEST(test_segments_are_numbered_from_one_on_and_go_on_when_it_begins_anew)
{
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_newest(&run.recorder));
    recorded_run_ticks(&run, 2U);
    TEST_ASSERT_EQUAL_UINT32(1U, recorder_newest(&run.recorder));
    enter_next_segment();
    TEST_ASSERT_EQUAL_UINT32(2U, recorder_newest(&run.recorder));
    hold_and_freeze();
    const uint32_t number = recorder_newest(&run.recorder);
    recorder_release(&run.recorder);
    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_newest(&run.recorder));
    recorded_run_ticks(&run, 2U);
    TEST_ASSERT_EQUAL_UINT32(number + 1U, recorder_newest(&run.recorder));
}

TEST(test_no_segment_has_the_number_zero_when_the_count_wraps)
{
    recorder_view_t view = {0};

    run.recorder.ended = UINT32_MAX - 1U;
    recorded_run_ticks(&run, 2U);
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, recorder_newest(&run.recorder));
    enter_next_segment();
    TEST_ASSERT_EQUAL_UINT32(1U, recorder_newest(&run.recorder));
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, UINT32_MAX, &view));
    TEST_ASSERT_TRUE(view.complete);
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, 0U, &view));
}

TEST(test_a_segment_is_found_until_it_is_overwritten)
{
    recorder_view_t view = {0};

    recorded_run_ticks(&run, LONG_RUN);
    const uint32_t number = recorder_newest(&run.recorder);
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, number + 1U, &view));
    for (uint32_t k = 1U; k < RECORDER_SEGMENTS; k++) {
        enter_next_segment();
        TEST_ASSERT_TRUE(recorder_find(&run.recorder, number, &view));
        TEST_ASSERT_TRUE(view.complete);
    }
    while (!run.recorder.offered) { /* the snapshot of the next takes its place */
        TEST_ASSERT_TRUE(recorder_find(&run.recorder, number, &view));
        recorded_run_ticks(&run, 1U);
    }
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, number, &view));
    enter_next_segment();
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, number, &view));
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, number + 1U, &view));
}

TEST(test_a_state_that_a_reader_asked_for_is_kept_when_its_segment_is_overwritten)
{
    recorder_view_t view = {0};

    recorder_follow(&run.recorder, true);
    recorded_run_ticks(&run, LONG_RUN);
    const uint32_t number = recorder_newest(&run.recorder);
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, number, &view));
    const uint32_t hash = drive_words_hash(view.state);
    TEST_ASSERT_EQUAL_HEX32(hash, drive_words_hash(recorder_keep_state(&run.recorder, number)));
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, number, &view));
    TEST_ASSERT_EQUAL_HEX32(hash, drive_words_hash(recorder_keep_state(&run.recorder, number)));
    TEST_ASSERT_NOT_NULL(recorder_keep_state(&run.recorder, recorder_newest(&run.recorder)));
    TEST_ASSERT_NULL(recorder_keep_state(&run.recorder, number));
    TEST_ASSERT_NULL(recorder_keep_state(&run.recorder, 0U));
}

/* The place is that of the state at the end. */
TEST(test_a_recording_that_freezes_ends_with_its_own_state_whatever_a_reader_keeps)
{
    uint32_t end = 0U;

    recorder_follow(&run.recorder, true);
    recorded_run_ticks(&run, LONG_RUN);
    const uint32_t number = recorder_newest(&run.recorder);
    TEST_ASSERT_NOT_NULL(recorder_keep_state(&run.recorder, number));
    recorder_hold(&run.recorder, &run.drive);
    while (!run.recorder.frozen) {
        end = drive_words_hash(&run.drive);
        TEST_ASSERT_NOT_NULL(recorder_keep_state(&run.recorder, number));
        recorded_run_ticks(&run, 1U);
    }
    TEST_ASSERT_EQUAL_HEX32(end, drive_words_hash(recorder_end_state(&run.recorder)));
    TEST_ASSERT_NOT_NULL(recorder_keep_state(&run.recorder, recorder_newest(&run.recorder)));
    TEST_ASSERT_EQUAL_HEX32(end, drive_words_hash(recorder_end_state(&run.recorder)));
    TEST_ASSERT_GREATER_THAN_UINT32(0U, replay());
}

TEST(test_a_segment_behind_a_gap_does_not_follow)
{
    recorder_view_t view = {0};

    recorded_run_ticks(&run, LONG_RUN);
    miss_background();
    enter_next_segment();
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, recorder_newest(&run.recorder), &view));
    TEST_ASSERT_FALSE(view.follows);
    enter_next_segment();
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, recorder_newest(&run.recorder), &view));
    TEST_ASSERT_TRUE(view.follows);
}

TEST(test_a_segment_says_the_configuration_of_its_state)
{
    recorder_view_t view = {0};
    const uint32_t first = run.cfg.crc;

    recorded_run_ticks(&run, LONG_RUN);
    const uint32_t second = change_to(1);
    recorded_run_ticks(&run, 1U);
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, recorder_newest(&run.recorder), &view));
    TEST_ASSERT_EQUAL_HEX32(first, view.config_crc);
    enter_next_segment();
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, recorder_newest(&run.recorder), &view));
    TEST_ASSERT_EQUAL_HEX32(second, view.config_crc);
    TEST_ASSERT_EQUAL_HEX32(second, view.first[0].word[3]);
}

TEST(test_a_fault_does_not_freeze_while_a_reader_follows)
{
    recorder_follow(&run.recorder, true);
    recorded_run_ticks(&run, LONG_RUN);
    recorded_run_fail(&run);
    const uint32_t number = recorder_newest(&run.recorder);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, run.drive.state);
    TEST_ASSERT_FALSE(run.recorder.frozen);
    TEST_ASSERT_GREATER_THAN_UINT32(number + RECORDER_SEGMENTS, recorder_newest(&run.recorder));
}

/* What lies behind it is no longer the run before that fault. */
TEST(test_a_fault_that_a_reader_saw_does_not_freeze_later_and_the_next_one_does)
{
    recorder_follow(&run.recorder, true);
    recorded_run_ticks(&run, LONG_RUN);
    recorded_run_fail(&run);
    recorder_follow(&run.recorder, false);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, run.drive.state);
    TEST_ASSERT_FALSE(run.recorder.frozen);
    clear();
    (void)record_fault();
}

TEST(test_a_reader_does_not_touch_a_recording_of_a_fault_before_it_is_released)
{
    const uint32_t ticks = record_fault();

    recorder_follow(&run.recorder, true);
    recorded_run_ticks(&run, LONG_RUN);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(ticks, replay());
    recorder_release(&run.recorder);
    recorded_run_ticks(&run, RUN_POST_TICKS + 3U);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, run.drive.state);
    TEST_ASSERT_FALSE(run.recorder.frozen);
    TEST_ASSERT_NOT_EQUAL(0U, recorder_newest(&run.recorder));
}

TEST(test_init_names_what_is_out_of_range)
{
    recorder_t recorder;

    TEST_ASSERT_NULL(recorder_init(&recorder, run.entries, RECORDER_ENTRIES_MIN, 0U));
    TEST_ASSERT_NULL(
        recorder_init(&recorder, run.entries, RUN_SEGMENT_ENTRIES, RECORDER_POST_TICKS_MAX));
    TEST_ASSERT_EQUAL_STRING("segment_entries",
                             recorder_init(&recorder, run.entries, RECORDER_ENTRIES_MIN - 1U, 0U));
    TEST_ASSERT_EQUAL_STRING("segment_entries",
                             recorder_init(&recorder, run.entries, RECORDER_ENTRIES_MAX + 1U, 0U));
    TEST_ASSERT_EQUAL_STRING(
        "post_ticks",
        recorder_init(&recorder, run.entries, RUN_SEGMENT_ENTRIES, RECORDER_POST_TICKS_MAX + 1U));
}

/* ---- a word that has flipped by itself ---- */

TEST(test_of_a_ring_that_is_elsewhere_there_is_no_history_and_no_segment)
{
    static recorder_entry_t elsewhere[RECORDER_SEGMENTS * RUN_SEGMENT_ENTRIES];
    recorder_view_t view;
    uint32_t newest;

    (void)record_fault();
    newest = recorder_newest(&run.recorder);
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, newest, &view));
    run.recorder.entries = elsewhere;
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, newest, &view));
    run.recorder.entries = run.entries;
    run.recorder.segment_entries--;
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
    TEST_ASSERT_FALSE(recorder_find(&run.recorder, newest, &view));
    run.recorder.segment_entries++;
    TEST_ASSERT_TRUE(replay() > 0U);
}

TEST(test_a_ring_that_is_elsewhere_is_not_written_to)
{
    static const recorder_entry_t empty[RUN_SEGMENT_ENTRIES];
    static recorder_entry_t elsewhere[RECORDER_SEGMENTS * RUN_SEGMENT_ENTRIES];

    recorded_run_ticks(&run, LONG_RUN);
    run.recorder.entries = elsewhere;
    recorded_run_ticks(&run, 2U * RUN_SEGMENT_ENTRIES);
    for (uint32_t k = 0U; k < RECORDER_SEGMENTS; k++) {
        TEST_ASSERT_EQUAL_MEMORY(empty, &elsewhere[k * RUN_SEGMENT_ENTRIES], sizeof(empty));
    }
}

TEST(test_a_stop_that_has_moved_is_set_again_within_a_slow_period)
{
    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    run.recorder.stop = &run.recorder.stop[-1];
    recorded_run_ticks(&run, run.cfg.slow_ticks);
    TEST_ASSERT_EQUAL_PTR(run.recorder.due_stop, run.recorder.stop);
    TEST_ASSERT_TRUE(fail_and_freeze() > 0U);
}

TEST(test_where_stop_and_ring_have_moved_the_tick_that_sees_it_is_not_written)
{
    const recorder_entry_t *before;

    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    before = run.recorder.at;
    run.recorder.stop = &run.recorder.stop[-1];
    run.recorder.segment_entries--;
    for (uint32_t k = 0U; k < run.cfg.slow_ticks; k++) {
        recorded_run_noise(&run);
        recorded_run_interrupt(&run);
    }
    TEST_ASSERT_EQUAL_PTR(&before[run.cfg.slow_ticks - 1U], run.recorder.at);
}

/* An old frame stays between the new ones. */
TEST(test_a_place_to_write_that_has_moved_leaves_no_history)
{
    recorded_run_ticks(&run, LONG_RUN);
    enter_next_segment();
    run.recorder.at = &run.recorder.at[1];
    recorded_run_fail(&run);
    recorded_run_ticks(&run, RUN_POST_TICKS + 1U);
    TEST_ASSERT_TRUE(run.recorder.frozen);
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_history(&run.recorder).entries);
}

TEST(test_a_place_to_write_outside_of_its_segment_adds_nothing_to_the_check_word)
{
    recorder_segment_t before;
    const recorder_segment_t *segment;

    recorded_run_ticks(&run, LONG_RUN);
    do {
        enter_next_segment();
    } while (run.recorder.current == (RECORDER_SEGMENTS - 1U)); /* there is a segment behind it */
    segment = &run.recorder.segments[run.recorder.current];
    before = *segment;
    run.recorder.at = &run.recorder.at[RUN_SEGMENT_ENTRIES];
    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, before.summed);
    TEST_ASSERT_EQUAL_UINT32(before.summed, segment->summed);
    TEST_ASSERT_EQUAL_HEX32(before.sum, segment->sum);
}

/* What the last segment keeps free for a stop that has flipped is half of it at most. */
TEST(test_history_is_the_run_with_a_slow_period_longer_than_half_a_segment)
{
    run.cfg.slow_ticks = 100U;
    run.cfg.crc = config_guard_crc(&run.cfg);
    TEST_ASSERT_NULL(drive_init(&run.drive, &run.cfg));
    (void)record_fault();
}
