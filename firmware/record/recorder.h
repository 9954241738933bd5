/* SPDX-License-Identifier: MIT */
/*
 * The flight recorder: a ring of input and output frames, with snapshots of the drive's state.
 *
 *     control interrupt  recorder_step(&recorder, &drive, &in, &out);  after each drive_step()
 *     background         recorder_service(&recorder, &drive);          once a tick or more often
 *
 * drive_step() is pure. So a snapshot, the configuration and the input frames determine the run,
 * and the recorded outputs let a replay check itself.
 *
 * The ring has RECORDER_SEGMENTS segments. Each has a snapshot of the state before its first frame.
 * When a segment is nearly full, the background copies the state of the drive between two ticks and
 * offers the next segment. The interrupt takes it when the copy belongs to exactly this tick, and
 * rejects it otherwise. So the interrupt never copies a state, and at any time all segments but one
 * hold history.
 *
 * When the drive enters FAULT, recording goes on for post_ticks and then freezes, with one more
 * snapshot: the state after the last frame. The recording is held until it is released, even when
 * the fault is cleared. After the release a new recording begins. If the drive is still in FAULT,
 * it begins when the drive leaves FAULT, and the old one can be read again until then.
 *
 * When the background is busy for more than RECORDER_MARGIN ticks at the end of a segment, there is
 * a gap. Frames before a gap are no longer part of the history.
 *
 * A reader can follow the ring while it is written, see "Reading while it records" below. While a
 * reader follows, a fault does not freeze the recording: the reader has the frames, and goes on.
 */
#ifndef RECORDER_H
#define RECORDER_H

#include "drive.h"
#include "recorder_entry.h"

#include <stdbool.h>
#include <stdint.h>

#define RECORDER_SEGMENTS (4U)
/* one more than RECORDER_SEGMENTS; a literal number, because the proof needs one */
#define RECORDER_STATES (5U)
/* number of entries left in a segment when the next segment is offered */
#define RECORDER_MARGIN (16U)
#define RECORDER_ENTRIES_MIN (4U * RECORDER_MARGIN) /* smallest size of a segment */
#define RECORDER_ENTRIES_MAX (65535U)               /* largest size of a segment */
#define RECORDER_POST_TICKS_MAX (1000000U)

/* Input and output of a tick. */
typedef struct {
    drive_in_t in;
    drive_out_t out;
} recorder_frame_t;

typedef struct {
    /* the place after the last entry of the segment, valid once the segment is complete */
    const recorder_entry_t *end;
    /* counts the segments from 1 on, wrapping; 0: the segment is empty */
    uint32_t number;
    uint32_t config_crc; /* CRC of the configuration before the first frame of the segment */
    /*
     * recorder_hash() of the state before its first frame, for whoever finds it in a memory after a
     * reset; 0: not computed yet
     */
    uint32_t hash;
    uint32_t summed; /* number of its entries that `sum` covers */
    uint32_t sum;    /* recorder_entry_sum() of them, for the same reader */
    bool follows;    /* the segment continues the one before it without a gap */
} recorder_segment_t;

