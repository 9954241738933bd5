/* SPDX-License-Identifier: MIT */
#include "recorder_pack.h"

#include "crc32.h"
#include "drive_words.h"
#include "frame_code.h"
#include "words.h"

#include <stddef.h>

#define HEAD_WORDS (2U) /* of a piece, before its code */
#define HALF_MASK (0xFFFFU)
#define LENGTH_SHIFT (8U)

_Static_assert((RECORDER_PACK_BYTES % WORDS_BYTES) == 0U, "a piece has whole words");

static uint32_t crc_of_outputs(const recorder_entry_t *entries, uint32_t count)
{
    uint32_t crc = CRC32_START;

    for (uint32_t k = 0U; k < count; k++) {
        if (!recorder_entry_is_change(&entries[k])) {
            const uint32_t *const word = entries[k].word;

            crc = crc32_word(crc32_word(crc, word[2]), word[3] & HALF_MASK);
        }
    }
    return ~crc;
}

/* Makes a piece of at most `count` entries of a segment. Returns the number of entries in it. */
static uint32_t make_piece(recorder_pack_t *pack, const recorder_entry_t *entries, uint32_t count)
{
    uint8_t bytes[RECORDER_PACK_BYTES];
    const uint32_t most = (count < FRAME_CODE_ENTRIES_MAX) ? count : FRAME_CODE_ENTRIES_MAX;
    uint32_t length = 0U;
    const uint32_t put = frame_code_encode(entries, most, bytes, RECORDER_PACK_BYTES, &length);
    const uint32_t words = (length + WORDS_BYTES - 1U) / WORDS_BYTES;

    for (uint32_t k = length; k < (words * WORDS_BYTES); k++) {
        bytes[k] = 0U;
    }
    pack->piece[0] = put | (length << LENGTH_SHIFT);
    pack->piece[1] = crc_of_outputs(entries, put);
    for (uint32_t k = 0U; k < words; k++) {
        const uint32_t offset = k * WORDS_BYTES;

        pack->piece[HEAD_WORDS + k] = words_get(&bytes[offset]);
    }
    pack->in_piece = HEAD_WORDS + words;
    pack->at = 0U;
    return put;
}

/* Returns the number of the history's segments. */
static uint32_t segments_of(const recorder_history_t *history)
{
    uint32_t count = 0U;
    uint32_t entries = 0U;

    while (entries < history->entries) {
        entries += history->of_segment[count];
        count++;
    }
    return count;
}

/* Leaves the older segments out of the file. */
static void begin_with(recorder_pack_t *pack, uint32_t segment)
{
    recorder_dump_t *const dump = &pack->dump;
    recorder_history_t *const history = &dump->history;
    const uint32_t count = segments_of(history);

    history->first = (history->first + segment) % RECORDER_SEGMENTS;
    history->entries = 0U;
    for (uint32_t k = segment; k < count; k++) {
        history->of_segment[k - segment] = history->of_segment[k];
        history->entries += history->of_segment[k];
    }
    dump->header.entries = history->entries;
    dump->header.packed = pack->taken;
    if (history->entries > 0U) {
        const drive_t *const state = recorder_begin_state(dump->recorder, history);

        dump->cfg = state->cfg;
        dump->header.first_tick = state->tick;
    }
    recorder_dump_resize(dump, pack->taken);
    pack->entry = 0U;
    pack->in_piece = 0U;
    pack->at = 0U;
}

void recorder_pack_start(recorder_pack_t *pack, const recorder_t *recorder,
                         const recorder_about_t *about, uint32_t room)
{
    uint32_t head;

    recorder_dump_start(&pack->dump, recorder, about);
    recorder_dump_resize(&pack->dump, 0U);
    head = pack->dump.header.words;
    pack->room = (room > head) ? (room - head) : 0U;
    pack->segment = segments_of(&pack->dump.history);
    pack->taken = 0U;
    pack->words = 0U;
    pack->entry = 0U;
}

static const recorder_entry_t *entry_of(const recorder_pack_t *pack, uint32_t segment, uint32_t at)
{
    const recorder_history_t *const history = &pack->dump.history;
    uint32_t before = 0U;

    for (uint32_t k = 0U; k < segment; k++) {
        before += history->of_segment[k];
    }
    return recorder_entry(pack->dump.recorder, history, before + at);
}

bool recorder_pack_measure(recorder_pack_t *pack)
{
    const recorder_history_t *const history = &pack->dump.history;
    bool goes_on = pack->segment > 0U;

    if (goes_on) {
        const uint32_t segment = pack->segment - 1U;
        const uint32_t left = history->of_segment[segment] - pack->entry;

        pack->entry += make_piece(pack, entry_of(pack, segment, pack->entry), left);
        pack->words += pack->in_piece;
        goes_on = pack->words <= pack->room;
        if (goes_on && (pack->entry >= history->of_segment[segment])) {
            pack->taken = pack->words;
            pack->segment = segment;
            pack->entry = 0U;
        }
    }
    if (!goes_on) {
        begin_with(pack, pack->segment);
    }
    return goes_on;
}

/* Makes the next piece. A piece does not go beyond its segment. */
static void next_piece(recorder_pack_t *pack)
{
    const recorder_history_t *const history = &pack->dump.history;
    uint32_t end = history->of_segment[0];
    uint32_t segment = 0U;

    while (pack->entry >= end) {
        segment++;
        end += history->of_segment[segment];
    }
    pack->entry += make_piece(pack, recorder_entry(pack->dump.recorder, history, pack->entry),
                              end - pack->entry);
}

static uint32_t next_packed(recorder_pack_t *pack)
{
    uint32_t word;

    if (pack->at >= pack->in_piece) {
        next_piece(pack);
    }
    word = pack->piece[pack->at];
    pack->at++;
    return word;
}

uint32_t recorder_pack_next(recorder_pack_t *pack)
{
    recorder_dump_t *const dump = &pack->dump;
    const uint32_t at = dump->next;
    const uint32_t first = recorder_dump_first(dump);
    uint32_t word;

    if (at < first) {
        word = recorder_dump_head(dump, at);
    } else if (at < (first + dump->header.packed)) {
        word = next_packed(pack);
    } else if (at < (dump->header.words - 1U)) {
        word = recorder_dump_further(dump, at - first - dump->header.packed);
    } else {
        word = ~dump->crc;
    }
    dump->crc = crc32_word(dump->crc, word);
    dump->next++;
    return word;
}
