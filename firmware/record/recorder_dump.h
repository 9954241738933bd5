/* SPDX-License-Identifier: MIT */
/*
 * A frozen recording as a file of words, and the file as lines of text, which the caller sends one
 * by one.
 *
 * The recording is a file of 32-bit words
 *
 *     header           RECORDER_HEADER_WORDS, see recorder_header_t
 *     configuration    drive_cfg_t, its last word is its CRC-32
 *     state            drive_words_get(), before the first frame
 *     entries          recorder_entry_t, 4 words each; or packed (recorder_pack.h)
 *     further          drive_cfg_t that an entry changes to, only where the header says so
 *     end              CRC-32 of all words before it
 *
 * Each line holds RECORDER_LINE_WORDS of these words; the last line is filled up with zeros. A line
 * is a '~' and then, in base64, the number of the line, its words and the CRC-32 of both, the
 * lowest byte of a word first. Other text may come between the lines, because it does not begin
 * with '~'. A logger may put text in front of a line.
 *
 * Context: background. It reads frozen data only; the caller holds the recording until the last
 * line.
 */
#ifndef RECORDER_DUMP_H
#define RECORDER_DUMP_H

#include "recorder.h"

#include <stdint.h>

#define RECORDER_MAGIC (0x4452464EU) /* "NFRD" */
#define RECORDER_VERSION (5U)
#define RECORDER_LINE_MARK ('~')
#define RECORDER_LINE_WORDS (13U)
/* characters of a line, without the terminating 0 */
#define RECORDER_LINE_CHARACTERS (1U + (((RECORDER_LINE_WORDS + 2U) / 3U) * 16U))

#define RECORDER_BUILD_WORDS (5U) /* 20 bytes: a GNU build-id */
#define RECORDER_NAME_WORDS (24U)

/*
 * Facts that the frames do not contain. They give the integers their units and do not influence a
 * replay. Each is a fact about the motor or the board. Its unit is chosen so that the whole range
 * of its key fits into 32 bits.
 */
typedef struct {
    uint32_t tick_ps;                     /* 10^7…5·10^8: 100…2 kHz */
    uint32_t current_full_scale_ua;       /* ±, 0.1…2000 A */
    uint32_t bus_full_scale_uv;           /* 5…2000 V */
    uint32_t pole_pairs;                  /* 1…50 */
    uint32_t build[RECORDER_BUILD_WORDS]; /* build-id of the image; zeros: the simulator */
    uint32_t name[RECORDER_NAME_WORDS];   /* motor, board, tuning: characters, then zeros */
    /* the last reset: hal_reset_reason_t in bits 0…7, its exception above them; 0: not known */
    uint32_t reset;
    uint32_t cut; /* 1: this reset has ended the recording; 0: it was before, or after the end */
} recorder_about_t;

/*
 * Writes a name into `about->name`, which must be all zeros before. Text that does not fit is cut
 * off.
 */
void recorder_about_name(recorder_about_t *about, const char *name);

/* The header of the file. All members are words, in this order. */
typedef struct {
    uint32_t magic;
    uint32_t version;
    uint32_t words; /* length of the file in words */
    /*
     * length of the configuration; this or state_words differs when another firmware has recorded
     */
    uint32_t config_words;
    uint32_t state_words;
    uint32_t entries;
    uint32_t further;    /* number of configurations after the entries, 0 or 1 */
    uint32_t first_tick; /* tick of the first frame */
    uint32_t end_tick;   /* the tick after the last frame */
    /* drive_words_hash() of the state at the end; 0 if a reset has cut the recording */
    uint32_t end_hash;
    /*
     * fault_id_t if the recording ends in FAULT, 0 otherwise and if a reset has cut it; so are the
     * next three
     */
    uint32_t fault_id;
    uint32_t fault_value;
    uint32_t fault_limit;
    uint32_t fault_tick;
    uint32_t packed; /* words that the packed entries take; 0: they are not packed */
    recorder_about_t about;
} recorder_header_t;

#define RECORDER_HEADER_WORDS ((uint32_t)(sizeof(recorder_header_t) / sizeof(uint32_t)))

typedef struct {
    const recorder_t *recorder;
    const drive_cfg_t *cfg;     /* configuration at the beginning of the history */
    const drive_cfg_t *further; /* the other configuration of the history, or NULL */
    recorder_history_t history;
    recorder_header_t header;
    uint32_t next; /* index of the next word of the file */
    uint32_t line;
    uint32_t crc; /* CRC-32 of the words before `next` */
} recorder_dump_t;

/*
 * Begins a dump at its first line. The recorder must be frozen and held. Its configurations must
 * stay as they are until the last line; `about` is copied.
 */
void recorder_dump_start(recorder_dump_t *dump, const recorder_t *recorder,
                         const recorder_about_t *about);

/* Sets `words` and `entries` of the header for entries that take so many words. */
void recorder_dump_resize(recorder_dump_t *dump, uint32_t entry_words);

/* Returns word `at` of the file if it is before the entries; `at` is below recorder_dump_first().
 */
uint32_t recorder_dump_head(const recorder_dump_t *dump, uint32_t at);

/* Returns the index of the first word of the entries. */
uint32_t recorder_dump_first(const recorder_dump_t *dump);

/* Returns word `at` of the further configuration, which the recording has. */
uint32_t recorder_dump_further(const recorder_dump_t *dump, uint32_t at);

/* Returns the number of lines that a file of so many words takes. */
static inline uint32_t recorder_lines(uint32_t words)
{
    return ((words + RECORDER_LINE_WORDS) - 1U) / RECORDER_LINE_WORDS;
}

/* Writes a line with its words: RECORDER_LINE_CHARACTERS and a terminating 0. */
void recorder_line(uint32_t number, const uint32_t words[RECORDER_LINE_WORDS],
                   char line[RECORDER_LINE_CHARACTERS + 1U]);

/* Returns the total number of lines. */
uint32_t recorder_dump_lines(const recorder_dump_t *dump);

/*
 * Writes the next line: RECORDER_LINE_CHARACTERS and a terminating 0. Returns false, and writes
 * nothing, when there is no line left. About 20000 instructions.
 */
bool recorder_dump_line(recorder_dump_t *dump, char line[RECORDER_LINE_CHARACTERS + 1U]);

#endif
