/* SPDX-License-Identifier: MIT */
/*
 * The stream of the link: follows the ring of the flight recorder and writes LINK_SEGMENT and
 * LINK_FRAMES.
 *
 * A segment is announced with the hash of the state before it, which takes some passes. Then its
 * entries are sent, as many at a time as fit into a message; after 8 ms, or at the end of the
 * segment, a message has fewer. When the line is too slow, the ring overwrites the segment while
 * the stream reads it. Then the stream goes on with the newest segment and counts the ticks in
 * between. Nothing waits for the line.
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
    recorder_t *recorder; /* NULL until the stream has been on */
    uint32_t most;        /* entries of a message */
    uint32_t wait_ticks;  /* longest wait until entries that do not fill a message are sent */
    bool on;
    bool began;       /* a segment was announced since it is on: next_tick counts */
    uint32_t segment; /* number of the segment that is read; 0: none yet */
    bool announced;
    uint32_t hash; /* of the words of its state before `hashed` */
    uint32_t hashed;
    uint32_t next;           /* entry */
    uint32_t before_entries; /* of the segment before; 0: it was not sent to its end */
    uint32_t before;         /* number of that segment */
    uint32_t next_tick;      /* the tick after the last frame that was sent */
    uint32_t sent_tick;      /* when the last entries were sent */
    uint32_t lost;           /* ticks that a stream has left out, since the start */
} link_stream_t;

/* Off. */
void link_stream_init(link_stream_t *stream, const units_rotation_t *rotation);

/* Begins with the newest segment of `recorder`. */
void link_stream_begin(link_stream_t *stream, recorder_t *recorder);
/*
 * At most so many entries in a message, 1…FRAME_CODE_ENTRIES_MAX, until the stream begins again. A
 * larger number is limited to this range.
 */
void link_stream_limit(link_stream_t *stream, uint32_t most);

void link_stream_end(link_stream_t *stream);

/*
 * One pass while `out` is free: at most one message. `tick`: now. Up to 64 entries are coded in a
 * pass, some 20000 instructions.
 */
void link_stream_step(link_stream_t *stream, link_out_t *out, uint32_t tick);

/*
 * Appends the body of LINK_FRAMES: segment, first entry, how many follow, and their code. It takes
 * at most `count` entries from `first` on: fewer if fewer are there or fit, and none if the segment
 * is not in the ring any more. Returns how many.
 */
uint32_t link_stream_put_entries(const recorder_t *recorder, link_out_t *out, uint32_t segment,
                                 uint32_t first, uint32_t count);

#endif
