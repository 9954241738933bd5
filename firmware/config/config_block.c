/* SPDX-License-Identifier: MIT */
#include "config_block.h"

#include "config_check.h"
#include "config_guard.h"
#include "crc32.h"
#include "words.h"

#include <stddef.h>

#define POLE_PAIRS_MAX (50U)
#define SPEED_MAX_RPM (200000)

/* There is no padding, so the words of a config_block_t in memory are the words of the block. */
#define BYTES_BEFORE_NAME (32U) /* eight words */
_Static_assert(offsetof(config_block_t, about.name) == BYTES_BEFORE_NAME,
               "padding before the name");
_Static_assert(offsetof(config_block_t, cfg) == (BYTES_BEFORE_NAME + CONFIG_BLOCK_NAME_BYTES),
               "padding before the configuration");
_Static_assert(sizeof(config_block_t) ==
                   (offsetof(config_block_t, cfg) + sizeof(drive_cfg_t) + WORDS_BYTES),
               "padding behind the configuration");

/* Returns the offset of word `at` in bytes. */
static uint32_t block_offset(uint32_t at)
{
    return at * WORDS_BYTES;
}

void config_block_name(char to[CONFIG_BLOCK_NAME_BYTES], const char *from)
{
    uint32_t k = 0U;

    while ((k < (CONFIG_BLOCK_NAME_BYTES - 1U)) && (from[k] != '\0')) {
        to[k] = from[k];
        k++;
    }
    while (k < CONFIG_BLOCK_NAME_BYTES) {
        to[k] = '\0';
        k++;
    }
}

uint32_t config_block_word(const config_block_t *block, uint32_t at)
{
    const uint8_t *const bytes = (const uint8_t *)block;
    uint32_t word = 0U;

    if (at < CONFIG_BLOCK_WORDS) {
        word = words_get(&bytes[block_offset(at)]);
    }
    return word;
}

void config_block_set_word(config_block_t *block, uint32_t at, uint32_t word)
{
    uint8_t *const bytes = (uint8_t *)block;

    if (at < CONFIG_BLOCK_WORDS) {
        words_put(&bytes[block_offset(at)], word);
    }
}

/* Returns the CRC of all words but the last. */
static uint32_t block_crc(const config_block_t *block)
{
    const uint8_t *const bytes = (const uint8_t *)block;
    uint32_t crc = CRC32_START;

    for (uint32_t at = 0U; at < offsetof(config_block_t, crc); at += WORDS_BYTES) {
        crc = crc32_step(crc, &bytes[at]);
    }
    return ~crc;
}

void config_block_make(config_block_t *block, const config_identity_t *identity,
                       const config_about_t *about, const drive_cfg_t *cfg)
{
    block->magic = CONFIG_BLOCK_MAGIC;
    block->version = CONFIG_BLOCK_VERSION;
    block->words = CONFIG_BLOCK_WORDS;
    block->identity = *identity;
    block->about.pole_pairs = about->pole_pairs;
    block->about.speed_max_rpm = about->speed_max_rpm;
    block->about.is_example = about->is_example;
    config_block_name(block->about.name, about->name);
    block->cfg = *cfg;
    block->crc = block_crc(block);
}

void config_block_encode(const config_block_t *block, uint8_t *bytes)
{
    for (uint32_t at = 0U; at < CONFIG_BLOCK_WORDS; at++) {
        words_put(&bytes[block_offset(at)], config_block_word(block, at));
    }
}

void config_block_decode(config_block_t *block, const uint8_t *bytes)
{
    for (uint32_t at = 0U; at < CONFIG_BLOCK_WORDS; at++) {
        config_block_set_word(block, at, words_get(&bytes[block_offset(at)]));
    }
}

/*
 * Returns a verdict with `fault` if `before` is good and these two numbers differ; otherwise
 * returns `before`.
 */
static config_block_verdict_t compare(config_block_verdict_t before, config_block_fault_t fault,
                                      uint32_t found, uint32_t expected)
{
    config_block_verdict_t verdict = before;

    if ((before.fault == CONFIG_BLOCK_GOOD) && (found != expected)) {
        verdict = (config_block_verdict_t){.fault = fault, .found = found, .expected = expected};
    }
    return verdict;
}

/* Returns the path of the first setting that is wrong, or NULL. */
static const char *bad_setting(const config_block_t *block)
{
    const config_about_t *const about = &block->about;
    const char *bad = config_check(&block->cfg);

    if ((about->pole_pairs < 1U) || (about->pole_pairs > POLE_PAIRS_MAX)) {
        bad = "about.pole_pairs";
    } else if ((about->speed_max_rpm < 1) || (about->speed_max_rpm > SPEED_MAX_RPM)) {
        bad = "about.speed_max_rpm";
    } else if (about->is_example > 1U) {
        bad = "about.is_example";
    } else if (about->name[CONFIG_BLOCK_NAME_BYTES - 1U] != '\0') {
        bad = "about.name";
    } else if ((bad == NULL) && (config_guard_crc(&block->cfg) != block->cfg.crc)) {
        bad = "crc";
    } else {
        /* `bad` is the result of config_check() */
    }
    return bad;
}

config_block_verdict_t config_block_check(const config_block_t *block,
                                          const config_identity_t *expected)
{
    config_block_verdict_t verdict = {.fault = CONFIG_BLOCK_GOOD};

    verdict = compare(verdict, CONFIG_BLOCK_NO_BLOCK, block->magic, CONFIG_BLOCK_MAGIC);
    verdict = compare(verdict, CONFIG_BLOCK_OTHER_VERSION, block->version, CONFIG_BLOCK_VERSION);
    verdict = compare(verdict, CONFIG_BLOCK_OTHER_LENGTH, block->words, CONFIG_BLOCK_WORDS);
    verdict = compare(verdict, CONFIG_BLOCK_BROKEN, block->crc, block_crc(block));
    verdict = compare(verdict, CONFIG_BLOCK_OTHER_SCHEMA, block->identity.schema, expected->schema);
    verdict = compare(verdict, CONFIG_BLOCK_OTHER_BOARD, block->identity.board, expected->board);
    if (verdict.fault == CONFIG_BLOCK_GOOD) {
        verdict.setting = bad_setting(block);
        verdict.fault = (verdict.setting == NULL) ? CONFIG_BLOCK_GOOD : CONFIG_BLOCK_BAD_SETTING;
    }
    return verdict;
}
