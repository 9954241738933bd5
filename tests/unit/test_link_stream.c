/* SPDX-License-Identifier: MIT */
/* The stream: the run comes out of it tick by tick, and what is missing is told. */
#include "drive_words.h"
#include "frame_code.h"
#include "link_stream.h"
#include "recorded_run.h"
#include "testing.h"
#include "words.h"

#include <string.h>

static const units_rotation_t ROTATION = {.pole_pairs = 2U, .tick_ps = 100000000U};

static recorded_run_t run;
static link_stream_t stream;
static link_out_t out;
static uint32_t busy; /* ticks that the line takes for a message */
static uint32_t busy_until;

/* The reader: it runs the drive again. */
static struct {
    drive_t drive;
    recorder_frame_t frame;
    uint32_t segment;
    uint32_t entry;
    uint32_t first_tick; /* of the stream */
    uint32_t ticks;
    uint32_t segments;
    uint32_t gaps;
    uint32_t messages;
} reader;

void setUp(void)
{
    recorded_run_start(&run);
    memset(&reader, 0, sizeof reader);
    link_stream_init(&stream, &ROTATION);
    link_out_start(&out);
    busy = 0U;
    busy_until = 0U;
}

static void read_segment(const uint8_t *body, uint32_t length)
{
    const uint32_t number = words_get(body);
    const bool follows = body[18] != 0U;
    recorder_view_t view = {0};

    TEST_ASSERT_EQUAL_UINT32(LINK_SEGMENT_BYTES, length);
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, number, &view));
    if (follows) {
        TEST_ASSERT_EQUAL_UINT32((reader.segment == UINT32_MAX) ? 1U : (reader.segment + 1U),
                                 number);
        TEST_ASSERT_EQUAL_UINT32(reader.drive.tick, words_get(&body[4]));
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(drive_words_hash(&reader.drive), words_get(&body[8]),
                                        "whoever runs the frames has the state of the board");
        TEST_ASSERT_EQUAL_UINT32(reader.entry, body[16] | ((uint32_t)body[17] << 8U));
    } else {
        const uint32_t before = body[16] | ((uint32_t)body[17] << 8U);

        TEST_ASSERT_TRUE((before == 0U) || (before == reader.entry));
        reader.gaps++;
        reader.drive = *view.state;
        reader.drive.cfg = &run.cfg;
    }
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(view.state), words_get(&body[8]));
    TEST_ASSERT_EQUAL_HEX32(run.cfg.crc, words_get(&body[12]));
    reader.first_tick = (reader.segments == 0U) ? reader.drive.tick : reader.first_tick;
    reader.segment = number;
    reader.entry = 0U;
    reader.segments++;
}

static void read_entries(const uint8_t *body, uint32_t length)
{
    recorder_entry_t entries[FRAME_CODE_ENTRIES_MAX];
    const uint32_t count = body[6];

    TEST_ASSERT_EQUAL_UINT32(reader.segment, words_get(body));
    TEST_ASSERT_EQUAL_UINT32(reader.entry, body[4] | ((uint32_t)body[5] << 8U));
    TEST_ASSERT_TRUE(frame_code_decode(&body[7], length - 7U, entries, count));
    for (uint32_t k = 0U; k < count; k++) {
        drive_out_t ignored;

        if (recorder_unpack(&entries[k], &reader.frame)) {
            drive_step(&reader.drive, &reader.frame.in, &ignored);
            reader.ticks++;
        }
    }
    reader.entry += count;
    reader.messages++;
}

/* The line takes a message; the reader has it at once. */
static void take_message(void)
{
    if (out.ready && (run.drive.tick >= busy_until)) {
        const uint8_t *const body = &out.bytes[2];
        const uint32_t length = out.length - LINK_CRC_BYTES - 2U;

        TEST_ASSERT_EQUAL_UINT8(0U, out.bytes[1]);
        if (out.bytes[0] == (uint8_t)LINK_SEGMENT) {
            read_segment(body, length);
        } else {
            TEST_ASSERT_EQUAL_UINT8(LINK_FRAMES, out.bytes[0]);
            read_entries(body, length);
        }
        link_out_start(&out);
        busy_until = run.drive.tick + busy;
    }
}

static void pass(void)
{
    if (link_out_is_free(&out)) {
        link_stream_step(&stream, &out, run.drive.tick);
    }
    take_message();
}

static void ticks(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        recorded_run_ticks(&run, 1U);
        pass();
    }
}

static void begin(void)
{
    recorded_run_ticks(&run, 3U);
    link_stream_begin(&stream, &run.recorder);
}

