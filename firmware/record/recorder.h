/* SPDX-License-Identifier: MIT */
/*
 * The flight recorder: a ring of input and output frames, and a snapshot of the drive's state where
 * it begins.
 *
 *     control interrupt  recorder_step(&recorder, &drive, &in, &out);  after each drive_step()
 *     background         recorder_service(&recorder, &drive);          once a tick or more often
 *
 * drive_step() is pure. So a snapshot, the configuration and the input frames determine the run,
 * and the recorded outputs let a replay check itself.
 *
 * The ring has RECORDER_SEGMENTS segments. Each has a snapshot from before its first frame. When a
 * segment is nearly full, the background copies the state of the drive between two ticks and offers
 * the next segment. The interrupt takes it when the copy belongs to exactly this tick, and rejects
 * it otherwise. So the interrupt never copies a state, and at any time all segments but one hold
 * history.
 *
 * When the drive enters FAULT, recording goes on for post_ticks and then freezes, with one more
 * snapshot: the state after the last frame. The recording is held until it is released, even when
 * the fault is cleared. After the release it begins anew; in FAULT it waits until the drive leaves
 * FAULT, and can be read again until then.
 *
 * When the background is busy for more than RECORDER_MARGIN ticks at the end of a segment, there is
 * a gap. Frames before a gap are no longer part of the history.
 *
 * A reader can follow the ring while it is written: recorder_find() and what is below it. While it
 * does, a fault does not freeze the recording: the reader has the frames, and goes on.
 */
#ifndef RECORDER_H
#define RECORDER_H

#include "drive.h"
#include "recorder_entry.h"

#include <stdbool.h>
#include <stdint.h>

#define RECORDER_SEGMENTS (4U)
#define RECORDER_STATES (5U)  /* one more than segments; the proof takes a literal only */
#define RECORDER_MARGIN (16U) /* entries left in a segment when the next is offered */
#define RECORDER_ENTRIES_MIN (4U * RECORDER_MARGIN) /* of a segment */
#define RECORDER_ENTRIES_MAX (65535U)               /* of a segment */
#define RECORDER_POST_TICKS_MAX (1000000U)

/* Input and output of a tick. */
typedef struct {
    drive_in_t in;
    drive_out_t out;
} recorder_frame_t;

typedef struct {
    const recorder_entry_t *end; /* behind its last entry, valid once the segment is complete */
    uint32_t number;             /* counts the segments from 1 on, wrapping; 0: it holds nothing */
    uint32_t config_crc;         /* of the configuration of the state before it */
    bool follows;                /* it continues the segment before it without a gap */
} recorder_segment_t;

typedef struct {
    recorder_entry_t *volatile at; /* the next entry, as long as it is not beyond the stop */
    /* the last one at which a tick may begin; NULL: turn over */
    const recorder_entry_t *volatile stop;
    /*
     * `at` may be at most so many entries before the stop. No flip of it reaches as far as `at` can
     * be beyond the stop.
     */
    uint16_t span;
    const recorder_entry_t *due_stop; /* `stop` as the interrupt has set it */
    uint32_t target;                  /* first word of the last change */
    uint32_t slow;                    /* its second word: mode, request, temperature */
    volatile uint32_t current;        /* segment; RECORDER_SEGMENTS: none yet */
    volatile bool offered;            /* segment `next` may begin in the tick `next_tick` */
    volatile bool frozen;
    uint32_t next;  /* segment, or RECORDER_SEGMENTS: the end */
    uint32_t ended; /* number of the last segment before the recording began anew */
    uint32_t next_tick;
    bool gap;                  /* a tick was not recorded */
    bool triggered;            /* freeze … */
    uint32_t trigger;          /* … post_ticks after this tick */
    bool held;                 /* keep the recording once it is frozen */
    bool followed;             /* by a reader: a fault does not freeze … */
    bool passed;               /* … nor does it later, while the drive stays in FAULT */
    uint32_t kept;             /* segment whose state a reader has kept, 0: none */
    bool changed;              /* the next frame is the first with another configuration */
    const drive_cfg_t *before; /* the configuration before the last change, NULL: none */
    recorder_entry_t *entries;
    uint32_t segment_entries;
    /* entries and segment_entries once more: where they differ nothing is written */
    const recorder_entry_t *due_entries;
    uint32_t due_segment_entries;
    uint32_t post_ticks;
    recorder_segment_t segments[RECORDER_SEGMENTS];
    /*
     * Before the first frame of each segment. The last one belongs to no segment: while `kept` is
     * not 0 it is the state that a reader has kept, in a frozen recording the state after the last
     * frame.
     */
    drive_t states[RECORDER_STATES];
} recorder_t;

