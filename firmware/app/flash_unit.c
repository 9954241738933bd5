/* SPDX-License-Identifier: MIT */
#include "flash_unit.h"

#include "crc32.h"
#include "words.h"

#define ERASED_WORD (0xFFFFFFFFU)

_Static_assert((FLASH_UNIT_WORDS * WORDS_BYTES) == HAL_STORE_UNIT_BYTES, "a unit has two words");

bool flash_unit_read(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t words[FLASH_UNIT_WORDS])
{
    uint8_t bytes[HAL_STORE_UNIT_BYTES] = {0U, 0U, 0U, 0U, 0U, 0U, 0U, 0U};
    const bool good = hal_store_read(hal, slot, unit, bytes);

    words[0] = words_get(bytes);
    words[1] = words_get(&bytes[WORDS_BYTES]);
    return good;
}

static bool reads_back(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t first, uint32_t second)
{
    uint32_t words[FLASH_UNIT_WORDS];
    const bool good = flash_unit_read(hal, slot, unit, words);

    return good && (words[0] == first) && (words[1] == second);
}

bool flash_unit_program(hal_t *hal, uint32_t slot, uint32_t unit, uint32_t first, uint32_t second)
{
    uint8_t bytes[HAL_STORE_UNIT_BYTES];

    words_put(bytes, first);
    words_put(&bytes[WORDS_BYTES], second);
    return hal_store_program(hal, slot, unit, bytes) && reads_back(hal, slot, unit, first, second);
}

static uint32_t stamp_crc(uint32_t sequence, uint32_t crc)
{
    return ~crc32_word(crc32_word(CRC32_START, sequence), crc);
}

bool flash_unit_find_stamp(hal_t *hal, const flash_unit_stamps_t *stamps, uint32_t crc,
                           uint32_t *sequence)
{
    bool found = false;

    for (uint32_t unit = stamps->first; unit < stamps->end; unit++) {
        uint32_t words[FLASH_UNIT_WORDS];
        const bool good = flash_unit_read(hal, stamps->slot, unit, words);

        if (good && (words[1] == stamp_crc(words[0], crc))) {
            found = true;
            *sequence = words[0];
        }
    }
    return found;
}

bool flash_unit_put_stamps(hal_t *hal, const flash_unit_stamps_t *stamps, uint32_t count,
                           uint32_t sequence, uint32_t crc)
{
    uint32_t left = count;

    for (uint32_t unit = stamps->first; (unit < stamps->end) && (left > 0U); unit++) {
        if (reads_back(hal, stamps->slot, unit, ERASED_WORD, ERASED_WORD) &&
            flash_unit_program(hal, stamps->slot, unit, sequence, stamp_crc(sequence, crc))) {
            left--;
        }
    }
    return left == 0U;
}
