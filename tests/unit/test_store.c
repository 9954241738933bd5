/* SPDX-License-Identifier: MIT */
/*
 * The store: whatever step power fails in, the next start finds the old block or the new one,
 * whole.
 */
#include "config_block.h"
#include "crc32.h"
#include "example_cfg.h"
#include "flash_model.h"
#include "store.h"
#include "testing.h"

#include <stdio.h>
#include <string.h>

#define STAMP_UNITS (HAL_STORE_UNITS - STORE_BLOCK_UNITS)
#define STORES 4U  /* of a sequence in which each step is cut */
#define CHANCES 4U /* ways in which a step is left half done */
#define BLOCK_UNITS ((CONFIG_BLOCK_WORDS + 1U) / 2U)
/* of a write: an erase, the units of the block, its stamp */
#define FIRST_STEPS (BLOCK_UNITS + 2U)
#define STEPS (FIRST_STEPS + 2U) /* with two stamps of the block that is kept */
#define NONE UINT32_MAX

struct hal {
    int unused;
};

static const config_identity_t identity = {.schema = 0x11111111U, .board = 0x22222222U};
static hal_t hal;
static store_t store;
static config_block_t found;

void setUp(void)
{
    flash_new(0U);
    store_find(&store, &hal);
}

/* Blocks are told apart by all that is in them. */
static config_block_t block_of(uint32_t number)
{
    config_about_t about = {.pole_pairs = 1U + (number % 50U), .speed_max_rpm = 1000};
    drive_cfg_t cfg = example_drive_cfg();
    config_block_t block;

    (void)snprintf(about.name, sizeof about.name, "block %u", (unsigned)number);
    cfg.speed_loop.speed_max -= (step_t)number;
    cfg.crc = config_guard_crc(&cfg);
    config_block_make(&block, &identity, &about, &cfg);
    return block;
}

/* NULL when it is stored. */
static const char *write(uint32_t number)
{
    const config_block_t block = block_of(number);

    return store_write(&store, &block);
}

/*
 * What a start finds: the number of the block, NONE without one. Anything else than a block that
 * was written is a failure.
 */
static uint32_t start(void)
{
    uint32_t number = NONE;

    flash.left = HAL_HOST_FLASH_NEVER;
    store_find(&store, &hal);
    if (store_read(&store, &found)) {
        number =
            (uint32_t)(example_drive_cfg().speed_loop.speed_max - found.cfg.speed_loop.speed_max);
        const config_block_t expected = block_of(number);
        TEST_ASSERT_EQUAL_MEMORY(&expected, &found, sizeof found);
    }
    return number;
}

static void assert_stores(uint32_t number)
{
    TEST_ASSERT_NULL(write(number));
    TEST_ASSERT_EQUAL_UINT32(number, start());
}

/* Writes, and loses power in this step of it. Whether the write was done before. */
static bool write_cut(uint32_t number, uint32_t step)
{
    volatile bool done = false;

    flash.left = step;
    if (setjmp(power_off) == 0) {
        TEST_ASSERT_NULL(write(number));
        done = true;
    }
    flash.left = HAL_HOST_FLASH_NEVER;
    return done;
}

static void make_unreadable(uint32_t slot, uint32_t unit)
{
    flash.units[slot][unit].half_done = true;
    flash.units[slot][unit].half = HAL_HOST_FLASH_UNREADABLE;
}

static void assert_nothing_kept(const char *said)
{
    TEST_ASSERT_EQUAL_STRING("the flash does not keep what is written", said);
    TEST_ASSERT_EQUAL_UINT32(1U, start());
}

/* Units that keep nothing. */
static void die(uint32_t first, uint32_t last)
{
    flash.dead = first;
    flash.dead_last = last;
}

TEST(test_an_empty_store_has_no_block)
{
    TEST_ASSERT_FALSE(store.found);
    TEST_ASSERT_FALSE(store_read(&store, &found));
}

TEST(test_what_was_written_is_found_by_the_next_start_and_the_slots_take_turns)
{
    for (uint32_t number = 0U; number < 5U; number++) {
        assert_stores(number);
        TEST_ASSERT_EQUAL_UINT32(number % 2U, store.slot);
    }
}

TEST(test_what_was_written_can_be_read_without_another_start)
{
    const config_block_t second = block_of(2U);

    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_NULL(write(2U));
    TEST_ASSERT_TRUE(store_read(&store, &found));
    TEST_ASSERT_EQUAL_MEMORY(&second, &found, sizeof found);
}

