/* SPDX-License-Identifier: MIT */
/* A recording in a memory that a reset has left: what is taken of it, the drive repeats. */
#include "config_guard.h"
#include "drive_words.h"
#include "recorded_run.h"
#include "recorder_rescue.h"
#include "testing.h"

#include <string.h>

#define INSTANTS (testing_runs(60U, 3000U))
#define FLIPS (testing_runs(200U, 20000U))

static recorded_run_t run;
static drive_cfg_t other;

static recorder_place_t place_of_run(void)
{
    return (recorder_place_t){.entries = run.entries,
                              .segment_entries = RUN_SEGMENT_ENTRIES,
                              .configs = {&run.cfg, &other},
                              .powered = true};
}

void setUp(void)
{
    recorded_run_start(&run);
    other = run.cfg;
    other.speed_loop.speed_max -= 1000;
    other.crc = config_guard_crc(&other);
}

static recorder_rescued_t rescue(void)
{
    const recorder_place_t place = place_of_run();

    return recorder_rescue(&run.recorder, &place);
}

static recorder_rescued_t rescue_unpowered(void)
{
    recorder_place_t place = place_of_run();

    place.powered = false;
    return recorder_rescue(&run.recorder, &place);
}

/* The background does not come round. */
static void alone(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        recorded_run_noise(&run);
        recorded_run_interrupt(&run);
    }
}

/* To where the next tick enters the next segment. */
static void run_to_offer(void)
{
    while (!run.recorder.offered) {
        recorded_run_ticks(&run, 1U);
    }
}

/* Steps the history from its begin: it has the recorded outputs. Returns the state at the end. */
static drive_t repeated(void)
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
    TEST_ASSERT_EQUAL_UINT32(drive.tick, recorder_end_state(&run.recorder)->tick);
    TEST_ASSERT_EQUAL_PTR(drive.cfg, recorder_end_state(&run.recorder)->cfg);
    return drive;
}

/* The last entry is left out, as it may be half written. */
TEST(test_a_recording_that_a_reset_has_cut_ends_one_tick_before_it)
{
    for (uint32_t k = 0U; k < INSTANTS; k++) {
        const uint32_t ticks = 4U + ((k * 37U) % 1500U); /* the first ticks are not recorded */
        uint32_t hash;
        drive_t end;
        recorder_rescued_t rescued;

        setUp();
        recorded_run_ticks(&run, ticks);
        hash = drive_words_hash(&run.drive);
        alone(1U);
        rescued = rescue();
        TEST_ASSERT_TRUE(rescued.found);
        TEST_ASSERT_TRUE(rescued.cut);
        end = repeated();
        TEST_ASSERT_EQUAL_HEX32(hash, drive_words_hash(&end));
    }
}

TEST(test_a_recording_that_was_frozen_stays_as_it_is)
{
    recorder_history_t before;
    recorder_history_t after;
    recorder_rescued_t rescued;
    drive_t end;

    recorded_run_ticks(&run, 900U);
    recorded_run_fail(&run);
    recorded_run_ticks(&run, RUN_POST_TICKS + 3U);
    before = recorder_history(&run.recorder);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, before.entries);
    rescued = rescue_unpowered();
    after = recorder_history(&run.recorder);
    TEST_ASSERT_TRUE(rescued.found);
    TEST_ASSERT_FALSE(rescued.cut);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, recorder_end_state(&run.recorder)->state);
    TEST_ASSERT_EQUAL_MEMORY(&before, &after, sizeof after);
    end = repeated();
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&end),
                            drive_words_hash(recorder_end_state(&run.recorder)));
}

TEST(test_it_tells_whether_the_gates_were_on)
{
    recorded_run_ticks(&run, 700U);
    TEST_ASSERT_TRUE(rescue().drove);
    setUp();
    run.in.command.request = 0U;
    recorded_run_ticks(&run, 700U);
    TEST_ASSERT_TRUE(rescue().found);
    TEST_ASSERT_FALSE(rescue().drove);
}

