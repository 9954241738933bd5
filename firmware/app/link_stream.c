/* SPDX-License-Identifier: MIT */
#include "link_stream.h"

#include "drive_words.h"
#include "frame_code.h"

#include <stddef.h>

#define WAIT_US (8000U) /* see wait_ticks; 64 entries at 10 kHz take 6.4 ms */
/* words that are hashed in one pass, in some 1500 instructions */
#define HASH_WORDS_OF_A_PASS (32U)
#define CHANGE_MARK (0x8000U)
#define MARK_WORD (2U)

static uint32_t fewer(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

void link_stream_init(link_stream_t *stream, const units_rotation_t *rotation)
{
    *stream = (link_stream_t){.wait_ticks = units_ticks(rotation, WAIT_US)};
}

/* Begins a segment: it is not announced yet, and none of its words is hashed. */
static void start_segment(link_stream_t *stream, uint32_t number)
{
    stream->segment = number;
    stream->announced = false;
    stream->hash = DRIVE_WORDS_HASH_START;
    stream->hashed = 0U;
    stream->next = 0U;
}

void link_stream_begin(link_stream_t *stream, recorder_t *recorder)
{
    stream->recorder = recorder;
    stream->on = true;
    stream->began = false;
    stream->before = 0U;
    stream->before_entries = 0U;
    stream->most = FRAME_CODE_ENTRIES_MAX;
    recorder_follow(recorder, true);
    start_segment(stream, recorder_newest(recorder));
}

void link_stream_limit(link_stream_t *stream, uint32_t most)
{
    stream->most = fewer(most, FRAME_CODE_ENTRIES_MAX);
}

void link_stream_end(link_stream_t *stream)
{
    if (stream->on) {
        recorder_follow(stream->recorder, false);
    }
    stream->on = false;
}

static uint32_t number_behind(uint32_t number)
{
    return (number == UINT32_MAX) ? 1U : (number + 1U);
}

/*
 * Returns the number of frames among the entries. A frame is one tick; the other entries are
 * changes.
 */
static uint32_t frames_of(const recorder_entry_t *entries, uint32_t count)
{
    uint32_t frames = 0U;

    for (uint32_t k = 0U; k < count; k++) {
        frames += ((entries[k].word[MARK_WORD] & CHANGE_MARK) == 0U) ? 1U : 0U;
    }
    return frames;
}

/* Appends entries of a segment: their number and their code. Returns their number. */
static uint32_t put_from(const recorder_view_t *view, link_out_t *out, uint32_t first,
                         uint32_t count)
{
    uint32_t room = 0U;
    uint32_t length = 0U;
    uint32_t put = 0U;
    uint8_t *const number = link_out_room(out, &room);

    link_out_byte(out, 0U);
    if (count > 0U) {
        uint8_t *const code = link_out_room(out, &room);

        put = frame_code_encode(&view->first[first], count, code, room, &length);
        link_out_add(out, length);
        *number = (uint8_t)put;
    }
    return put;
}

uint32_t link_stream_put_entries(const recorder_t *recorder, link_out_t *out, uint32_t segment,
                                 uint32_t first, uint32_t count)
{
    recorder_view_t view = {0};
    uint32_t there = 0U;

    link_out_word(out, segment);
    link_out_half(out, first);
    if ((recorder != NULL) && recorder_find(recorder, segment, &view) && (first < view.entries)) {
        there = view.entries - first;
    }
    return put_from(&view, out, first, fewer(fewer(there, count), FRAME_CODE_ENTRIES_MAX));
}

/*
 * Goes on with the newest segment, because the segment that was to be sent is not in the ring any
 * more, or will never come.
 */
static void skip_to_newest(link_stream_t *stream)
{
    const uint32_t newest = recorder_newest(stream->recorder);

    if (newest != 0U) {
        stream->before_entries = 0U;
        start_segment(stream, newest);
    }
}

static void announce_segment(link_stream_t *stream, const recorder_view_t *view, link_out_t *out)
{
    const uint32_t tick = view->state->tick;
    const bool follows = stream->began && (tick == stream->next_tick);

    if (stream->began) {
        stream->lost += tick - stream->next_tick;
    }
    link_out_begin(out, LINK_SEGMENT, 0U);
    link_out_word(out, stream->segment);
    link_out_word(out, tick);
    link_out_word(out, stream->hash);
    link_out_word(out, view->config_crc);
    link_out_half(out, stream->before_entries);
    link_out_byte(out, follows ? 1U : 0U);
    link_out_end(out);
    stream->announced = true;
    stream->began = true;
    stream->next_tick = tick;
}

/* Announces the segment when the hash is complete. */
static void go_on_hashing(link_stream_t *stream, const recorder_view_t *view, link_out_t *out)
{
    stream->hash =
        drive_words_hash_part(stream->hash, view->state, &stream->hashed, HASH_WORDS_OF_A_PASS);
    if (stream->hashed >= drive_words_count()) {
        announce_segment(stream, view, out);
    }
}

static void send_entries(link_stream_t *stream, const recorder_view_t *view, link_out_t *out,
                         uint32_t tick)
{
    uint32_t put;

    link_out_begin(out, LINK_FRAMES, 0U);
    put =
        link_stream_put_entries(stream->recorder, out, stream->segment, stream->next, stream->most);
    link_out_end(out);
    stream->next_tick += frames_of(&view->first[stream->next], put);
    stream->next += put;
    stream->sent_tick = tick;
}

static void go_on_sending(link_stream_t *stream, const recorder_view_t *view, link_out_t *out,
                          uint32_t tick)
{
    const uint32_t left = view->entries - stream->next;
    const bool waited = (tick - stream->sent_tick) >= stream->wait_ticks;

    if ((left >= stream->most) || ((left > 0U) && (view->complete || waited))) {
        send_entries(stream, view, out, tick);
    } else if ((left == 0U) && view->complete) {
        stream->before = stream->segment;
        stream->before_entries = stream->next;
        start_segment(stream, number_behind(stream->segment));
    } else {
        /* more entries will come */
    }
}

/*
 * Whether the segment to be sent will still come. It will come if the segment before it is the
 * newest in the ring. Otherwise the ring was begun anew or has overwritten the segment.
 */
static bool will_come(const link_stream_t *stream)
{
    return recorder_newest(stream->recorder) == stream->before;
}

void link_stream_step(link_stream_t *stream, link_out_t *out, uint32_t tick)
{
    recorder_view_t view = {0};

    if (!stream->on) {
        /* the stream is off */
    } else if (!recorder_find(stream->recorder, stream->segment, &view)) {
        if (!will_come(stream)) {
            skip_to_newest(stream);
        }
    } else if (!stream->announced) {
        go_on_hashing(stream, &view, out);
    } else {
        go_on_sending(stream, &view, out, tick);
    }
}
