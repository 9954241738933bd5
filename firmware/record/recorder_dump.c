/* SPDX-License-Identifier: MIT */
#include "recorder_dump.h"

#include "crc32.h"
#include "drive_words.h"
#include "words.h"

#include <stddef.h>

#define CONFIG_WORDS ((uint32_t)(sizeof(drive_cfg_t) / WORDS_BYTES))
#define ENTRY_WORDS ((uint32_t)(sizeof(recorder_entry_t) / WORDS_BYTES))
/* the words with the number of the line and its CRC */
#define LINE_BYTES ((RECORDER_LINE_WORDS + 2U) * WORDS_BYTES)

_Static_assert((LINE_BYTES % 3U) == 0U, "a line of base64 without padding");
_Static_assert((sizeof(drive_cfg_t) % WORDS_BYTES) == 0U, "a configuration of words");

void recorder_about_name(recorder_about_t *about, const char *name)
{
    uint32_t k = 0U;

    while ((k < (RECORDER_NAME_WORDS * WORDS_BYTES)) && (name[k] != '\0')) {
        const uint32_t character = (uint8_t)name[k];

        about->name[k / WORDS_BYTES] |= character << (8U * (k % WORDS_BYTES));
        k++;
    }
}

/*
 * Fills in the words of the header that describe the end of the recording. Of a recording that a
 * reset has cut only the tick is known.
 */
static void describe_end(recorder_header_t *header, const drive_t *end)
{
    const bool known = header->about.cut == 0U;
    const bool failed = known && (end->state == DRIVE_STATE_FAULT);

    header->end_tick = end->tick;
    header->end_hash = known ? drive_words_hash(end) : 0U;
    header->fault_id = failed ? (uint32_t)end->fault.id : (uint32_t)FAULT_NONE;
    header->fault_value = failed ? (uint32_t)end->fault.value : 0U;
    header->fault_limit = failed ? (uint32_t)end->fault.limit : 0U;
    header->fault_tick = failed ? end->fault.tick : 0U;
}

void recorder_dump_resize(recorder_dump_t *dump, uint32_t entry_words)
{
    recorder_header_t *const header = &dump->header;

    header->words = RECORDER_HEADER_WORDS + (CONFIG_WORDS * (1U + header->further)) +
                    header->state_words + entry_words + 1U;
}

void recorder_dump_start(recorder_dump_t *dump, const recorder_t *recorder,
                         const recorder_about_t *about)
{
    recorder_header_t *const header = &dump->header;

    dump->recorder = recorder;
    dump->history = recorder_history(recorder);
    dump->cfg = recorder_begin_state(recorder, &dump->history)->cfg;
    dump->further = recorder_further_config(recorder, &dump->history);
    dump->next = 0U;
    dump->line = 0U;
    dump->crc = CRC32_START;
    header->magic = RECORDER_MAGIC;
    header->version = RECORDER_VERSION;
    header->config_words = CONFIG_WORDS;
    header->state_words = drive_words_count();
    header->entries = dump->history.entries;
    header->further = (dump->further == NULL) ? 0U : 1U;
    header->packed = 0U;
    recorder_dump_resize(dump, header->entries * ENTRY_WORDS);
    header->first_tick = recorder_begin_state(recorder, &dump->history)->tick;
    header->about = *about;
    describe_end(header, recorder_end_state(recorder));
}

uint32_t recorder_dump_lines(const recorder_dump_t *dump)
{
    return recorder_lines(dump->header.words);
}

/* Returns word `at` of the entries. */
static uint32_t entry_word(const recorder_dump_t *dump, uint32_t at)
{
    const recorder_entry_t *const entry =
        recorder_entry(dump->recorder, &dump->history, at / ENTRY_WORDS);

    return entry->word[at % ENTRY_WORDS];
}

/* Returns word `at` of the object that begins at `first`. */
static uint32_t word_at(const uint8_t *first, uint32_t at)
{
    const uint32_t offset = at * WORDS_BYTES;

    return words_get(&first[offset]);
}

