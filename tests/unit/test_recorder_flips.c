/* SPDX-License-Identifier: MIT */
/*
 * A bit of the flight recorder flips by itself while it records. Nothing outside of the ring
 * changes, the drive does what it does without it, and the recording is whole afterwards, or there
 * is none.
 *
 * Left out: the pointers to configurations, which on a PC lead nowhere, and the states, whose bits
 * are those of a recording: the replay departs. All moments with NF_MANY_RUNS=1, else one of 61.
 */
#include "drive_words.h"
#include "recorded_run.h"
#include "testing.h"

#include <stddef.h>
#include <stdio.h>

#define GUARD_BYTES (65536U)
#define GUARD_BYTE (0xA5U)
#define RING_ENTRIES (RECORDER_SEGMENTS * RUN_SEGMENT_ENTRIES)
#define FEW (61U)
#define BEFORE_TICKS (1000U) /* the ring has been full once */
/* three slow periods: the interrupt alone has to keep within the ring */
#define ALONE_TICKS (30U)
#define AFTER_TICKS (150U)
#define FREEZE_TICKS (400U)
#define SPREAD (7U)

/* The ring, and what must not change on both sides of it. */
static struct {
    uint8_t before[GUARD_BYTES];
    recorder_entry_t entries[RING_ENTRIES];
    uint8_t after[GUARD_BYTES];
} memory;

static recorded_run_t run;
static recorded_run_t moment; /* where the flips begin */
static recorder_entry_t entries_then[RING_ENTRIES];
static uint8_t sound[GUARD_BYTES];

/* The words that are flipped: all before the states, but `before`. */
static bool is_flipped(uint32_t byte)
{
    const uint32_t pointer = offsetof(recorder_t, before);

    return (byte < pointer) || (byte >= (pointer + sizeof(run.recorder.before)));
}

static void flip(uint32_t bit)
{
    uint8_t *const bytes = (uint8_t *)&run.recorder;

    bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
}

static void keep_moment(void)
{
    moment = run;
    memcpy(entries_then, memory.entries, sizeof(entries_then));
}

static void go_back(void)
{
    run = moment;
    run.drive.cfg = &run.cfg;
    memcpy(memory.entries, entries_then, sizeof(entries_then));
}

void setUp(void)
{
    memset(sound, (int)GUARD_BYTE, sizeof(sound));
    memset(&memory, (int)GUARD_BYTE, sizeof(memory));
    recorded_run_start(&run);
    TEST_ASSERT_NULL(
        recorder_init(&run.recorder, memory.entries, RUN_SEGMENT_ENTRIES, RUN_POST_TICKS));
    recorded_run_ticks(&run, BEFORE_TICKS);
    TEST_ASSERT_TRUE(run.out.gate_enable);
}

static void alone(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        recorded_run_noise(&run);
        recorded_run_interrupt(&run);
    }
}

static void assert_guards(const char *text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, memcmp(memory.before, sound, sizeof(sound)), text);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, memcmp(memory.after, sound, sizeof(sound)), text);
}

/* Whether what was recorded is a run with these outputs; also what is none. */
static bool is_whole(const recorder_history_t *history)
{
    drive_t drive = *recorder_begin_state(&run.recorder, history);
    recorder_frame_t frame = {0};
    bool same = true;

    for (uint32_t at = 0U; at < history->entries; at++) {
        if (recorder_unpack(recorder_entry(&run.recorder, history, at), &frame)) {
            drive_out_t out = {0};

            drive_step(&drive, &frame.in, &out);
            same = same && (memcmp(out.compare.phase, frame.out.compare.phase,
                                   sizeof(out.compare.phase)) == 0);
            same = same && (out.gate_enable == frame.out.gate_enable);
        }
    }
    return same &&
           (drive_words_hash(recorder_end_state(&run.recorder)) == drive_words_hash(&drive));
}

/* The run to its end, with a fault. Returns the hash of the drive. */
static uint32_t end_run(void)
{
    alone(ALONE_TICKS);
    recorded_run_ticks(&run, AFTER_TICKS);
    recorded_run_fail(&run);
    recorded_run_ticks(&run, FREEZE_TICKS);
    return drive_words_hash(&run.drive);
}

/* Returns whether there is a recording. */
static bool try_flip(uint32_t bit, uint32_t due)
{
    recorder_history_t history;
    char text[48];

    (void)snprintf(text, sizeof(text), "bit %u of byte %u", (unsigned)(bit % 8U),
                   (unsigned)(bit / 8U));
    go_back();
    flip(bit);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(due, end_run(), text);
    assert_guards(text);
    history = recorder_history(&run.recorder);
    TEST_ASSERT_TRUE_MESSAGE((history.entries == 0U) || is_whole(&history), text);
    return history.entries > 0U;
}

/* Every bit at moments that go round the ring. */
TEST(test_a_flipped_bit_leaves_a_whole_recording_or_none)
{
    const uint32_t every = testing_runs(FEW, 1U);
    uint32_t whole = 0U;
    uint32_t tried = 0U;

    for (uint32_t k = 0U; k < (RING_ENTRIES / SPREAD); k++) {
        uint32_t due;

        recorded_run_ticks(&run, SPREAD);
        keep_moment();
        due = end_run();
        for (uint32_t bit = k % every; bit < (8U * offsetof(recorder_t, states)); bit += every) {
            if (is_flipped(bit / 8U)) {
                whole += try_flip(bit, due) ? 1U : 0U;
                tried++;
            }
        }
        go_back();
    }
    TEST_ASSERT_TRUE(whole > (tried / 3U));
    TEST_ASSERT_TRUE(whole < tried);
}

/* The reader finds the recording, or none: it reads nothing that is not there. */
TEST(test_of_a_frozen_recording_a_flipped_bit_leaves_the_whole_or_none)
{
    (void)end_run();
    TEST_ASSERT_TRUE(run.recorder.frozen);
    keep_moment();
    for (uint32_t bit = 0U; bit < (8U * offsetof(recorder_t, states)); bit++) {
        if (is_flipped(bit / 8U)) {
            recorder_history_t history;

            go_back();
            flip(bit);
            history = recorder_history(&run.recorder);
            TEST_ASSERT_TRUE((history.entries == 0U) || is_whole(&history));
        }
    }
}

/* At each place of the ring, with an interrupt that the background leaves alone. */
TEST(test_no_flip_of_place_or_stop_makes_the_interrupt_write_outside_of_the_ring)
{
    const uint32_t every = testing_runs(3U, 1U);
    const uint32_t first = 8U * offsetof(recorder_t, at);
    const uint32_t end = 8U * offsetof(recorder_t, target);

    for (uint32_t k = 0U; k < (RING_ENTRIES + RUN_SEGMENT_ENTRIES); k++) {
        recorded_run_ticks(&run, 1U);
        keep_moment();
        for (uint32_t bit = first + (k % every); bit < end; bit += every) {
            go_back();
            flip(bit);
            alone(2U * RUN_SEGMENT_ENTRIES / RECORDER_SEGMENTS);
            assert_guards("a guard");
        }
        go_back();
    }
}
