/* SPDX-License-Identifier: MIT */
/*
 * The stream of the link: follows the ring of the flight recorder and writes LINK_SEGMENT and
 * LINK_FRAMES.
 *
 * LINK_SEGMENT announces a segment, with the hash of the state before it; the hash takes some
 * passes. Then LINK_FRAMES sends its entries, as many in a message as fit. After 8 ms, or at the
 * end of the segment, a message has fewer. When the line is too slow, the ring overwrites the
 * segment while the stream reads it. Then the stream goes on with the newest segment and counts the
 * ticks that it has left out. It never waits for the line.
 *
 * Context: background, between two calls of recorder_service().
 */
#ifndef LINK_STREAM_H
#define LINK_STREAM_H

#include "link_frame.h"
#include "recorder.h"
#include "units.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    recorder_t *recorder; /* NULL before the first link_stream_begin() */
    uint32_t most;        /* largest number of entries in a message */
    uint32_t wait_ticks;  /* longest wait until entries that do not fill a message are sent */
    bool on;
    bool began;       /* a segment was announced since the stream is on, so next_tick is valid */
    uint32_t segment; /* number of the segment that is read; 0: none yet */
    bool announced;   /* this segment was announced */
    uint32_t hash;    /* hash of the first `hashed` words of the state before the segment */
    uint32_t hashed;
    uint32_t next; /* next entry to send */
    /* entries of the segment before; 0: that segment was not sent to its end */
    uint32_t before_entries;
    uint32_t before;    /* number of that segment */
    uint32_t next_tick; /* the tick after the last frame that was sent */
    uint32_t sent_tick; /* tick in which the last entries were sent */
    uint32_t lost;      /* ticks that the stream has left out since link_stream_init() */
} link_stream_t;

/* Sets the stream off. */
void link_stream_init(link_stream_t *stream, const units_rotation_t *rotation);

/* Begins with the newest segment of `recorder`. */
void link_stream_begin(link_stream_t *stream, recorder_t *recorder);
/*
 * Limits the entries in a message to `most`, 1…FRAME_CODE_ENTRIES_MAX, until the stream begins
 * again. A larger number is limited to FRAME_CODE_ENTRIES_MAX.
 */
void link_stream_limit(link_stream_t *stream, uint32_t most);

void link_stream_end(link_stream_t *stream);

/*
 * One pass: writes at most one message into `out`, which must be free. tick: the present tick. Up
 * to 64 entries are coded in a pass, some 20000 instructions.
 */
void link_stream_step(link_stream_t *stream, link_out_t *out, uint32_t tick);

/*
 * Appends the body of LINK_FRAMES: segment, first entry, number of entries, and their code. Takes
 * at most `count` entries from `first` on: fewer if fewer exist or fit, and none if the segment is
 * not in the ring any more. Returns their number.
 */
uint32_t link_stream_put_entries(const recorder_t *recorder, link_out_t *out, uint32_t segment,
                                 uint32_t first, uint32_t count);

#endif