uint32_t recorder_dump_first(const recorder_dump_t *dump)
{
    return RECORDER_HEADER_WORDS + CONFIG_WORDS + dump->header.state_words;
}

uint32_t recorder_dump_head(const recorder_dump_t *dump, uint32_t at)
{
    const uint32_t config = RECORDER_HEADER_WORDS;
    const uint32_t state = config + CONFIG_WORDS;
    uint32_t word;

    if (at < config) {
        word = word_at((const uint8_t *)&dump->header, at);
    } else if (at < state) {
        word = word_at((const uint8_t *)dump->cfg, at - config);
    } else {
        word = drive_words_get(recorder_begin_state(dump->recorder, &dump->history), at - state);
    }
    return word;
}

uint32_t recorder_dump_further(const recorder_dump_t *dump, uint32_t at)
{
    return word_at((const uint8_t *)dump->further, at);
}

/* Returns word `at` of the file; not for the last word, which is the CRC. */
static uint32_t word_of(const recorder_dump_t *dump, uint32_t at)
{
    const uint32_t entries = recorder_dump_first(dump);
    const uint32_t further = entries + (dump->header.entries * ENTRY_WORDS);
    uint32_t word;

    if (at < entries) {
        word = recorder_dump_head(dump, at);
    } else if (at < further) {
        word = entry_word(dump, at - entries);
    } else {
        word = recorder_dump_further(dump, at - further);
    }
    return word;
}

/* Returns the next word of the file, or zero after the end of the file. */
static uint32_t next_file_word(recorder_dump_t *dump)
{
    const uint32_t last = dump->header.words - 1U;
    uint32_t word = 0U;

    if (dump->next < last) {
        uint8_t bytes[WORDS_BYTES];

        word = word_of(dump, dump->next);
        words_put(bytes, word);
        dump->crc = crc32_step(dump->crc, bytes);
    } else if (dump->next == last) {
        word = ~dump->crc;
    } else {
        /* the rest of the last line */
    }
    dump->next++;
    return word;
}

/* Writes LINE_BYTES bytes as base64 (RFC 4648). */
static void encode(const uint8_t *bytes, char *to)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *at = to;

    for (uint32_t k = 0U; k < LINE_BYTES; k += 3U) {
        const uint32_t group =
            ((uint32_t)bytes[k] << 16U) | ((uint32_t)bytes[k + 1U] << 8U) | bytes[k + 2U];

        for (uint32_t digit = 0U; digit < 4U; digit++) {
            *at = digits[(group >> (18U - (6U * digit))) & 0x3FU];
            at = &at[1];
        }
    }
    *at = '\0';
}

void recorder_line(uint32_t number, const uint32_t words[RECORDER_LINE_WORDS],
                   char line[RECORDER_LINE_CHARACTERS + 1U])
{
    uint8_t bytes[LINE_BYTES];
    uint32_t crc = CRC32_START;
    uint32_t at = WORDS_BYTES;

    words_put(bytes, number);
    crc = crc32_step(crc, bytes);
    for (uint32_t k = 0U; k < RECORDER_LINE_WORDS; k++) {
        words_put(&bytes[at], words[k]);
        crc = crc32_step(crc, &bytes[at]);
        at += WORDS_BYTES;
    }
    words_put(&bytes[at], ~crc);
    line[0] = RECORDER_LINE_MARK;
    encode(bytes, &line[1]);
}

bool recorder_dump_line(recorder_dump_t *dump, char line[RECORDER_LINE_CHARACTERS + 1U])
{
    const bool is_left = dump->next < dump->header.words;

    if (is_left) {
        uint32_t words[RECORDER_LINE_WORDS];

        for (uint32_t k = 0U; k < RECORDER_LINE_WORDS; k++) {
            words[k] = next_file_word(dump);
        }
        recorder_line(dump->line, words, line);
        dump->line++;
    }
    return is_left;
}