/* An erase, the units of the block, its stamp; before them two stamps of the block that is kept. */
TEST(test_a_write_takes_a_step_for_each_unit)
{
    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_EQUAL_UINT32(FIRST_STEPS, flash.steps);
    TEST_ASSERT_NULL(write(2U));
    TEST_ASSERT_EQUAL_UINT32(FIRST_STEPS + STEPS, flash.steps);
}

TEST(test_numbers_of_stamps_are_even_for_a_block_and_odd_for_one_more)
{
    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_EQUAL_UINT32(2U, store.sequence);
    TEST_ASSERT_NULL(write(2U));
    TEST_ASSERT_EQUAL_UINT32(4U, store.sequence);
    flash.refuses_erase = true;
    TEST_ASSERT_NOT_NULL(write(3U));
    TEST_ASSERT_EQUAL_UINT32(5U, store.sequence);
    TEST_ASSERT_NOT_NULL(write(3U)); /* the other slot is whole: the same once more */
    TEST_ASSERT_EQUAL_UINT32(5U, store.sequence);
    flash.refuses_erase = false;
    flash.refuses_program = true;
    TEST_ASSERT_NOT_NULL(write(3U)); /* and now it is not, a write may have gone to its end */
    flash.refuses_program = false;
    TEST_ASSERT_NULL(write(3U));
    TEST_ASSERT_EQUAL_UINT32(10U, store.sequence);
    TEST_ASSERT_EQUAL_UINT32(3U, start());
}

TEST(test_the_higher_number_is_the_newer_one_also_behind_a_wrap)
{
    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_NULL(write(2U));      /* both slots are whole: the number does not go up by 4 */
    store.sequence = UINT32_MAX - 2U; /* so that the next one is UINT32_MAX − 1, and then 0 */
    for (uint32_t number = 3U; number < 7U; number++) {
        assert_stores(number);
    }
    TEST_ASSERT_LESS_THAN_UINT32(20U, store.sequence);
}

TEST(test_an_erase_that_fails_is_said_and_keeps_the_old_block)
{
    TEST_ASSERT_NULL(write(1U));
    flash.refuses_erase = true;
    TEST_ASSERT_EQUAL_STRING("the flash cannot be erased", write(2U));
    TEST_ASSERT_EQUAL_UINT32(1U, start());
}

TEST(test_a_unit_that_does_not_keep_what_is_written_is_said_and_keeps_the_old_block)
{
    TEST_ASSERT_NULL(write(1U));
    die(7U, 7U);
    assert_nothing_kept(write(2U));
    flash.dead = HAL_HOST_FLASH_NEVER;
    flash.refuses_program = true;
    assert_nothing_kept(write(2U));
    flash.refuses_program = false;
    assert_stores(3U);
}

TEST(test_any_byte_that_comes_out_wrong_is_said)
{
    for (uint32_t byte = 0U; byte < HAL_STORE_UNIT_BYTES; byte++) {
        flash.flips = (uint64_t)1U << (8U * byte);
        TEST_ASSERT_NOT_NULL(write(1U));
        TEST_ASSERT_EQUAL_UINT32(NONE, start());
    }
}

TEST(test_a_stamp_goes_to_the_next_unit_up_to_the_last_where_one_does_not_keep_it)
{
    TEST_ASSERT_NULL(write(1U));
    die(STORE_BLOCK_UNITS, STORE_BLOCK_UNITS + 5U);
    assert_stores(2U);
    setUp();
    die(STORE_BLOCK_UNITS, HAL_STORE_UNITS - 2U);
    assert_stores(1U);
}

TEST(test_a_block_that_gets_no_stamp_is_said_and_keeps_the_old_block)
{
    TEST_ASSERT_NULL(write(1U));
    die(STORE_BLOCK_UNITS, HAL_STORE_UNITS - 1U);
    assert_nothing_kept(write(2U));
}

TEST(test_a_kept_block_that_cannot_be_read_any_more_does_not_end_the_store)
{
    TEST_ASSERT_NULL(write(1U));
    make_unreadable(0U, 3U);
    assert_stores(2U);
}

TEST(test_a_single_block_is_found_whatever_its_number)
{
    store.sequence = 0xFFFFFFF0U;
    assert_stores(1U);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF2U, store.sequence);
}

static void change(uint32_t slot, uint32_t unit)
{
    flash.units[slot][unit].after ^= 1U;
}

