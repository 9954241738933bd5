/* SPDX-License-Identifier: MIT */
#include "store.h"

#include "crc32.h"
#include "fx.h"
#include "words.h"

#include <stddef.h>

#define UNIT_WORDS (HAL_STORE_UNIT_BYTES / WORDS_BYTES)
#define BLOCK_WORDS_MAX (STORE_BLOCK_UNITS * UNIT_WORDS)
#define LENGTH_WORD (2U) /* index of config_block_t.words */
#define ERASED (0xFFU)

/* Numbers of stamps, see store.h. */
#define ONE_MORE (1U)       /* bit that is set in the numbers of later stamps */
#define BEYOND_A_WRITE (4U) /* added if a write may have reached step 4 */
#define STAMPS_TO_KEEP (2U) /* stamps that step 1 writes */

_Static_assert((CONFIG_BLOCK_WORDS <= BLOCK_WORDS_MAX),
               "a block does not fit into its part of a slot");
_Static_assert(UNIT_WORDS == 2U, "a stamp has two words");

/* Content of a slot. */
typedef struct {
    bool whole;
    uint32_t sequence;
} slot_content_t;

/* Place from which read_word() reads. bad: a unit could not be read. */
typedef struct {
    hal_t *hal;
    uint32_t slot;
    bool bad;
} reader_t;

static uint32_t read_word(reader_t *reader, uint32_t at)
{
    const uint32_t offset = (at % UNIT_WORDS) * WORDS_BYTES;
    uint8_t unit[HAL_STORE_UNIT_BYTES] = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};

    if (!hal_store_read(reader->hal, reader->slot, at / UNIT_WORDS, unit)) {
        reader->bad = true;
    }
    return words_get(&unit[offset]);
}

static uint32_t crc_of_word_too(uint32_t crc, uint32_t word)
{
    uint8_t bytes[WORDS_BYTES];

    words_put(bytes, word);
    return crc32_step(crc, bytes);
}

/*
 * Whether the CRC of the block in a slot is right; *crc is this CRC. The length is read from the
 * block, which may be of another firmware.
 */
static bool has_block(hal_t *hal, uint32_t slot, uint32_t *crc)
{
    reader_t reader = {.hal = hal, .slot = slot, .bad = false};
    const uint32_t magic = read_word(&reader, 0U);
    const uint32_t words = read_word(&reader, LENGTH_WORD);
    bool good =
        (magic == CONFIG_BLOCK_MAGIC) && (words > LENGTH_WORD) && (words <= BLOCK_WORDS_MAX);

    if (good) {
        uint32_t sum = CRC32_START;

        for (uint32_t at = 0U; at < (words - 1U); at++) {
            sum = crc_of_word_too(sum, read_word(&reader, at));
        }
        *crc = ~sum;
        good = read_word(&reader, words - 1U) == *crc;
    }
    return good && !reader.bad;
}

static uint32_t stamp_crc(uint32_t sequence, uint32_t block_crc)
{
    return ~crc_of_word_too(crc_of_word_too(CRC32_START, sequence), block_crc);
}

/* Finds the last good stamp of a block. A unit that cannot be read is not a stamp. */
static void find_stamp(hal_t *hal, uint32_t slot, uint32_t block_crc, slot_content_t *found)
{
    for (uint32_t unit = STORE_BLOCK_UNITS; unit < HAL_STORE_UNITS; unit++) {
        reader_t reader = {.hal = hal, .slot = slot, .bad = false};
        const uint32_t sequence = read_word(&reader, unit * UNIT_WORDS);
        const uint32_t crc = read_word(&reader, (unit * UNIT_WORDS) + 1U);

        if (!reader.bad && (crc == stamp_crc(sequence, block_crc))) {
            found->whole = true;
            found->sequence = sequence;
        }
    }
}

static slot_content_t look_at(hal_t *hal, uint32_t slot)
{
    slot_content_t found = {.whole = false, .sequence = 0U};
    uint32_t block_crc = 0U;

    if (has_block(hal, slot, &block_crc)) {
        find_stamp(hal, slot, block_crc, &found);
    }
    return found;
}

