/* SPDX-License-Identifier: MIT */
/* A recording in a memory that a reset has left: it is taken if the drive repeats its outputs. */
#include "config_guard.h"
#include "drive_words.h"
#include "recorded_run.h"
#include "recorder_roll.h"
#include "testing.h"

#include <string.h>

#define INSTANTS (testing_runs(60U, 3000U))
#define FLIPS (testing_runs(200U, 20000U))

static recorded_run_t run;
static drive_cfg_t other;
static drive_t work;
static bool cut;

static recorder_place_t place_of_run(void)
{
    return (recorder_place_t){.entries = run.entries,
                              .segment_entries = RUN_SEGMENT_ENTRIES,
                              .configs = {&run.cfg, &other}};
}

void setUp(void)
{
    recorded_run_start(&run);
    other = run.cfg;
    other.speed_loop.speed_max -= 1000;
    other.crc = config_guard_crc(&other);
}

static bool rescue(void)
{
    const recorder_place_t place = place_of_run();

    return recorder_rescue(&run.recorder, &place, &work, &cut);
}

/* Whether the history leads from its begin to its end, stepped here a second time. */
static void assert_repeats(void)
{
    const recorder_history_t history = recorder_history(&run.recorder);
    drive_t drive = *recorder_begin_state(&run.recorder, &history);
    recorder_frame_t frame = {0};

    TEST_ASSERT_GREATER_THAN_UINT32(0U, history.entries);
    for (uint32_t k = 0U; k < history.entries; k++) {
        const recorder_entry_t *const entry = recorder_entry(&run.recorder, &history, k);
        drive_out_t out = {0};

        if (recorder_unpack(entry, &frame)) {
            drive_step(&drive, &frame.in, &out);
            TEST_ASSERT_EQUAL_MEMORY(&frame.out.compare, &out.compare, sizeof out.compare);
            TEST_ASSERT_EQUAL(frame.out.gate_enable, out.gate_enable);
        } else if (entry->word[3] != drive.cfg->crc) {
            drive_change(&drive, (entry->word[3] == other.crc) ? &other : &run.cfg);
        } else {
            /* a command */
        }
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&drive),
                            drive_words_hash(recorder_end_state(&run.recorder)));
}

TEST(test_a_recording_that_a_reset_has_cut_ends_with_the_last_tick)
{
    for (uint32_t k = 0U; k < INSTANTS; k++) {
        const uint32_t ticks = 4U + ((k * 37U) % 1500U); /* the first ticks are not recorded */
        uint32_t hash;

        setUp();
        recorded_run_ticks(&run, ticks);
        hash = drive_words_hash(&run.drive);
        TEST_ASSERT_TRUE(rescue());
        TEST_ASSERT_TRUE(cut);
        TEST_ASSERT_EQUAL_HEX32(hash, drive_words_hash(&work));
        assert_repeats();
    }
}

TEST(test_a_recording_that_was_frozen_stays_as_it_is)
{
    recorder_history_t before;
    recorder_history_t after;

    recorded_run_ticks(&run, 900U);
    recorded_run_fail(&run);
    recorded_run_ticks(&run, RUN_POST_TICKS + 2U);
    before = recorder_history(&run.recorder);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, before.entries);
    TEST_ASSERT_TRUE(rescue());
    after = recorder_history(&run.recorder);
    TEST_ASSERT_FALSE(cut);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, work.state);
    TEST_ASSERT_EQUAL_MEMORY(&before, &after, sizeof after);
    assert_repeats();
}

TEST(test_a_change_of_the_configuration_is_repeated)
{
    recorded_run_ticks(&run, 700U);
    recorder_change(&run.recorder, &run.cfg);
    drive_change(&run.drive, &other);
    recorded_run_ticks(&run, 90U);
    TEST_ASSERT_TRUE(rescue());
    TEST_ASSERT_EQUAL_PTR(&other, work.cfg);
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.drive), drive_words_hash(&work));
    assert_repeats();
}

TEST(test_an_entry_that_is_half_written_is_left_out)
{
    recorded_run_ticks(&run, 400U);
    run.recorder.at->word[0] = 0xFFFFFFFFU;
    run.recorder.at->word[2] = 0x00010001U;
    run.recorder.at = &run.recorder.at[1];
    TEST_ASSERT_TRUE(rescue());
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.drive), drive_words_hash(&work));
    assert_repeats();
}

/* The interrupt has noted the next segment, and not written to it. */
TEST(test_a_reset_while_a_segment_is_entered_ends_with_the_one_before)
{
    recorded_run_ticks(&run, 400U);
    run.recorder.current = (run.recorder.current + 1U) % RECORDER_SEGMENTS;
    TEST_ASSERT_TRUE(rescue());
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&run.drive), drive_words_hash(&work));
    assert_repeats();
}

TEST(test_an_older_segment_with_another_output_is_left_out)
{
    recorder_history_t history;
    uint32_t whole;

    recorded_run_ticks(&run, 1000U);
    TEST_ASSERT_TRUE(rescue());
    history = recorder_history(&run.recorder);
    whole = history.entries;
    run.entries[(history.first * RUN_SEGMENT_ENTRIES) + 50U].word[2] ^= 1U;
    run.recorder.frozen = false;
    TEST_ASSERT_TRUE(rescue());
    history = recorder_history(&run.recorder);
    TEST_ASSERT_LESS_THAN_UINT32(whole, history.entries);
    assert_repeats();
}

TEST(test_the_last_segment_with_another_output_is_no_recording)
{
    recorded_run_ticks(&run, 1000U);
    (&run.recorder.at[-9])->word[2] ^= 1U;
    TEST_ASSERT_FALSE(rescue());
}

TEST(test_a_memory_of_another_place_is_no_recording)
{
    recorder_place_t place = place_of_run();

    recorded_run_ticks(&run, 300U);
    place.segment_entries--;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place, &work, &cut));
    place = place_of_run();
    place.entries = &run.entries[1];
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place, &work, &cut));
    place = place_of_run();
    place.configs[0] = NULL;
    place.configs[1] = NULL;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place, &work, &cut));
}

TEST(test_a_configuration_that_is_not_whole_is_not_followed)
{
    recorder_place_t place = place_of_run();

    recorded_run_ticks(&run, 300U);
    place.configs[0] = NULL;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place, &work, &cut));
}

/* A loss of the supply that was short leaves any bits: nothing goes wrong, whatever they are. */
TEST(test_any_bits_are_a_recording_only_if_they_repeat)
{
    seeded_t chance = {99U};
    uint32_t taken = 0U;

    for (uint32_t k = 0U; k < FLIPS; k++) {
        uint8_t *const bytes = (uint8_t *)&run.recorder;
        const uint32_t flips = 1U + (seeded_u32(&chance) % 8U);

        setUp();
        recorded_run_ticks(&run, 100U + (seeded_u32(&chance) % 900U));
        for (uint32_t flip = 0U; flip < flips; flip++) {
            const uint32_t at = seeded_u32(&chance) % (uint32_t)sizeof run.recorder;

            bytes[at] ^= (uint8_t)(1U << (seeded_u32(&chance) % 8U));
        }
        if (rescue()) {
            taken++;
            assert_repeats();
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(FLIPS / 10U, taken); /* what is not read may be anything */
}

TEST(test_random_memory_is_no_recording)
{
    seeded_t chance = {7U};
    uint8_t *const bytes = (uint8_t *)&run.recorder;

    for (uint32_t at = 0U; at < sizeof run.recorder; at++) {
        bytes[at] = (uint8_t)seeded_u32(&chance);
    }
    TEST_ASSERT_FALSE(rescue());
}
