/* SPDX-License-Identifier: MIT */
#include "flash.h"

#include "guard.h"
#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"
#include "words.h"

#define PAGE_BYTES (2048U)

_Static_assert((HAL_STORE_UNITS * HAL_STORE_UNIT_BYTES) == PAGE_BYTES, "a slot is a page");

static volatile bool is_reading;    /* hal_store_read() is reading a unit */
static volatile bool is_unreadable; /* the unit that is being read has raised the NMI */

/* Returns the page of a slot, counted from the first page of the black box. */
static uint32_t page_of(uint32_t slot)
{
    return (slot < HAL_STORE_SLOTS) ? (HAL_BOX_SLOTS + slot) : (slot - HAL_STORE_SLOTS);
}

static uint32_t address_of(uint32_t slot, uint32_t unit)
{
    return HAL_BOX + (page_of(slot) * PAGE_BYTES) + (unit * HAL_STORE_UNIT_BYTES);
}

bool flash_forgive(void)
{
    const bool mine = is_reading && reg_any(FLASH_ECCR, FLASH_ECCR_ECCD);

    if (mine) {
        is_unreadable = true;
        reg_write(FLASH_ECCR, FLASH_ECCR_ECCD);
    }
    return mine;
}

/* FLASH_ECCR is read last, so that an NMI of the reads before it has time to come. */
bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    const uint32_t address = address_of(slot, unit);

    (void)hal;
    is_unreadable = false;
    is_reading = true;
    words_put(bytes, reg_read(address));
    words_put(&bytes[WORDS_BYTES], reg_read(address + WORDS_BYTES));
    (void)reg_read(FLASH_ECCR);
    is_reading = false;
    return !is_unreadable;
}

/* If the flash is busy for longer than the watchdog waits, the watchdog resets the chip. */
static bool wait_until_done(void)
{
    return reg_wait(FLASH_SR, FLASH_SR_BSY, 0U);
}

/*
 * A key that is written while the flash is not locked would block it until reset. The caches are
 * switched off, because they would keep the old contents.
 */
static bool unlock(void)
{
    const bool idle = wait_until_done();

    if (reg_any(FLASH_CR, FLASH_CR_LOCK)) {
        reg_write(FLASH_KEYR, FLASH_KEY_1);
        reg_write(FLASH_KEYR, FLASH_KEY_2);
    }
    reg_write(FLASH_SR, FLASH_SR_ERRORS | FLASH_SR_EOP);
    reg_clear(FLASH_ACR, FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    return idle && !reg_any(FLASH_CR, FLASH_CR_LOCK);
}

static bool lock(void)
{
    const bool good = wait_until_done() && !reg_any(FLASH_SR, FLASH_SR_ERRORS);

    if (!reg_any(FLASH_CR, FLASH_CR_LOCK)) {
        reg_write(FLASH_CR, FLASH_CR_LOCK);
    }
    reg_set(FLASH_ACR, FLASH_ACR_ICRST | FLASH_ACR_DCRST);
    reg_clear(FLASH_ACR, FLASH_ACR_ICRST | FLASH_ACR_DCRST);
    reg_set(FLASH_ACR, FLASH_ACR_ICEN | FLASH_ACR_DCEN);
    return good;
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    bool good;

    hal_open_gates(hal);
    guard_hold_ticks();
    good = guard_be_patient() && unlock();
    if (good) {
        reg_write(FLASH_CR, FLASH_CR_PER | HAL_STORE_BANK |
                                ((HAL_BOX_PAGE + page_of(slot)) << FLASH_CR_PNB_SHIFT));
        reg_set(FLASH_CR, FLASH_CR_STRT);
    }
    good = lock() && good;
    good = guard_be_strict() && good;
    guard_release_ticks();
    return good;
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    const uint32_t address = address_of(slot, unit);
    bool good;

    hal_open_gates(hal);
    guard_hold_ticks();
    good = unlock();
    if (good) {
        reg_write(FLASH_CR, FLASH_CR_PG);
        reg_write(address, words_get(bytes));
        reg_write(address + WORDS_BYTES, words_get(&bytes[WORDS_BYTES]));
    }
    good = lock() && good;
    guard_release_ticks();
    return good;
}