TEST(test_every_tick_of_the_run_comes_out_and_the_hashes_agree)
{
    begin();
    ticks(5000U);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
    TEST_ASSERT_EQUAL_UINT32(0U, stream.lost);
    TEST_ASSERT_GREATER_THAN_UINT32(5000U / RUN_SEGMENT_ENTRIES, reader.segments);
    TEST_ASSERT_UINT32_WITHIN(RUN_SEGMENT_ENTRIES, 5000U, reader.ticks);
}

TEST(test_before_the_ring_has_a_segment_the_stream_waits_for_it)
{
    link_stream_begin(&stream, &run.recorder);
    pass();
    TEST_ASSERT_EQUAL_UINT32(0U, reader.segments);
    ticks(1000U);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
    TEST_ASSERT_EQUAL_UINT32(0U, stream.lost);
    TEST_ASSERT_GREATER_THAN_UINT32(500U, reader.ticks);
}

/*
 * A message holds 64 entries at most, and so 100 ticks for each are too many. On a line that is
 * slower yet the ring loses a segment before its message has left: this reader looks into the ring
 * only then.
 */
TEST(test_a_line_that_is_too_slow_leaves_ticks_out_and_says_how_many)
{
    begin();
    busy = 100U;
    ticks(20000U);
    TEST_ASSERT_GREATER_THAN_UINT32(1U, reader.gaps);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, stream.lost);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(reader.drive.tick - reader.first_tick - stream.lost,
                                     reader.ticks, "each tick is sent or counted as lost");
}

TEST(test_a_line_that_was_blocked_goes_on_with_the_newest_segment)
{
    begin();
    ticks(600U);
    busy_until = run.drive.tick + 3000U;
    ticks(3000U);
    const uint32_t newest = recorder_newest(&run.recorder);
    ticks(60U);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(newest, reader.segment);
    TEST_ASSERT_EQUAL_UINT32(2U, reader.gaps);
    ticks(2000U);
    TEST_ASSERT_EQUAL_UINT32(2U, reader.gaps);
}

TEST(test_few_entries_wait_for_more_and_not_longer_than_8_ms)
{
    begin();
    ticks(100U);
    reader.messages = 0U;
    ticks(800U);
    /* a message each 8 ms at the latest, and each segment's end: not one a tick */
    TEST_ASSERT_LESS_OR_EQUAL_UINT32((800U / 40U) + 8U, reader.messages);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(800U / 80U, reader.messages);
}

TEST(test_entries_that_are_limited_come_in_messages_of_so_many_at_most)
{
    begin();
    link_stream_limit(&stream, 16U);
    ticks(100U);
    reader.messages = 0U;
    ticks(800U);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(800U / 16U, reader.messages);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
}

static uint32_t ticks_to_message(void)
{
    uint32_t count = 0U;

    for (reader.messages = 0U; reader.messages == 0U; count++) {
        ticks(1U);
    }
    return count;
}

static uint32_t entries_left(void)
{
    recorder_view_t view = {0};

    TEST_ASSERT_TRUE(recorder_find(&run.recorder, reader.segment, &view));
    return view.entries - reader.entry;
}

/* On a line that is free; a whole segment's messages. */
static void assert_message_each(uint32_t count)
{
    for (uint32_t k = 0U; k < (RUN_SEGMENT_ENTRIES / count); k++) {
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(count, ticks_to_message());
        TEST_ASSERT_EQUAL_UINT32(0U, entries_left());
    }
}

TEST(test_a_message_goes_with_the_tick_that_fills_it_also_where_more_is_allowed_than_there_is)
{
    begin();
    link_stream_limit(&stream, 16U);
    ticks(100U);
    assert_message_each(16U);
    link_stream_limit(&stream, 255U);
    (void)ticks_to_message();
    assert_message_each(FRAME_CODE_ENTRIES_MAX);
}

/* Ticks so long that few fill no message: none is sent before its time, and none waits longer. */
TEST(test_entries_that_wait_go_with_the_tick_that_ends_8_ms)
{
    const units_rotation_t slow = {.pole_pairs = 2U, .tick_ps = 400000000U};
    const uint32_t wait = 20U; /* ticks in 8 ms */

    link_stream_init(&stream, &slow);
    begin();
    while (reader.segments < 3U) {
        ticks(1U);
    }
    (void)ticks_to_message();
    for (uint32_t k = 0U; k < 3U; k++) {
        TEST_ASSERT_EQUAL_UINT32(wait, ticks_to_message());
    }
}

TEST(test_a_pass_without_a_tick_has_nothing_to_send_once_all_is_sent)
{
    begin();
    ticks(100U);
    for (uint32_t k = 0U; k < 200U; k++) {
        ticks(1U);
        reader.messages = 0U;
        pass();
        pass();
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(1U, reader.messages);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
}

TEST(test_the_number_behind_the_largest_is_one)
{
    run.recorder.ended = UINT32_MAX - 1U;
    begin();
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, recorder_newest(&run.recorder));
    ticks(600U);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
    TEST_ASSERT_LESS_THAN_UINT32(UINT32_MAX, reader.segment);
}

