/* SPDX-License-Identifier: MIT */
/*
 * A frozen recording as a file of recorder_dump.h whose entries are packed, for a memory that has
 * little room: some 2 bytes a tick in place of 16. The words come one by one.
 *
 * The entries are in pieces. A piece is
 *
 *     number of entries in bits 0…7, bytes of their code in bits 8…15
 *     CRC-32 of their outputs: of the third word and the lower half of the fourth one of each frame
 *     the code (frame_code.h), filled up with zeros to a whole word
 *
 * The code has no outputs: a reader computes them from the state and the inputs, and the CRC tells
 * whether they are those that the drive had.
 *
 * The file has as many of the last segments of the recording as fit.
 *
 * Context: background. It reads frozen data only; the caller keeps the recording and its
 * configurations as they are until the last word.
 */
#ifndef RECORDER_PACK_H
#define RECORDER_PACK_H

#include "recorder_dump.h"

#include <stdbool.h>
#include <stdint.h>

#define RECORDER_PACK_BYTES (96U) /* largest code of a piece */
#define RECORDER_PACK_WORDS (2U + (RECORDER_PACK_BYTES / 4U))

typedef struct {
    recorder_dump_t dump;
    uint32_t room;    /* words that the entries may take */
    uint32_t segment; /* in the history; the entries from it on fit */
    uint32_t taken;   /* words of the entries of whole segments that fit */
    uint32_t words;   /* the same with the segment that is measured */
    uint32_t entry;   /* the next entry of the segment, later of the history */
    uint32_t piece[RECORDER_PACK_WORDS];
    uint32_t in_piece; /* words of the piece */
    uint32_t at;       /* the next word of the piece */
} recorder_pack_t;

/* Begins a file of at most `room` words. The recorder must be frozen and held. */
void recorder_pack_start(recorder_pack_t *pack, const recorder_t *recorder,
                         const recorder_about_t *about, uint32_t room);

/*
 * Chooses the segments, a piece in each call. Returns true as long as it has to be called again.
 * About 25000 instructions. When it has returned false, pack->dump.header says what the file has;
 * no entries when no segment fits.
 */
bool recorder_pack_measure(recorder_pack_t *pack);

/*
 * Returns the next word of the file, header.words in all. At most some 25000 instructions, usually
 * 100.
 */
uint32_t recorder_pack_next(recorder_pack_t *pack);

#endif