typedef struct {
    /* the place of the next entry, as long as it is not beyond the stop */
    recorder_entry_t *volatile at;
    /* the last place at which a tick may begin; NULL: the next tick calls turn_over() */
    const recorder_entry_t *volatile stop;
    /*
     * largest distance of `at` before the stop, in entries. It has 16 bits: whatever bits of it
     * flip, it stays below the huge distance of an `at` beyond the stop (ring.h)
     */
    uint16_t span;
    const recorder_entry_t *due_stop; /* `stop` as the interrupt has set it */
    uint32_t target;                  /* first word of the last change */
    /* second word of the last change: mode, request, temperature */
    uint32_t slow;
    volatile uint32_t current; /* the segment that is written; RECORDER_SEGMENTS: none yet */
    volatile bool offered;     /* segment `next` may begin in the tick `next_tick` */
    volatile bool frozen;
    uint32_t next;  /* segment that is offered; RECORDER_SEGMENTS: the recording ends */
    uint32_t ended; /* number of the last segment before the recording began anew */
    uint32_t next_tick;
    bool gap;         /* a tick was not recorded */
    bool triggered;   /* the recording is going to freeze */
    uint32_t trigger; /* tick of the trigger: the recording freezes post_ticks after it */
    bool held;        /* keep the recording once it is frozen */
    /* a reader follows the ring: a fault does not freeze the recording */
    bool followed;
    /*
     * the drive is in FAULT, and a reader follows or has followed during this FAULT: the fault does
     * not freeze the recording, even when the reader has left
     */
    bool passed;
    uint32_t kept;             /* number of the segment whose state a reader has kept, 0: none */
    bool changed;              /* the next frame is the first with another configuration */
    const drive_cfg_t *before; /* the configuration before the last change, NULL: none */
    recorder_entry_t *entries;
    uint32_t segment_entries;
    /* copies of entries and segment_entries: if they differ, turn_over() gives no place to write */
    const recorder_entry_t *due_entries;
    uint32_t due_segment_entries;
    uint32_t post_ticks;
    /* recorder_hash() of the state after the last frame; 0: not frozen, or not computed yet */
    uint32_t end_hash;
    recorder_segment_t segments[RECORDER_SEGMENTS];
    /*
     * The state before the first frame of each segment. The last one belongs to no segment: in a
     * frozen recording it is the state after the last frame; before, while `kept` is not 0, it is
     * the state that a reader has kept.
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

/* Records the input and output frame of a tick. Context: control interrupt, after drive_step(). */
void recorder_step(recorder_t *recorder, const drive_t *drive, const drive_in_t *in,
                   const drive_out_t *out);

/*
 * Call when the drive takes another configuration in place of `before`. The next frame is the first
 * one with it; a change is recorded in front of this frame. The caller keeps `before` as long as
 * the recording may need it. If the caller overwrites it, the history begins after the change.
 * Context: control interrupt, before drive_step().
 */
void recorder_change(recorder_t *recorder, const drive_cfg_t *before);

/*
 * Takes snapshots, freezes and restarts the recording, and notes check words of states and entries
 * for whoever finds them in a memory after a reset. Context: background; a tick may interrupt it
 * anywhere.
 */
void recorder_service(recorder_t *recorder, const drive_t *drive);

/* Returns a check word of a state: its hash, but not 0. About 16000 instructions. */
uint32_t recorder_hash(const drive_t *state);

/*
 * recorder_hold freezes the recording as soon as possible and holds it; after a fault it does not
 * freeze before post_ticks. A recording that is already held, as after a fault, stays as it is.
 * recorder_release ends the hold. Context: background.
 */
void recorder_hold(recorder_t *recorder, const drive_t *drive);
void recorder_release(recorder_t *recorder);

/*
 * History of a frozen recording: its oldest segment, and the number of entries from there to the
 * end. It has 0 entries when the recording is not frozen, when its last segment has more than two
 * configurations or one that was overwritten, or when a flipped bit has spoilt the ring. Context:
 * background.
 */
typedef struct {
    uint32_t first; /* oldest segment */
    uint32_t entries;
    uint32_t of_segment[RECORDER_SEGMENTS]; /* entries of each segment, from the first one on */
    bool changes; /* another configuration than that of its begin is in force in it, too */
} recorder_history_t;

recorder_history_t recorder_history(const recorder_t *recorder);

/* Returns entry `at` of the history; `at` is below its number of entries. */
const recorder_entry_t *recorder_entry(const recorder_t *recorder,
                                       const recorder_history_t *history, uint32_t at);

/*
 * Return the state before the first frame of the history and after the last one; ->cfg is the
 * configuration at that time.
 */
const drive_t *recorder_begin_state(const recorder_t *recorder, const recorder_history_t *history);
const drive_t *recorder_end_state(const recorder_t *recorder);

/*
 * Returns the configuration that the history changes to, even if it changes back later; NULL when
 * the configuration of its begin is in force all the time.
 */
const drive_cfg_t *recorder_further_config(const recorder_t *recorder,
                                           const recorder_history_t *history);

/*
 * Reading while it records. A segment is named by its number. Call all of these in the background,
 * between two calls of recorder_service(). Their results are valid until its next call.
 */

/*
 * Call when a reader begins, or ends. While it follows, a fault does not freeze the recording, and
 * a recording that is frozen but not held begins anew at once.
 */
void recorder_follow(recorder_t *recorder, bool on);

/* Returns the number of the segment that is written, 0 when there is none. */
uint32_t recorder_newest(const recorder_t *recorder);

/* A segment of the ring. */
typedef struct {
    const recorder_entry_t *first;
    uint32_t entries;     /* number of entries written so far */
    bool complete;        /* there will not be more entries */
    bool follows;         /* nothing is missing between the segment before it and this one */
    uint32_t config_crc;  /* CRC of the configuration of `state` */
    const drive_t *state; /* state before the first frame of the segment */
} recorder_view_t;

/*
 * Fills `view`. Returns false when the segment of this number is not in the ring, or not any more.
 */
bool recorder_find(const recorder_t *recorder, uint32_t number, recorder_view_t *view);

/*
 * Returns the state before a segment, and keeps a copy of it. Later calls with the same number
 * return the same state, even if the ring has overwritten the segment since then. The copy is lost
 * when another segment is asked for or the recording is about to freeze, because a frozen recording
 * needs its place. From the trigger of a freeze on, no copy is made: the state in the ring is
 * returned. Returns NULL when the segment is neither in the ring nor kept.
 */
const drive_t *recorder_keep_state(recorder_t *recorder, uint32_t number);

/*
 * Decodes the next entry into `frame`. Returns true when the entry was a frame, so that `frame` is
 * complete. A change sets only its part of `frame->in` and returns false. Pure.
 */
bool recorder_unpack(const recorder_entry_t *entry, recorder_frame_t *frame);

#endif