/*
 * Initialise: nothing recorded, not frozen. `entries` has room for RECORDER_SEGMENTS ·
 * segment_entries and must outlive the recorder; segment_entries is
 * RECORDER_ENTRIES_MIN…RECORDER_ENTRIES_MAX, post_ticks 0…RECORDER_POST_TICKS_MAX. Returns NULL, or
 * the name of the argument that is out of range.
 * Call before the first tick.
 */
const char *recorder_init(recorder_t *recorder, recorder_entry_t *entries, uint32_t segment_entries,
                          uint32_t post_ticks);

/*
 * Records a tick: its frames and the tick and state of the drive. Context: control interrupt, after
 * drive_step().
 */
void recorder_step(recorder_t *recorder, const drive_t *drive, const drive_in_t *in,
                   const drive_out_t *out);

/*
 * The drive has another configuration in place of `before`, from the frame on that is recorded
 * next. The frame gets a change in front of it. `before` is kept as long as the recording may need
 * it, or is overwritten: then the history begins behind the change. Context: control interrupt,
 * before drive_step().
 */
void recorder_change(recorder_t *recorder, const drive_cfg_t *before);

/*
 * Takes snapshots, freezes and restarts the recording. Context: background; a tick may interrupt it
 * anywhere.
 */
void recorder_service(recorder_t *recorder, const drive_t *drive);

/*
 * recorder_hold freezes the recording as soon as possible, after a fault not before post_ticks, and
 * holds it. A recording that is held already, as that of a fault is, stays as it is.
 * recorder_release ends that. Context: background.
 */
void recorder_hold(recorder_t *recorder, const drive_t *drive);
void recorder_release(recorder_t *recorder);

/*
 * History of a frozen recording: its oldest segment, and the number of entries from there to the
 * end. It has 0 entries when the recording is not frozen, or when two changes of the configuration
 * have come within its last segment. Context: background.
 */
typedef struct {
    uint32_t first; /* segment */
    uint32_t entries;
    uint32_t of_segment[RECORDER_SEGMENTS]; /* from the first on */
} recorder_history_t;

recorder_history_t recorder_history(const recorder_t *recorder);

/* Returns entry `at` of the history; `at` is below its number of entries. */
const recorder_entry_t *recorder_entry(const recorder_t *recorder,
                                       const recorder_history_t *history, uint32_t at);

/*
 * Return the state before the first frame of the history and after the last one; ->cfg is the
 * configuration then.
 */
const drive_t *recorder_begin_state(const recorder_t *recorder, const recorder_history_t *history);
const drive_t *recorder_end_state(const recorder_t *recorder);

/*
 * Returns the configuration that the history changes to, or changes to and leaves again; NULL when
 * that of its begin is in force all the time.
 */
const drive_cfg_t *recorder_further_config(const recorder_t *recorder,
                                           const recorder_history_t *history);

/*
 * Reading while it records: segments by their number. All in the background, between two calls of
 * recorder_service(); what they return is good until the next one.
 */

/*
 * A reader begins, or ends. While it follows, a fault does not freeze the recording, and a
 * recording that is frozen but not held begins anew at once.
 */
void recorder_follow(recorder_t *recorder, bool on);

/* Returns the number of the segment that is written, 0 when there is none. */
uint32_t recorder_newest(const recorder_t *recorder);

/* A segment of the ring. */
typedef struct {
    const recorder_entry_t *first;
    uint32_t entries;     /* so far */
    bool complete;        /* there will not be more */
    bool follows;         /* nothing is missing between the segment before it and this one */
    uint32_t config_crc;  /* of the configuration of `state` */
    const drive_t *state; /* before its first frame */
} recorder_view_t;

/* False when the segment of this number is not in the ring, or not any more. */
bool recorder_find(const recorder_t *recorder, uint32_t number, recorder_view_t *view);

/*
 * Returns the state before a segment of the ring, and keeps it: asked for again by this number it
 * is the same, also when the ring has overwritten the segment, until another one is asked for or
 * the recording is about to freeze. NULL when the segment is neither in the ring nor kept. A
 * recording that freezes needs the place; its own states are returned as they are.
 */
const drive_t *recorder_keep_state(recorder_t *recorder, uint32_t number);

/*
 * Decodes the next entry into `frame`. True when the entry was a frame, so that `frame` is
 * complete; false for a change. Pure.
 */
bool recorder_unpack(const recorder_entry_t *entry, recorder_frame_t *frame);

#endif
