/* SPDX-License-Identifier: MIT */
/*
 * A recording in a memory that a reset has left as it was, or nearly so.
 *
 * While the recorder runs it notes a check word of each state and of the entries, and the
 * configurations have their CRC. So a board that was reset finds out whether what lies in its RAM
 * is a recording. Whether the drive computes the recorded outputs from it is for the replay on the
 * PC.
 *
 * Context: background, before the control interrupt is enabled.
 */
#ifndef RECORDER_RESCUE_H
#define RECORDER_RESCUE_H

#include "recorder.h"

#include <stdbool.h>
#include <stdint.h>

/* What was known of a recording before its memory was left to itself. */
typedef struct {
    const recorder_entry_t *entries; /* as for recorder_init() */
    uint32_t segment_entries;
    /*
     * The configurations that the recording may name; NULL: there is none, or its checksum is
     * wrong. No other pointer of the recording is followed.
     */
    const drive_cfg_t *configs[2];
    /*
     * The memory had its supply all the time. Then the entries after those that have a check word
     * belong to the recording, but for the last one, which may be half written.
     */
    bool powered;
} recorder_place_t;

typedef struct {
    bool found; /* recorder_history() has a history; if not, the recorder must be initialised */
    /*
     * The recording was not frozen, so it ends with the reset. Of the state at its end only the
     * tick and the configuration are known.
     */
    bool cut;
    bool drove; /* the gates were on in one of its ticks */
} recorder_rescued_t;

/*
 * Makes a frozen recording of a memory that a reset has left, whatever it holds. It may have been
 * frozen before, or have been written until the reset. An older segment with a wrong check word is
 * left out. Takes five times as long as recorder_hash(), and three passes over the entries.
 */
recorder_rescued_t recorder_rescue(recorder_t *recorder, const recorder_place_t *place);

#endif
