/* SPDX-License-Identifier: MIT */
/*
 * Which configuration a start takes and what it says of it; when a block is stored, and when that
 * is refused.
 */
#include "crc32.h"
#include "example_app.h"
#include "flash_model.h"
#include "stored_config.h"
#include "testing.h"
#include "transitions.h"

#include <string.h>

#define STORED_NAME "neurofoc: another motor, a board, a tuning"

static const config_identity_t IDENTITY = {.schema = 3U, .board = 4U};
static about_t about;
static drive_cfg_t image_cfg;
static stored_config_t stored;
static config_block_t block;

static void make_block(void)
{
    config_about_t facts = {.pole_pairs = 7U, .speed_max_rpm = 1500, .name = STORED_NAME};
    drive_cfg_t other = example_drive_cfg();

    other.speed_loop.speed_max--;
    other.crc = config_guard_crc(&other);
    config_block_make(&block, &IDENTITY, &facts, &other);
}

static void load(void)
{
    about = ABOUT;
    about.identity = IDENTITY;
    about.is_example = 1U;
    memset(&stored, 0xA5, sizeof stored);
    stored_config_load(&stored, &hardware, &image_cfg, &about);
}

void setUp(void)
{
    flash_new(0U);
    image_cfg = example_drive_cfg();
    power_on();
    calibrate();
    make_block();
    load();
}

/* Whatever block, as another image would store it. */
static void store_unchecked(void)
{
    TEST_ASSERT_NULL(store_write(&stored.store, &block));
    load();
}

static void assert_tells(const char *expected)
{
    text_t text = {0};

    stored_config_tell(&text, &stored);
    text_end_line(&text);
    text.characters[text.length - 2U] = '\0';
    TEST_ASSERT_EQUAL_STRING(expected, text.characters);
}

static void assert_image_is_taken(const char *told)
{
    TEST_ASSERT_FALSE(stored.is_stored);
    TEST_ASSERT_EQUAL_MEMORY(&image_cfg, &stored.block.cfg, sizeof image_cfg);
    TEST_ASSERT_EQUAL_STRING(ABOUT.name, about.name);
    TEST_ASSERT_EQUAL_UINT32(ABOUT.rotation.pole_pairs, about.rotation.pole_pairs);
    TEST_ASSERT_EQUAL_INT32(ABOUT.speed_max_rpm, about.speed_max_rpm);
    TEST_ASSERT_EQUAL_UINT32(1U, about.is_example);
    TEST_ASSERT_EQUAL(CONFIG_BLOCK_GOOD, config_block_check(&stored.block, &IDENTITY).fault);
    assert_tells(told);
}

TEST(test_without_a_stored_block_the_image_has_the_configuration)
{
    assert_image_is_taken("configuration: that of the image, none is stored");
}

TEST(test_a_good_block_is_taken_with_its_name_and_the_facts_of_its_motor)
{
    store_unchecked();
    TEST_ASSERT_TRUE(stored.is_stored);
    TEST_ASSERT_EQUAL_MEMORY(&block, &stored.block, sizeof block);
    TEST_ASSERT_EQUAL_STRING(STORED_NAME, about.name);
    TEST_ASSERT_EQUAL_UINT32(7U, about.rotation.pole_pairs);
    TEST_ASSERT_EQUAL_INT32(1500, about.speed_max_rpm);
    TEST_ASSERT_EQUAL_UINT32(0U, about.is_example);
    assert_tells("configuration: the stored one");
}

TEST(test_facts_of_the_board_stay_those_of_the_image)
{
    store_unchecked();
    TEST_ASSERT_EQUAL_UINT32(ABOUT.rotation.tick_ps, about.rotation.tick_ps);
    TEST_ASSERT_EQUAL_UINT32(ABOUT.current_full_scale_ua, about.current_full_scale_ua);
    TEST_ASSERT_EQUAL_UINT32(ABOUT.bus_full_scale_uv, about.bus_full_scale_uv);
}

/* As it is stored, with a CRC that is right. */
static void seal(void)
{
    const config_block_t whole = block;

    config_block_make(&block, &whole.identity, &whole.about, &whole.cfg);
    block.version = whole.version;
    block.words = whole.words;
    if ((block.version != CONFIG_BLOCK_VERSION) || (block.words != CONFIG_BLOCK_WORDS)) {
        uint32_t crc = CRC32_START;
        for (uint32_t at = 0U; at < (block.words - 1U); at++) {
            crc = crc32_step(crc, (const uint8_t *)&block + (4U * at));
        }
        config_block_set_word(&block, block.words - 1U, ~crc);
        block.crc = ~crc;
    }
}

