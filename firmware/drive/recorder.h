/* SPDX-License-Identifier: MIT */
/*
 * The flight recorder: a ring of input and output frames, and a snapshot of the drive's state where it begins.
 *
 *     control interrupt    recorder_step(&recorder, &drive, &in, &out);    after drive_step() of that frame
 *     background           recorder_service(&recorder, &drive);            once a tick or more often
 *
 * drive_step() is pure: the snapshot, the configuration and the input frames are the run, and the outputs are its
 * proof. The ring is RECORDER_SEGMENTS segments, each with a snapshot of its own from before its first frame. When
 * one is nearly full the background copies the drive's state between two ticks and offers the next; the
 * interrupt takes it if the copy is of this very tick, and rejects it otherwise. So the interrupt never copies
 * a state, and all but one segments of history are there at any time.
 *
 * Once the drive is in FAULT, recording goes on for post_ticks and then freezes, with one more snapshot: the state
 * after the last frame. It is held, whatever the drive does, until it is released: a fault that is cleared is not
 * forgotten. Then it begins anew, in FAULT once that is left: until then it can be read again.
 *
 * A background that is away for more than RECORDER_MARGIN ticks at the end of a segment leaves a gap. What is
 * before a gap is no longer part of the history.
 */
#ifndef RECORDER_H
#define RECORDER_H

#include "drive.h"

#include <stdbool.h>
#include <stdint.h>

#define RECORDER_SEGMENTS (4U)
#define RECORDER_STATES (5U)  /* one more: before each segment's first frame, and after the last */
#define RECORDER_MARGIN (16U) /* entries left in a segment when the next is offered */
#define RECORDER_ENTRIES_MIN (4U * RECORDER_MARGIN) /* of a segment */
#define RECORDER_POST_TICKS_MAX (1000000U)

/*
 * One of two things.
 *
 *     frame    adc_ia, adc_ib; adc_bus, flags; compare of a and b; compare of c with gate_enable in bit 15, angle:
 *              two halves of 16 bits a word, the lower first; a compare value has 15 bits
 *     change   bit 15 of the third word; target; mode, request, adc_temperature: 8, 8 and 16 bits. They are those of
 *              the frames that follow, up to the next change
 *
 * A segment begins with a change.
 */
typedef struct {
    uint32_t word[4];
} recorder_entry_t;

/* What a tick was given, and what it made of it. */
typedef struct {
    drive_in_t in;
    drive_out_t out;
} recorder_frame_t;

typedef struct {
    const recorder_entry_t *end; /* behind its last entry, once it is left */
    bool follows;                /* on the segment before it, without a gap */
} recorder_segment_t;

typedef struct {
    recorder_entry_t *volatile at;         /* the next entry … */
    const recorder_entry_t *volatile stop; /* … if it is before this */
    uint32_t target;                       /* of the last change */
    uint32_t slow;                         /* likewise: the word behind it */
    volatile uint32_t current;             /* segment; RECORDER_SEGMENTS: none yet */
    volatile bool offered;                 /* `next` may be entered in the tick `next_tick` */
    volatile bool frozen;
    uint32_t next; /* segment, or RECORDER_SEGMENTS: the end */
    uint32_t next_tick;
    bool gap;         /* a tick was not recorded */
    bool triggered;   /* to be frozen … */
    uint32_t trigger; /* … post_ticks after this tick */
    bool held;        /* stays as it is once it is frozen */
    recorder_entry_t *entries;
    uint32_t segment_entries;
    uint32_t post_ticks;
    recorder_segment_t segments[RECORDER_SEGMENTS];
    drive_t states[RECORDER_STATES];
} recorder_t;

/*
 * Nothing recorded, not frozen. `entries` has room for RECORDER_SEGMENTS · segment_entries and outlives the recorder;
 * post_ticks 0…RECORDER_POST_TICKS_MAX. Returns NULL, or the name of the argument that is out of range. Call
 * before the first tick.
 */
const char *recorder_init(recorder_t *recorder, recorder_entry_t *entries, uint32_t segment_entries,
                          uint32_t post_ticks);

/* Records a tick: its frames, and the drive after it. Context: control interrupt, after drive_step(). */
void recorder_step(recorder_t *recorder, const drive_t *drive, const drive_in_t *in,
                   const drive_out_t *out);

/* Takes snapshots, freezes and begins anew. Context: background; a tick may come at any instruction. */
void recorder_service(recorder_t *recorder, const drive_t *drive);

/*
 * Has the recording frozen as soon as possible, after a fault not before post_ticks, and held. One that is held
 * already, as that of a fault is, stays as it is. Context: background.
 */
void recorder_hold(recorder_t *recorder, const drive_t *drive);
void recorder_release(recorder_t *recorder);

/*
 * A frozen recording: the oldest segment of the history, and the number of entries from its beginning to the
 * end. Context: background. Of one that is not frozen: 0 entries.
 */
typedef struct {
    uint32_t first; /* segment */
    uint32_t entries;
    uint32_t of_segment[RECORDER_SEGMENTS]; /* from the first on */
} recorder_history_t;

recorder_history_t recorder_history(const recorder_t *recorder);

/* Entry `at` of the history, below its number of entries. */
const recorder_entry_t *recorder_entry(const recorder_t *recorder,
                                       const recorder_history_t *history, uint32_t at);

/* The state before the first frame of the history, and after the last. */
const drive_t *recorder_begin_state(const recorder_t *recorder, const recorder_history_t *history);
const drive_t *recorder_end_state(const recorder_t *recorder);

/* Takes the next entry. True when `frame` is now that of a tick; false after a change. Pure. */
bool recorder_unpack(const recorder_entry_t *entry, recorder_frame_t *frame);

#endif
