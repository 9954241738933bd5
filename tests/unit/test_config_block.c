/* SPDX-License-Identifier: MIT */
/* The configuration block: its bytes, and that each way to be wrong is found and told. */
#include "config_block.h"
#include "crc32.h"
#include "example_cfg.h"
#include "testing.h"
#include "words.h"

#include <stddef.h>
#include <string.h>

static const config_identity_t IDENTITY = {.schema = 0x5C4E3A21U, .board = 0xB0A4D001U};
static config_about_t about;
static drive_cfg_t cfg;
static config_block_t block;

void setUp(void)
{
    cfg = example_drive_cfg();
    about = (config_about_t){.pole_pairs = 2U,
                             .speed_max_rpm = 2000,
                             .is_example = 1U,
                             .name = "neurofoc: a motor, a board, a tuning"};
    memset(&block, 0xA5, sizeof block);
    config_block_make(&block, &IDENTITY, &about, &cfg);
}

static uint32_t crc_of(const uint8_t *bytes, uint32_t count)
{
    uint32_t crc = CRC32_START;

    for (uint32_t k = 0U; k < count; k += 4U) {
        crc = crc32_step(crc, &bytes[k]);
    }
    return ~crc;
}

/* After a change of a block, its CRC. */
static void seal(void)
{
    block.crc = crc_of((const uint8_t *)&block, CONFIG_BLOCK_BYTES - 4U);
}

TEST(test_bytes_are_where_the_layout_says)
{
    uint8_t bytes[CONFIG_BLOCK_BYTES];

    config_block_encode(&block, bytes);
    TEST_ASSERT_EQUAL_MEMORY("NFCB", bytes, 4);
    TEST_ASSERT_EQUAL_HEX32(CONFIG_BLOCK_VERSION, words_get(&bytes[4]));
    TEST_ASSERT_EQUAL_HEX32(sizeof bytes / 4U, words_get(&bytes[8]));
    TEST_ASSERT_EQUAL_HEX32(IDENTITY.schema, words_get(&bytes[12]));
    TEST_ASSERT_EQUAL_HEX32(IDENTITY.board, words_get(&bytes[16]));
    TEST_ASSERT_EQUAL_HEX32(2U, words_get(&bytes[20]));
    TEST_ASSERT_EQUAL_HEX32(2000U, words_get(&bytes[24]));
    TEST_ASSERT_EQUAL_HEX32(1U, words_get(&bytes[28]));
    TEST_ASSERT_EQUAL_STRING(about.name, (const char *)&bytes[32]);
    TEST_ASSERT_EQUAL_MEMORY(&cfg, &bytes[32U + CONFIG_BLOCK_NAME_BYTES], sizeof cfg);
    TEST_ASSERT_EQUAL_HEX32(crc_of(bytes, sizeof bytes - 4U), words_get(&bytes[sizeof bytes - 4U]));
}

TEST(test_what_was_encoded_is_decoded)
{
    uint8_t bytes[CONFIG_BLOCK_BYTES + 1U];
    config_block_t decoded;

    bytes[CONFIG_BLOCK_BYTES] = 0xEEU;
    config_block_encode(&block, bytes);
    TEST_ASSERT_EQUAL_HEX8(0xEEU, bytes[CONFIG_BLOCK_BYTES]);
    memset(&decoded, 0, sizeof decoded);
    config_block_decode(&decoded, bytes);
    TEST_ASSERT_EQUAL_MEMORY(&block, &decoded, sizeof block);
}

TEST(test_words_are_those_of_the_bytes)
{
    uint8_t bytes[CONFIG_BLOCK_BYTES];

    config_block_encode(&block, bytes);
    for (uint32_t at = 0U; at < CONFIG_BLOCK_WORDS; at++) {
        TEST_ASSERT_EQUAL_HEX32(words_get(&bytes[4U * at]), config_block_word(&block, at));
    }
}

TEST(test_beyond_the_last_word_there_is_zero_and_nothing_is_set)
{
    struct {
        config_block_t block;
        uint32_t behind;
    } two = {.block = block, .behind = 0x12345678U};

    TEST_ASSERT_EQUAL_HEX32(0U, config_block_word(&two.block, CONFIG_BLOCK_WORDS));
    TEST_ASSERT_EQUAL_HEX32(0U, config_block_word(&two.block, UINT32_MAX));
    config_block_set_word(&two.block, CONFIG_BLOCK_WORDS, 0U);
    TEST_ASSERT_EQUAL_HEX32(0x12345678U, two.behind);
    TEST_ASSERT_EQUAL_MEMORY(&block, &two.block, sizeof block);
}

TEST(test_a_name_that_is_too_long_is_cut_off_and_ends)
{
    char name[CONFIG_BLOCK_NAME_BYTES + 1U];
    char from[CONFIG_BLOCK_NAME_BYTES + 10U];

    memset(name, '!', sizeof name);
    memset(from, 'x', sizeof from);
    from[sizeof from - 1U] = '\0';
    config_block_name(name, from);
    TEST_ASSERT_EQUAL_UINT32(CONFIG_BLOCK_NAME_BYTES - 1U, strlen(name));
    TEST_ASSERT_EQUAL_CHAR('!', name[CONFIG_BLOCK_NAME_BYTES]);
}