TEST(test_a_block_of_another_schema_is_not_taken)
{
    block.identity.schema = 5U;
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: the block was made for another firmware");
}

TEST(test_a_block_of_another_layout_is_not_taken)
{
    block.version++;
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: the block was made for another firmware");
}

TEST(test_a_block_of_another_length_is_not_taken)
{
    block.words--;
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: the block was made for another firmware");
}

TEST(test_a_block_of_another_board_is_not_taken)
{
    block.identity.board = 5U;
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: the block was made for another board");
}

TEST(test_a_block_with_a_bad_setting_is_not_taken_and_the_setting_is_named)
{
    block.cfg.slow_ticks = 5U;
    block.cfg.crc = config_guard_crc(&block.cfg);
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: the block has a setting that the drive "
        "does not take: slow_ticks");
}

/* An older image of the board may have had another limit. */
TEST(test_a_block_that_protects_less_than_the_image_is_not_taken)
{
    block.cfg.protection.bus_max = image_cfg.protection.bus_max + 1;
    block.cfg.crc = config_guard_crc(&block.cfg);
    seal();
    store_unchecked();
    assert_image_is_taken(
        "configuration: that of the image, not the stored one: protects less than the files that "
        "this image was made from; a new image sets another limit: protection.bus_max");
}

TEST(test_a_block_that_cannot_be_read_any_more_is_not_taken)
{
    store_unchecked();
    flash.units[0][3].half_done = true;
    flash.units[0][3].half = HAL_HOST_FLASH_UNREADABLE;
    load();
    assert_image_is_taken("configuration: that of the image, none is stored");
}

static void assert_save(const char *expected)
{
    const char *const why = stored_config_save(&stored, &app, &IDENTITY, &block);

    if (expected == NULL) {
        TEST_ASSERT_NULL(why);
    } else {
        TEST_ASSERT_EQUAL_STRING(expected, why);
    }
}

TEST(test_a_good_block_is_stored_while_the_drive_is_ready_and_the_next_start_takes_it)
{
    assert_save(NULL);
    TEST_ASSERT_FALSE(stored.is_stored);
    TEST_ASSERT_EQUAL_MEMORY(&image_cfg, &stored.block.cfg, sizeof image_cfg);
    load();
    TEST_ASSERT_TRUE(stored.is_stored);
    TEST_ASSERT_EQUAL_MEMORY(&block, &stored.block, sizeof block);
}

TEST(test_a_block_is_stored_behind_a_fault)
{
    fail();
    assert_save(NULL);
}

#define RUNS "the drive does not rest with open gates; stop it first"

TEST(test_no_block_is_stored_while_a_run_is_asked_for)
{
    drive_command_t command = command_mailbox_take(&app.mailbox);

    command.request = DRIVE_REQUEST_RUN;
    command_mailbox_post(&app.mailbox, &command);
    assert_save(RUNS);
    tick_period();
    assert_save(RUNS);
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
}

TEST(test_no_block_is_stored_in_any_state_but_ready_and_fault)
{
    for (uint32_t number = 0U; number < DRIVE_STATES; number++) {
        const drive_state_t state = transitions_state(number);

        const bool rests = (state == DRIVE_STATE_READY) || (state == DRIVE_STATE_FAULT);

        app.drive.state = state;
        assert_save(rests ? NULL : RUNS);
    }
}

TEST(test_no_block_is_stored_while_the_gates_are_on)
{
    app.out.gate_enable = true;
    assert_save(RUNS);
}

TEST(test_no_block_is_stored_that_this_image_would_not_take)
{
    block.identity.board++;
    seal();
    assert_save("the block was made for another board");
    make_block();
    block.crc++;
    assert_save("the block is damaged");
    make_block();
    block.magic++;
    assert_save("the block is damaged");
    TEST_ASSERT_EQUAL_UINT32(0U, flash.steps);
}

TEST(test_a_flash_that_does_not_work_is_told)
{
    flash.refuses_erase = true;
    assert_save("the flash cannot be erased");
}
