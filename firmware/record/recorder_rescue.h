/* SPDX-License-Identifier: MIT */
/*
 * Rolls a recording forward on the machine that has made it: drive_step() is pure, so a state and
 * the entries after it give the outputs again, and the state at the end.
 *
 * So a board that was reset can find out whether what lies in its RAM is a recording: it is one if
 * the outputs that the drive computes from it are those that were recorded.
 *
 * Context: background, before the control interrupt is enabled. About a control tick an entry.
 */
#ifndef RECORDER_ROLL_H
#define RECORDER_ROLL_H

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
} recorder_place_t;

/*
 * Makes a frozen recording of a memory that a reset has left, whatever it holds. It may have been
 * frozen before, or have been written until the reset. Returns true when recorder_history() then
 * has a history all outputs of which were computed again: an older segment with another output is
 * left out, and an entry that the reset has left half written. Returns false when the last segment
 * has another output; then the recorder must be initialised.
 *
 * *work: room for a state; when it returns true, it is the state at the end.
 * *cut: the recording was not frozen, so it ends with the reset.
 */
bool recorder_rescue(recorder_t *recorder, const recorder_place_t *place, drive_t *work, bool *cut);

#endif