TEST(test_a_block_with_any_unit_changed_or_unreadable_is_not_found)
{
    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_NULL(write(2U));
    for (uint32_t unit = 0U; unit < BLOCK_UNITS; unit++) {
        const hal_host_flash_unit_t good = flash.units[1][unit];

        change(1U, unit);
        TEST_ASSERT_EQUAL_UINT32(1U, start());
        flash.units[1][unit] = good;
        make_unreadable(1U, unit);
        TEST_ASSERT_EQUAL_UINT32(1U, start());
        flash.units[1][unit] = good;
    }
    TEST_ASSERT_EQUAL_UINT32(2U, start());
}

TEST(test_a_block_whose_stamp_is_changed_or_unreadable_is_not_found)
{
    hal_host_flash_unit_t *const stamp = &flash.units[0][STORE_BLOCK_UNITS];

    TEST_ASSERT_NULL(write(1U));
    change(0U, STORE_BLOCK_UNITS);
    TEST_ASSERT_EQUAL_UINT32(NONE, start());
    change(0U, STORE_BLOCK_UNITS);
    TEST_ASSERT_EQUAL_UINT32(1U, start());
    stamp->half_done = true; /* with the right value: it is corrected, or it is not */
    stamp->half = HAL_HOST_FLASH_AFTER;
    TEST_ASSERT_EQUAL_UINT32(1U, start());
    stamp->half = HAL_HOST_FLASH_UNREADABLE;
    TEST_ASSERT_EQUAL_UINT32(NONE, start());
}

/*
 * A block that is longer, as that of another firmware, is whole: who reads it says what is wrong.
 */
static void write_words(const uint32_t *words, uint32_t count)
{
    uint32_t crc = CRC32_START;
    uint32_t stamp;

    for (uint32_t k = 0U; k < (count - 1U); k++) {
        crc = crc32_step(crc, (const uint8_t *)&words[k]);
    }
    for (uint32_t k = 0U; k < count; k++) {
        const uint64_t word = (k == (count - 1U)) ? (uint32_t)~crc : words[k];
        hal_host_flash_unit_t *const unit = &flash.units[0][k / 2U];

        unit->after &= ~((uint64_t)UINT32_MAX << (32U * (k % 2U)));
        unit->after |= word << (32U * (k % 2U));
    }
    const uint32_t number_and_crc[] = {2U, ~crc};
    stamp = crc32_step(crc32_step(CRC32_START, (const uint8_t *)number_and_crc),
                       (const uint8_t *)&number_and_crc[1]);
    flash.units[0][STORE_BLOCK_UNITS].after = ((uint64_t)(uint32_t)~stamp << 32U) | 2U;
}

static void assert_found_with_length(uint32_t words, bool expected)
{
    static uint32_t block[2U * HAL_STORE_UNITS];

    flash_new(0U);
    memset(block, 0, sizeof block);
    block[0] = CONFIG_BLOCK_MAGIC;
    block[2] = words;
    write_words(block, (words < 4U) ? 4U : words);
    store_find(&store, &hal);
    TEST_ASSERT_EQUAL(expected, store.found);
}

TEST(test_a_block_of_any_length_that_fits_is_found_and_no_other)
{
    assert_found_with_length(4U, true);
    assert_found_with_length(CONFIG_BLOCK_WORDS + 3U, true);
    assert_found_with_length(2U * STORE_BLOCK_UNITS, true);
    assert_found_with_length(2U, false);
    assert_found_with_length(0U, false);
    assert_found_with_length((2U * STORE_BLOCK_UNITS) + 1U, false);
    flash_new(0U);
    flash.units[0][0].after = CONFIG_BLOCK_MAGIC;
    flash.units[0][1].after = UINT32_MAX;
    store_find(&store, &hal);
    TEST_ASSERT_FALSE(store.found);
}

TEST(test_another_magic_is_no_block)
{
    TEST_ASSERT_NULL(write(1U));
    flash.units[0][0].after ^= 0x100U;
    TEST_ASSERT_EQUAL_UINT32(NONE, start());
}

/* Power fails in one step of one store of a sequence; then the sequence goes on. */
static uint32_t cut_once(uint32_t store_number, uint32_t step, uint32_t chance)
{
    flash_new(chance);
    (void)start();
    for (uint32_t number = 0U; number < STORES; number++) {
        if (number == store_number) {
            TEST_ASSERT_FALSE(write_cut(number, step));
            const uint32_t now = start();
            TEST_ASSERT_TRUE((now == number) || (now == (number - 1U)));
        } else {
            assert_stores(number);
        }
    }
    return 1U;
}

