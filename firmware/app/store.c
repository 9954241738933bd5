/* SPDX-License-Identifier: MIT */
#include "store.h"

#include "crc32.h"
#include "flash_unit.h"
#include "fx.h"

#include <stddef.h>

#define UNIT_WORDS (FLASH_UNIT_WORDS)
#define BLOCK_WORDS_MAX (STORE_BLOCK_UNITS * UNIT_WORDS)
#define LENGTH_WORD (2U) /* index of config_block_t.words */

/* Numbers of stamps, see store.h. */
#define ONE_MORE (1U)       /* bit that is set in the numbers of later stamps */
#define BEYOND_A_WRITE (4U) /* added if a write may have reached step 4 */
#define STAMPS_TO_KEEP (2U) /* stamps that step 1 writes */

_Static_assert((CONFIG_BLOCK_WORDS <= BLOCK_WORDS_MAX),
               "a block does not fit into its part of a slot");

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
    uint32_t unit[UNIT_WORDS];

    if (!flash_unit_read(reader->hal, reader->slot, at / UNIT_WORDS, unit)) {
        reader->bad = true;
    }
    return unit[at % UNIT_WORDS];
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
            sum = crc32_word(sum, read_word(&reader, at));
        }
        *crc = ~sum;
        good = read_word(&reader, words - 1U) == *crc;
    }
    return good && !reader.bad;
}

static flash_unit_stamps_t stamps_of(uint32_t slot)
{
    return (flash_unit_stamps_t){.slot = slot, .first = STORE_BLOCK_UNITS, .end = HAL_STORE_UNITS};
}

static slot_content_t look_at(hal_t *hal, uint32_t slot)
{
    slot_content_t found = {.whole = false, .sequence = 0U};
    const flash_unit_stamps_t stamps = stamps_of(slot);
    uint32_t block_crc = 0U;

    if (has_block(hal, slot, &block_crc)) {
        found.whole = flash_unit_find_stamp(hal, &stamps, block_crc, &found.sequence);
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
    const flash_unit_stamps_t stamps = stamps_of(store->slot);
    uint32_t block_crc = 0U;

    if (store->found && has_block(store->hal, store->slot, &block_crc)) {
        store->sequence = number_of_one_more(store);
        (void)flash_unit_put_stamps(store->hal, &stamps, STAMPS_TO_KEEP, store->sequence,
                                    block_crc);
    }
}

/* Step 3 of a write, in whole units. */
static bool program_block(hal_t *hal, uint32_t slot, const config_block_t *block)
{
    bool good = true;

    for (uint32_t at = 0U; (at < CONFIG_BLOCK_WORDS) && good; at += UNIT_WORDS) {
        good = flash_unit_program(hal, slot, at / UNIT_WORDS, config_block_word(block, at),
                                  config_block_word(block, at + 1U));
    }
    return good;
}

const char *store_write(store_t *store, const config_block_t *block)
{
    const uint32_t slot = other_slot(store);
    const flash_unit_stamps_t stamps = stamps_of(slot);
    const char *why = NULL;
    uint32_t sequence;

    keep(store);
    sequence = (store->sequence | ONE_MORE) + 1U;
    if (!hal_store_erase(store->hal, slot)) {
        why = "the flash cannot be erased";
    } else if (!program_block(store->hal, slot, block) ||
               !flash_unit_put_stamps(store->hal, &stamps, 1U, sequence, block->crc)) {
        why = "the flash does not keep what is written";
    } else {
        store->found = true;
        store->slot = slot;
        store->sequence = sequence;
    }
    return why;
}
