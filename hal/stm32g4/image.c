/* SPDX-License-Identifier: MIT */
#include "image.h"

#include "reg.h"
#include "stm32g4.h"

#include <stdint.h>

#define WORDS_A_STEP (2U)
#define WORD_BYTES (4U)

/* The seal. stm32g4.ld puts it after the image. */
typedef struct {
    uint32_t words; /* number of words of the image, including this one */
    uint32_t crc;   /* CRC-32 of these words */
} image_seal_t;

extern const image_seal_t image_seal;

static uint32_t next_word;

/*
 * Begins a new round. Sets the CRC unit up for zlib's crc32: lowest bit first, begun with all ones,
 * complemented at the end.
 */
static void begin_round(void)
{
    reg_write(CRC_CR, CRC_CR_RESET | CRC_CR_REV_IN_WORD | CRC_CR_REV_OUT);
    next_word = 0U;
}

/*
 * The seal is read as volatile, because the build writes it after this file has been compiled.
 */
static uint32_t words(void)
{
    const volatile image_seal_t *const seal = &image_seal;

    return seal->words;
}

static bool is_right(void)
{
    const volatile image_seal_t *const seal = &image_seal;

    return ~reg_read(CRC_DR) == seal->crc;
}

static void feed(uint32_t count)
{
    const uint32_t first = FLASH_IMAGE + (next_word * WORD_BYTES);

    for (uint32_t at = first; at < (first + (count * WORD_BYTES)); at += WORD_BYTES) {
        reg_write(CRC_DR, reg_read(at));
    }
    next_word += count;
}

bool image_is_whole(void)
{
    bool is_whole;

    begin_round();
    feed(words());
    is_whole = is_right();
    begin_round();
    return is_whole;
}

bool image_step(void)
{
    const uint32_t left = words() - next_word;
    bool is_whole = true;

    feed((left < WORDS_A_STEP) ? left : WORDS_A_STEP);
    if (left <= WORDS_A_STEP) {
        is_whole = is_right();
        begin_round();
    }
    return is_whole;
}
