/* SPDX-License-Identifier: MIT */
/*
 * The slots of the STM32G431's flash against a model of its controller, RM0440 3.3 and 3.7: keys,
 * errors, a page of 2 KiB, double words of which each is programmed once, and an NMI where one is
 * torn.
 */
#include "flash.h"
#include "hal_config.h"
#include "stm32g4.h"
#include "testing.h"

#include <string.h>

#define KEPT_BYTES (16384U) /* six pages of the black box, two of the store */
#define FIRST_PAGE (56U)
#define LAST_PAGE (63U)
#define PAGE_WORDS (512U)
#define WORDS (KEPT_BYTES / 4U)
#define NONE UINT32_MAX
#define CACHE_RESETS (FLASH_ACR_ICRST | FLASH_ACR_DCRST)
#define BUSY_LOOKS (2U) /* fewer than reg_wait() has */
#define FOREVER (100U)

typedef struct {
    uint32_t store[WORDS];
    uint32_t torn; /* double word */
    uint32_t acr;
    uint32_t stale; /* caches that still show what was there, by the bit that empties them */
    uint32_t cr;
    uint32_t sr;
    uint32_t eccr;
    uint32_t keys;
    uint32_t busy; /* looks at FLASH_SR that still show it */
    uint32_t busy_for;
    uint32_t next_error; /* of the next operation */
    uint32_t first;      /* of two words that are programmed */
    bool keys_blocked;
    bool nmi_forgiven;
    bool held;    /* ticks */
    bool patient; /* the watchdog */
    bool gates_open;
    bool lacks_patience;
    bool lacks_strictness;
} chip_t;

static chip_t chip;
static hal_t *const none = NULL;

void hal_open_gates(hal_t *hal)
{
    (void)hal;
    chip.gates_open = true;
}

void guard_hold_ticks(void)
{
    TEST_ASSERT_TRUE(chip.gates_open);
    chip.held = true;
}

void guard_release_ticks(void)
{
    TEST_ASSERT_EQUAL_HEX32(FLASH_CR_LOCK, chip.cr);
    TEST_ASSERT_FALSE(chip.patient);
    TEST_ASSERT_EQUAL_HEX32(FLASH_ACR_ICEN | FLASH_ACR_DCEN, chip.acr);
    TEST_ASSERT_EQUAL_HEX32(0U, chip.stale);
    chip.held = false;
}

bool guard_be_patient(void)
{
    TEST_ASSERT_TRUE(chip.held);
    chip.patient = true;
    return !chip.lacks_patience;
}

bool guard_be_strict(void)
{
    chip.patient = false;
    return !chip.lacks_strictness;
}

static void begin_operation(void)
{
    TEST_ASSERT_TRUE(chip.held);
    TEST_ASSERT_EQUAL_HEX32(0U, chip.acr & (FLASH_ACR_ICEN | FLASH_ACR_DCEN));
    TEST_ASSERT_EQUAL_HEX32(0U, chip.sr & FLASH_SR_ERRORS);
    chip.stale = CACHE_RESETS;
    chip.busy = chip.busy_for;
    chip.sr |= chip.next_error;
}

static void write_cr(uint32_t value)
{
    if ((chip.cr & FLASH_CR_LOCK) != 0U) {
        TEST_FAIL_MESSAGE("the control register is written while it is locked");
    }
    chip.cr = value;
    if ((value & FLASH_CR_STRT) != 0U) {
        const uint32_t page = (value >> FLASH_CR_PNB_SHIFT) & 0x7FU;

        TEST_ASSERT_EQUAL_HEX32(FLASH_CR_PER, value & (FLASH_CR_PER | FLASH_CR_PG));
        TEST_ASSERT_TRUE((page >= FIRST_PAGE) && (page <= LAST_PAGE));
        TEST_ASSERT_TRUE(chip.patient);
        begin_operation();
        memset(&chip.store[(page - FIRST_PAGE) * PAGE_WORDS], 0xFF, 2048U);
        chip.cr &= ~FLASH_CR_STRT;
    }
}

static void write_store(uint32_t at, uint32_t value)
{
    TEST_ASSERT_EQUAL_HEX32(FLASH_CR_PG, chip.cr);
    if ((at % 2U) == 0U) {
        chip.first = value;
    } else {
        begin_operation();
        if ((chip.store[at] & chip.store[at - 1U]) != UINT32_MAX) {
            chip.sr |= 1UL << 3; /* PROGERR */
        } else {
            chip.store[at - 1U] = chip.first;
            chip.store[at] = value;
        }
    }
}