TEST(test_a_change_of_the_configuration_is_kept)
{
    drive_t end;

    recorded_run_ticks(&run, 700U);
    recorder_change(&run.recorder, &run.cfg);
    drive_change(&run.drive, &other);
    recorded_run_ticks(&run, 90U);
    TEST_ASSERT_TRUE(rescue().found);
    end = repeated();
    TEST_ASSERT_EQUAL_PTR(&other, end.cfg);
}

/* Bits that no check word covers yet count only if the supply was there. */
TEST(test_the_entries_since_the_last_pass_count_if_the_supply_was_there)
{
    uint32_t tick;

    recorded_run_ticks(&run, 400U);
    tick = run.drive.tick;
    alone(10U);
    TEST_ASSERT_TRUE(rescue().found);
    TEST_ASSERT_EQUAL_UINT32(tick + 9U, repeated().tick);
    run.recorder.frozen = false;
    TEST_ASSERT_TRUE(rescue_unpowered().found);
    TEST_ASSERT_UINT32_WITHIN(1U, tick, repeated().tick);
}

/* The interrupt has noted the next segment, and not written to it. */
TEST(test_a_reset_while_a_segment_is_entered_ends_with_the_one_before)
{
    const uint32_t tick = (recorded_run_ticks(&run, 400U), run.drive.tick);

    run.recorder.current = (run.recorder.current + 1U) % RECORDER_SEGMENTS;
    TEST_ASSERT_TRUE(rescue().found);
    TEST_ASSERT_EQUAL_UINT32(tick, repeated().tick);
}

/* The background has offered the segment, and not come round since. */
TEST(test_a_reset_before_a_segment_has_a_check_word_ends_with_the_one_before)
{
    uint32_t tick;

    recorded_run_ticks(&run, 400U);
    run_to_offer();
    tick = run.drive.tick;
    alone(RECORDER_MARGIN);
    TEST_ASSERT_EQUAL_UINT32(0U, run.recorder.segments[run.recorder.current].hash);
    TEST_ASSERT_TRUE(rescue().found);
    TEST_ASSERT_EQUAL_UINT32(tick, repeated().tick);
}

/* Ticks came between the check word of the entries and the offer. The last one is left out. */
TEST(test_entries_without_a_check_word_count_in_a_segment_that_has_ended)
{
    recorder_segment_t *segment;
    recorder_segment_t early;
    uint32_t tick;

    recorded_run_ticks(&run, 400U);
    segment = &run.recorder.segments[run.recorder.current];
    early = *segment;
    run_to_offer();
    TEST_ASSERT_LESS_THAN_UINT32(segment->summed - 1U, early.summed);
    segment->summed = early.summed;
    segment->sum = early.sum;
    tick = run.drive.tick;
    alone(RECORDER_MARGIN);
    TEST_ASSERT_TRUE(rescue().found);
    TEST_ASSERT_EQUAL_UINT32(tick - 1U, repeated().tick);
}

/* The background has noted the check word of the state, and none of the entries. */
TEST(test_a_reset_between_the_check_words_of_a_segment_ends_before_its_entries)
{
    recorder_segment_t *segment;

    recorded_run_ticks(&run, 400U);
    segment = &run.recorder.segments[run.recorder.current];
    TEST_ASSERT_TRUE(segment->follows);
    segment->summed = 0U;
    segment->sum = RECORDER_SUM_START;
    TEST_ASSERT_TRUE(rescue_unpowered().found);
    TEST_ASSERT_EQUAL_UINT32(run.recorder.states[run.recorder.current].tick, repeated().tick);
}