/* A recording that was held and is released begins anew: for a moment there is no segment. */
TEST(test_a_stream_waits_while_the_recorder_begins_anew)
{
    begin();
    ticks(500U);
    recorder_hold(&run.recorder, &run.drive);
    while (!run.recorder.frozen) {
        ticks(1U);
    }
    for (uint32_t k = 0U; k < 20U; k++) {
        pass();
    }
    recorder_release(&run.recorder);
    recorder_service(&run.recorder, &run.drive);
    TEST_ASSERT_EQUAL_UINT32(0U, recorder_newest(&run.recorder));
    pass();
    ticks(1000U);
    TEST_ASSERT_EQUAL_UINT32(2U, reader.gaps);
    TEST_ASSERT_GREATER_THAN_UINT32(800U, reader.ticks);
}

TEST(test_a_fault_does_not_end_the_stream)
{
    begin();
    ticks(500U);
    recorded_run_fail(&run);
    ticks(3000U);
    TEST_ASSERT_EQUAL(DRIVE_STATE_FAULT, reader.drive.state);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.gaps);
    TEST_ASSERT_EQUAL_UINT32(0U, stream.lost);
}

TEST(test_a_stream_that_ends_says_nothing_and_one_that_begins_again_starts_anew)
{
    begin();
    ticks(500U);
    link_stream_end(&stream);
    reader.messages = 0U;
    ticks(500U);
    TEST_ASSERT_EQUAL_UINT32(0U, reader.messages);
    link_stream_begin(&stream, &run.recorder);
    reader.segments = 0U;
    ticks(500U);
    TEST_ASSERT_EQUAL_UINT32(2U, reader.gaps);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0U, stream.lost, "what was not asked for is not lost");
}

TEST(test_a_hash_takes_many_passes_and_no_message_comes_before_it)
{
    begin();
    for (uint32_t words = 32U; words < drive_words_count(); words += 32U) {
        link_stream_step(&stream, &out, 0U);
        TEST_ASSERT_TRUE(link_out_is_free(&out));
    }
    link_stream_step(&stream, &out, 0U);
    TEST_ASSERT_FALSE(link_out_is_free(&out));
}

static uint32_t put(uint32_t segment, uint32_t first, uint32_t count)
{
    link_out_begin(&out, 1U, 0U);
    return link_stream_put_entries(&run.recorder, &out, segment, first, count);
}

TEST(test_entries_that_are_asked_for_again_are_those_of_the_ring_as_far_as_it_has_them)
{
    recorder_entry_t entries[FRAME_CODE_ENTRIES_MAX];
    recorder_view_t view = {0};

    recorded_run_ticks(&run, 200U);
    const uint32_t newest = recorder_newest(&run.recorder);
    TEST_ASSERT_TRUE(recorder_find(&run.recorder, newest - 1U, &view));
    TEST_ASSERT_EQUAL_UINT32(5U, put(newest - 1U, 7U, 5U));
    TEST_ASSERT_EQUAL_UINT8(5U, out.bytes[8]);
    TEST_ASSERT_TRUE(frame_code_decode(&out.bytes[9], out.length - 9U, entries, 5U));
    TEST_ASSERT_EQUAL_HEX32(view.first[7].word[0], entries[0].word[0]);
    TEST_ASSERT_EQUAL_UINT32(1U, put(newest - 1U, view.entries - 1U, 64U));
    TEST_ASSERT_EQUAL_UINT32(0U, put(newest - 1U, view.entries, 64U));
    TEST_ASSERT_EQUAL_UINT32(0U, put(newest - 1U, 65535U, 64U));
    TEST_ASSERT_EQUAL_UINT32(0U, put(newest + 1U, 0U, 64U));
    TEST_ASSERT_EQUAL_UINT32(0U, put(newest - 1U, 0U, 0U));
    TEST_ASSERT_EQUAL_UINT32(9U, out.length);
    TEST_ASSERT_GREATER_THAN_UINT32(1U, put(newest - 1U, 0U, 255U));
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(LINK_MESSAGE_BYTES_MAX, out.length);
}

/* Of a motor that rests more would fit, and a code of more is none. */
TEST(test_entries_that_are_asked_for_again_are_no_more_than_a_code_may_have)
{
    recorded_run_noise(&run);
    for (uint32_t k = 0U; k < (2U * RUN_SEGMENT_ENTRIES); k++) {
        recorded_run_interrupt(&run);
        recorder_service(&run.recorder, &run.drive);
    }
    TEST_ASSERT_EQUAL_UINT32(FRAME_CODE_ENTRIES_MAX,
                             put(recorder_newest(&run.recorder) - 1U, 0U, 255U));
}