/* A cache is emptied while it is off: while it is on the bit does nothing. */
static void write_acr(uint32_t value)
{
    const uint32_t on = value & (FLASH_ACR_ICEN | FLASH_ACR_DCEN);

    chip.stale &= (on == 0U) ? ~value : UINT32_MAX;
    chip.acr = value;
}

static void write_key(uint32_t value)
{
    const uint32_t expected = (chip.keys == 0U) ? FLASH_KEY_1 : FLASH_KEY_2;

    chip.keys_blocked =
        chip.keys_blocked || (value != expected) || ((chip.cr & FLASH_CR_LOCK) == 0U);
    chip.keys++;
    if ((chip.keys == 2U) && !chip.keys_blocked) {
        chip.keys = 0U;
        chip.cr &= ~FLASH_CR_LOCK;
    }
}

void reg_write(uint32_t address, uint32_t value)
{
    if (address == FLASH_KEYR) {
        write_key(value);
    } else if (address == FLASH_CR) {
        write_cr(value);
    } else if (address == FLASH_SR) {
        chip.sr &= ~value;
    } else if (address == FLASH_ECCR) {
        chip.eccr &= ~(value & FLASH_ECCR_ECCD);
    } else if (address == FLASH_ACR) {
        write_acr(value);
    } else {
        TEST_ASSERT_TRUE((address >= HAL_BOX) && (address < (HAL_BOX + KEPT_BYTES)));
        write_store((address - HAL_BOX) / 4U, value);
    }
}

static uint32_t read_store(uint32_t at)
{
    TEST_ASSERT_LESS_THAN_UINT32(WORDS, at);
    if ((at / 2U) == chip.torn) {
        chip.eccr |= FLASH_ECCR_ECCD;
        chip.nmi_forgiven = flash_forgive(); /* the NMI */
    }
    return chip.store[at];
}

static uint32_t read_status(void)
{
    uint32_t status = chip.sr;

    if (chip.busy > 0U) {
        status |= FLASH_SR_BSY;
        chip.busy -= (chip.busy_for < FOREVER) ? 1U : 0U;
    }
    return status;
}

uint32_t reg_read(uint32_t address)
{
    uint32_t value = chip.acr;

    if (address == FLASH_CR) {
        value = chip.cr;
    } else if (address == FLASH_SR) {
        value = read_status();
    } else if (address == FLASH_ECCR) {
        value = chip.eccr;
    } else if (address != FLASH_ACR) {
        value = read_store((address - HAL_BOX) / 4U);
    }
    return value;
}

void setUp(void)
{
    chip = (chip_t){.torn = NONE,
                    .acr = FLASH_ACR_ICEN | FLASH_ACR_DCEN,
                    .cr = FLASH_CR_LOCK,
                    .busy_for = BUSY_LOOKS};
    memset(chip.store, 0xFF, sizeof chip.store);
}

void tearDown(void)
{
    TEST_ASSERT_FALSE(chip.held);
    TEST_ASSERT_FALSE(chip.keys_blocked);
}

/* The slots of the store are the last pages, those of the black box the pages before them. */
static uint32_t word_of(uint32_t slot, uint32_t unit)
{
    static const uint32_t pages[HAL_FLASH_SLOTS] = {6U, 7U, 0U, 1U, 2U, 3U, 4U, 5U};

    return (pages[slot] * PAGE_WORDS) + (unit * 2U);
}

static const uint8_t BYTES[] = {0x01U, 0x02U, 0x03U, 0x04U, 0x05U, 0x06U, 0x07U, 0x88U};

static void assert_reads(uint32_t slot, uint32_t unit, const uint8_t *expected)
{
    uint8_t read[HAL_STORE_UNIT_BYTES] = {0};

    TEST_ASSERT_TRUE(hal_store_read(none, slot, unit, read));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, read, sizeof read);
}

TEST(test_a_unit_is_programmed_where_it_is_read_and_nowhere_else)
{
    static const uint8_t erased[] = {0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU, 0xFFU};

    for (uint32_t slot = 0U; slot < HAL_FLASH_SLOTS; slot++) {
        for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit += 85U) {
            setUp();
            TEST_ASSERT_TRUE(hal_store_program(none, slot, unit, BYTES));
            TEST_ASSERT_EQUAL_HEX32(0x04030201U, chip.store[word_of(slot, unit)]);
            assert_reads(slot, unit, BYTES);
            assert_reads((slot + 1U) % HAL_FLASH_SLOTS, unit, erased);
            assert_reads(slot, (unit + 1U) % HAL_STORE_UNITS, erased);
        }
    }
}