TEST(test_an_older_segment_that_has_changed_is_left_out)
{
    recorder_history_t history;
    uint32_t whole;

    recorded_run_ticks(&run, 1000U);
    TEST_ASSERT_TRUE(rescue().found);
    history = recorder_history(&run.recorder);
    whole = history.entries;
    run.entries[(history.first * RUN_SEGMENT_ENTRIES) + 50U].word[0] ^= 1U;
    run.recorder.frozen = false;
    TEST_ASSERT_TRUE(rescue().found);
    history = recorder_history(&run.recorder);
    TEST_ASSERT_LESS_THAN_UINT32(whole, history.entries);
    (void)repeated();
}

TEST(test_a_last_segment_that_has_changed_is_no_recording)
{
    recorded_run_ticks(&run, 1000U);
    (&run.recorder.at[-9])->word[0] ^= 1U;
    TEST_ASSERT_FALSE(rescue().found);
}

TEST(test_a_memory_of_another_place_is_no_recording)
{
    recorder_place_t place = place_of_run();

    recorded_run_ticks(&run, 300U);
    place.segment_entries--;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place).found);
    place = place_of_run();
    place.entries = &run.entries[1];
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place).found);
    place = place_of_run();
    place.configs[0] = NULL;
    place.configs[1] = NULL;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place).found);
}

static void assert_nothing_rescued(void)
{
    const recorder_rescued_t rescued = rescue();

    TEST_ASSERT_FALSE(rescued.found);
    TEST_ASSERT_FALSE(rescued.cut);
    TEST_ASSERT_FALSE(rescued.drove);
    TEST_ASSERT_FALSE(run.recorder.frozen);
}

/* Nothing is made of it that looks like a recording which a reset has cut. */
TEST(test_a_ring_whose_place_or_size_has_changed_is_left_as_it_is)
{
    recorded_run_ticks(&run, 300U);
    run.recorder.due_segment_entries--;
    assert_nothing_rescued();
    run.recorder.due_segment_entries++;
    run.recorder.due_entries = &run.entries[1];
    assert_nothing_rescued();
    run.recorder.due_entries = run.entries;
    TEST_ASSERT_TRUE(rescue().found);
}

TEST(test_a_configuration_that_is_not_whole_is_not_followed)
{
    recorder_place_t place = place_of_run();

    recorded_run_ticks(&run, 300U);
    place.configs[0] = NULL;
    TEST_ASSERT_FALSE(recorder_rescue(&run.recorder, &place).found);
}

/* The number of entries that the sum covers tells how far the entries are read. */
TEST(test_a_sum_over_more_entries_than_the_segment_has_is_no_recording)
{
    recorded_run_ticks(&run, 300U);
    run.recorder.segments[run.recorder.current].summed |= 0x80000000U;
    TEST_ASSERT_FALSE(rescue_unpowered().found);
    run.recorder.frozen = false;
    TEST_ASSERT_FALSE(rescue().found);
}

/*
 * A loss of the supply that was short leaves any bits: of the recorder, of the entries. What is
 * taken repeats. Check words of 32 bits let none of these draws through.
 */
TEST(test_a_memory_with_changed_bits_is_a_recording_only_if_it_repeats)
{
    seeded_t chance = {99U};
    uint32_t taken = 0U;

    for (uint32_t k = 0U; k < FLIPS; k++) {
        const bool of_entries = (k % 3U) == 0U;
        uint8_t *const bytes = of_entries ? (uint8_t *)run.entries : (uint8_t *)&run.recorder;
        const uint32_t size =
            of_entries ? (uint32_t)sizeof run.entries : (uint32_t)sizeof run.recorder;
        const uint32_t flips = 1U + (seeded_u32(&chance) % 8U);

        setUp();
        recorded_run_ticks(&run, 100U + (seeded_u32(&chance) % 900U));
        for (uint32_t flip = 0U; flip < flips; flip++) {
            const uint32_t at = seeded_u32(&chance) % size;

            bytes[at] ^= (uint8_t)(1U << (seeded_u32(&chance) % 8U));
        }
        if (rescue_unpowered().found) {
            taken++;
            (void)repeated();
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
    TEST_ASSERT_FALSE(rescue().found);
}