TEST(test_a_start_behind_a_cut_in_any_step_finds_the_old_block_or_the_new)
{
    uint32_t cuts = 0U;

    for (uint32_t number = 0U; number < STORES; number++) {
        const uint32_t steps = (number == 0U) ? FIRST_STEPS : STEPS;

        for (uint32_t step = 0U; step < steps; step++) {
            for (uint32_t chance = 0U; chance < CHANCES; chance++) {
                cuts += cut_once(number, step, (chance * 1000U) + step);
            }
        }
    }
    (void)printf("%u cuts, each in one step of one of %u stores\n", (unsigned)cuts, STORES);
}

/* The steps that differ, and some of those that program the block. */
static uint32_t next_step(uint32_t step)
{
    const bool at_an_end = (step < 4U) || ((step + 5U) > STEPS);

    return step + (at_an_end ? 1U : 23U);
}

/*
 * A cut, a start, and the next store is cut too: what that start has found is the old block then.
 */
static uint32_t cut_twice(uint32_t first, uint32_t second, uint32_t chance)
{
    flash_new(chance);
    (void)start();
    TEST_ASSERT_NULL(write(0U));
    TEST_ASSERT_NULL(write(1U));
    TEST_ASSERT_FALSE(write_cut(2U, first));
    const uint32_t kept = start();
    TEST_ASSERT_TRUE((kept == 1U) || (kept == 2U));
    (void)write_cut(3U, second);
    const uint32_t now = start();
    TEST_ASSERT_TRUE((now == kept) || (now == 3U));
    assert_stores(4U);
    return 2U;
}

TEST(test_a_store_that_is_cut_behind_one_that_was_cut_keeps_what_the_start_has_found)
{
    uint32_t cuts = 0U;

    for (uint32_t first = 0U; first < STEPS; first++) {
        for (uint32_t second = 0U; second < STEPS; second = next_step(second)) {
            cuts += cut_twice(first, second, (first * STEPS) + second);
        }
    }
    (void)printf("%u cuts in pairs\n", (unsigned)cuts);
}

/* A bit for each block that a start may find. */
static uint32_t bit_of(uint32_t number)
{
    return (number == NONE) ? 0x80000000U : 1U << (number % 30U);
}

/*
 * One store, cut in a step by chance, most often where the block changes hands; what starts may
 * find from then on.
 */
static uint32_t cut_by_chance(uint32_t number, uint32_t allowed)
{
    const uint32_t near = (uint32_t)(plant_random_bits(&flash.chance) % 5U);
    const uint32_t step = (near < 2U) ? near : ((near < 4U) ? (STEPS - near + 1U) : 60U);
    const uint32_t kept = start();

    TEST_ASSERT_BITS_HIGH(bit_of(kept), allowed);
    flash.erases = 0U;
    if (write_cut(number, step)) {
        return bit_of(number);
    }
    return (flash.erases == 0U) ? allowed : (bit_of(kept) | bit_of(number));
}

/* What was cut may read otherwise at each look. */
TEST(test_units_that_read_otherwise_at_each_look_cost_no_block)
{
    uint32_t cuts = 0U;

    for (uint32_t chance = 0U; chance < 120U; chance++) {
        flash_new(chance);
        flash.unstable = true;
        (void)start();
        TEST_ASSERT_NULL(write(0U));
        uint32_t allowed = bit_of(0U);
        for (uint32_t number = 1U; number < 30U; number++) {
            allowed = cut_by_chance(number, allowed);
            cuts++;
        }
        TEST_ASSERT_BITS_HIGH(bit_of(start()), allowed);
    }
    (void)printf("%u cuts of units that read otherwise at each look\n", (unsigned)cuts);
}

/* Behind 31 cuts there is a unit for the first of two stamps, and none for the second. */
TEST(test_a_store_behind_cuts_that_leave_one_stamp_or_none_is_the_newest)
{
    for (uint32_t cuts = (STAMP_UNITS / 2U) - 2U; cuts < ((STAMP_UNITS / 2U) + 2U); cuts++) {
        flash_new(cuts);
        (void)start();
        TEST_ASSERT_NULL(write(1U));
        for (uint32_t k = 0U; k < cuts; k++) {
            TEST_ASSERT_FALSE(write_cut(2U, 60U));
            TEST_ASSERT_EQUAL_UINT32(1U, start());
        }
        assert_stores(3U);
    }
}

TEST(test_stores_go_on_when_the_stamps_have_run_out)
{
    TEST_ASSERT_NULL(write(0U));
    TEST_ASSERT_NULL(write(1U));
    for (uint32_t k = 0U; k < (2U * STAMP_UNITS); k++) {
        TEST_ASSERT_FALSE(write_cut(2U, (k < STAMP_UNITS) ? 60U : 59U));
        TEST_ASSERT_EQUAL_UINT32(1U, start());
    }
    assert_stores(3U);
}