TEST(test_behind_a_name_there_are_zeros_up_to_its_end)
{
    static const char zeros[CONFIG_BLOCK_NAME_BYTES];
    char name[CONFIG_BLOCK_NAME_BYTES];

    memset(name, '!', sizeof name);
    config_block_name(name, "abc");
    TEST_ASSERT_EQUAL_STRING("abc", name);
    TEST_ASSERT_EQUAL_MEMORY(zeros, &name[3], sizeof name - 3U);
}

static config_block_verdict_t check(void)
{
    return config_block_check(&block, &IDENTITY);
}

static void assert_fault(config_block_fault_t fault, uint32_t found, uint32_t expected)
{
    const config_block_verdict_t verdict = check();

    TEST_ASSERT_EQUAL(fault, verdict.fault);
    TEST_ASSERT_EQUAL_HEX32(found, verdict.found);
    TEST_ASSERT_EQUAL_HEX32(expected, verdict.expected);
    TEST_ASSERT_NULL(verdict.setting);
}

TEST(test_a_block_that_was_made_is_good)
{
    assert_fault(CONFIG_BLOCK_GOOD, 0U, 0U);
}

TEST(test_each_word_of_the_header_is_told_when_it_is_another_one)
{
    block.identity.board++;
    seal();
    assert_fault(CONFIG_BLOCK_OTHER_BOARD, IDENTITY.board + 1U, IDENTITY.board);
    block.identity.schema--;
    seal();
    assert_fault(CONFIG_BLOCK_OTHER_SCHEMA, IDENTITY.schema - 1U, IDENTITY.schema);
    block.crc ^= 0x80U;
    assert_fault(CONFIG_BLOCK_BROKEN, block.crc, block.crc ^ 0x80U);
    block.words = 7U;
    assert_fault(CONFIG_BLOCK_OTHER_LENGTH, 7U, CONFIG_BLOCK_WORDS);
    block.version = 9U;
    assert_fault(CONFIG_BLOCK_OTHER_VERSION, 9U, CONFIG_BLOCK_VERSION);
    block.magic = 0U;
    assert_fault(CONFIG_BLOCK_NO_BLOCK, 0U, CONFIG_BLOCK_MAGIC);
}

TEST(test_any_flipped_bit_is_found)
{
    for (uint32_t bit = 0U; bit < (8U * CONFIG_BLOCK_BYTES); bit++) {
        uint8_t *const byte = (uint8_t *)&block + (bit / 8U);
        const uint8_t mask = (uint8_t)(1U << (bit % 8U));

        *byte ^= mask;
        TEST_ASSERT_NOT_EQUAL(CONFIG_BLOCK_GOOD, check().fault);
        *byte ^= mask;
    }
}

static void assert_bad_setting(const char *path)
{
    config_block_verdict_t verdict;

    seal();
    verdict = check();
    TEST_ASSERT_EQUAL(CONFIG_BLOCK_BAD_SETTING, verdict.fault);
    TEST_ASSERT_EQUAL_STRING(path, verdict.setting);
    TEST_ASSERT_EQUAL_HEX32(0U, verdict.found);
    TEST_ASSERT_EQUAL_HEX32(0U, verdict.expected);
}

static void assert_good(void)
{
    seal();
    TEST_ASSERT_EQUAL(CONFIG_BLOCK_GOOD, check().fault);
}

TEST(test_pole_pairs_are_1_to_50)
{
    block.about.pole_pairs = 0U;
    assert_bad_setting("about.pole_pairs");
    block.about.pole_pairs = 51U;
    assert_bad_setting("about.pole_pairs");
    block.about.pole_pairs = 1U;
    assert_good();
    block.about.pole_pairs = 50U;
    assert_good();
}

TEST(test_the_highest_speed_is_1_to_200000_rpm)
{
    block.about.speed_max_rpm = 0;
    assert_bad_setting("about.speed_max_rpm");
    block.about.speed_max_rpm = INT32_MIN;
    assert_bad_setting("about.speed_max_rpm");
    block.about.speed_max_rpm = 200001;
    assert_bad_setting("about.speed_max_rpm");
    block.about.speed_max_rpm = 1;
    assert_good();
    block.about.speed_max_rpm = 200000;
    assert_good();
}

TEST(test_whether_the_motor_is_an_example_is_0_or_1)
{
    block.about.is_example = 2U;
    assert_bad_setting("about.is_example");
    block.about.is_example = 1U;
    assert_good();
}

TEST(test_a_name_without_an_end_is_refused)
{
    block.about.name[CONFIG_BLOCK_NAME_BYTES - 1U] = 'x';
    assert_bad_setting("about.name");
}

TEST(test_a_setting_out_of_its_range_is_named)
{
    block.cfg.slow_ticks = 5U;
    block.cfg.crc = config_guard_crc(&block.cfg);
    assert_bad_setting("slow_ticks");
}

TEST(test_the_crc_by_which_the_drive_guards_its_configuration_is_checked)
{
    block.cfg.crc++;
    assert_bad_setting("crc");
}