void store_find(store_t *store, hal_t *hal)
{
    *store = (store_t){.hal = hal, .found = false, .slot = 0U, .sequence = 0U};
    for (uint32_t slot = 0U; slot < HAL_STORE_SLOTS; slot++) {
        const slot_content_t found = look_at(hal, slot);
        const bool newer = fx_signed(found.sequence - store->sequence) > 0;

        if (found.whole && (newer || !store->found)) {
            store->found = true;
            store->slot = slot;
            store->sequence = found.sequence;
        }
    }
}

bool store_read(const store_t *store, config_block_t *block)
{
    reader_t reader = {.hal = store->hal, .slot = store->slot, .bad = !store->found};

    for (uint32_t at = 0U; (at < CONFIG_BLOCK_WORDS) && !reader.bad; at++) {
        config_block_set_word(block, at, read_word(&reader, at));
    }
    return !reader.bad;
}

static bool reads_back(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    uint8_t found[HAL_STORE_UNIT_BYTES] = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};
    bool same = hal_store_read(hal, slot, unit, found);

    for (uint32_t k = 0U; k < HAL_STORE_UNIT_BYTES; k++) {
        same = same && (found[k] == bytes[k]);
    }
    return same;
}

static bool program(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t first, uint32_t second)
{
    uint8_t bytes[HAL_STORE_UNIT_BYTES];

    words_put(bytes, first);
    words_put(&bytes[WORDS_BYTES], second);
    return hal_store_program(hal, slot, unit, bytes) && reads_back(hal, slot, unit, bytes);
}

static bool is_erased(hal_t *hal, uint32_t slot, uint32_t unit)
{
    static const uint8_t erased[HAL_STORE_UNIT_BYTES] = {ERASED, ERASED, ERASED, ERASED,
                                                         ERASED, ERASED, ERASED, ERASED};

    return reads_back(hal, slot, unit, erased);
}

/*
 * Programs `count` stamps into the first units that take them. Returns false if fewer units take a
 * stamp.
 */
static bool put_stamps(hal_t *hal, uint32_t slot, uint32_t count, uint32_t sequence,
                       uint32_t block_crc)
{
    uint32_t left = count;

    for (uint32_t unit = STORE_BLOCK_UNITS; (unit < HAL_STORE_UNITS) && (left > 0U); unit++) {
        if (is_erased(hal, slot, unit) &&
            program(hal, slot, unit, sequence, stamp_crc(sequence, block_crc))) {
            left--;
        }
    }
    return left == 0U;
}

/* Returns the slot that does not have the newest block. */
static uint32_t other_slot(const store_t *store)
{
    return store->found ? (HAL_STORE_SLOTS - 1U - store->slot) : 0U;
}

static uint32_t number_of_one_more(const store_t *store)
{
    const bool has_one = (store->sequence & ONE_MORE) != 0U;
    uint32_t number = store->sequence | ONE_MORE;

    if (has_one && !look_at(store->hal, other_slot(store)).whole) {
        number += BEYOND_A_WRITE;
    }
    return number;
}

/*
 * Step 1 of a write. The sequence number goes up even if only one stamp finds a unit, because the
 * new block's number has to be higher than the number of that stamp.
 */
static void keep(store_t *store)
{
    uint32_t block_crc = 0U;

    if (store->found && has_block(store->hal, store->slot, &block_crc)) {
        store->sequence = number_of_one_more(store);
        (void)put_stamps(store->hal, store->slot, STAMPS_TO_KEEP, store->sequence, block_crc);
    }
}

/* Step 3 of a write, in whole units. */
static bool program_block(hal_t *hal, uint32_t slot, const config_block_t *block)
{
    bool good = true;

    for (uint32_t at = 0U; (at < CONFIG_BLOCK_WORDS) && good; at += UNIT_WORDS) {
        good = program(hal, slot, at / UNIT_WORDS, config_block_word(block, at),
                       config_block_word(block, at + 1U));
    }
    return good;
}

const char *store_write(store_t *store, const config_block_t *block)
{
    const uint32_t slot = other_slot(store);
    const char *why = NULL;
    uint32_t sequence;

    keep(store);
    sequence = (store->sequence | ONE_MORE) + 1U;
    if (!hal_store_erase(store->hal, slot)) {
        why = "the flash cannot be erased";
    } else if (!program_block(store->hal, slot, block) ||
               !put_stamps(store->hal, slot, 1U, sequence, block->crc)) {
        why = "the flash does not keep what is written";
    } else {
        store->found = true;
        store->slot = slot;
        store->sequence = sequence;
    }
    return why;
}