TEST(test_an_erase_is_of_its_slot_alone)
{
    for (uint32_t slot = 0U; slot < HAL_FLASH_SLOTS; slot++) {
        setUp();
        for (uint32_t one = 0U; one < HAL_FLASH_SLOTS; one++) {
            TEST_ASSERT_TRUE(hal_store_program(none, one, 3U, BYTES));
        }
        TEST_ASSERT_TRUE(hal_store_erase(none, slot));
        TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, chip.store[word_of(slot, 3U)]);
        for (uint32_t one = 0U; one < HAL_FLASH_SLOTS; one++) {
            if (one != slot) {
                assert_reads(one, 3U, BYTES);
            }
        }
    }
}

TEST(test_a_unit_that_is_not_erased_is_an_error_and_stays)
{
    static const uint8_t other[HAL_STORE_UNIT_BYTES] = {0};

    TEST_ASSERT_TRUE(hal_store_program(none, 0U, 3U, BYTES));
    TEST_ASSERT_FALSE(hal_store_program(none, 0U, 3U, other));
    assert_reads(0U, 3U, BYTES);
}

TEST(test_an_error_does_not_last)
{
    chip.sr = FLASH_SR_ERRORS; /* of whoever came before */
    TEST_ASSERT_TRUE(hal_store_erase(none, 0U));
    for (uint32_t bit = 0U; bit < 16U; bit++) {
        const uint32_t error = FLASH_SR_ERRORS & (1UL << bit);

        chip.next_error = error;
        TEST_ASSERT_EQUAL(error == 0U, hal_store_erase(none, 0U));
        chip.next_error = 0U;
        TEST_ASSERT_TRUE(hal_store_program(none, 0U, bit, BYTES));
    }
}

TEST(test_a_flash_that_stays_busy_is_an_error_before_and_behind)
{
    chip.busy_for = FOREVER;
    TEST_ASSERT_FALSE(hal_store_erase(none, 0U));
    TEST_ASSERT_FALSE(hal_store_program(none, 0U, 0U, BYTES));
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, chip.store[word_of(0U, 0U)]);
}

TEST(test_a_flash_that_does_not_unlock_is_an_error)
{
    chip.keys = 1U; /* it waits for the second key */
    TEST_ASSERT_FALSE(hal_store_program(none, 0U, 0U, BYTES));
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, chip.store[word_of(0U, 0U)]);
    chip.keys_blocked = false;
}

TEST(test_what_is_unlocked_already_gets_no_keys)
{
    chip.cr = 0U;
    TEST_ASSERT_TRUE(hal_store_program(none, 0U, 0U, BYTES));
}

TEST(test_a_watchdog_that_does_not_wait_is_an_error_before_the_erase)
{
    chip.store[word_of(0U, 0U)] = 0U;
    chip.lacks_patience = true;
    TEST_ASSERT_FALSE(hal_store_erase(none, 0U));
    TEST_ASSERT_EQUAL_HEX32(0U, chip.store[word_of(0U, 0U)]);
    chip.lacks_patience = false;
    chip.lacks_strictness = true;
    TEST_ASSERT_FALSE(hal_store_erase(none, 0U));
}

TEST(test_a_torn_unit_is_unreadable_and_the_next_one_is_not)
{
    uint8_t read[HAL_STORE_UNIT_BYTES];

    TEST_ASSERT_TRUE(hal_store_program(none, 1U, 4U, BYTES));
    chip.torn = word_of(1U, 3U) / 2U;
    TEST_ASSERT_FALSE(hal_store_read(none, 1U, 3U, read));
    TEST_ASSERT_TRUE(chip.nmi_forgiven);
    TEST_ASSERT_EQUAL_HEX32(0U, chip.eccr);
    assert_reads(1U, 4U, BYTES);
}

TEST(test_an_nmi_of_anything_else_is_not_forgiven)
{
    TEST_ASSERT_FALSE(flash_forgive());
    chip.eccr = FLASH_ECCR_ECCD; /* of code, or of a constant */
    TEST_ASSERT_FALSE(flash_forgive());
    TEST_ASSERT_EQUAL_HEX32(FLASH_ECCR_ECCD, chip.eccr);
}
