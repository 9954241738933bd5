/* SPDX-License-Identifier: MIT */
/*
 * The flash functions of hal.h over the flash of the simulated hardware (hal_host_flash.h). Where
 * power fails, the program is left by longjmp(power_off, 1).
 */
#ifndef FLASH_MODEL_H
#define FLASH_MODEL_H

#include "hal_host_flash.h"

#include "testing.h"

#include <setjmp.h>

static hal_host_flash_t flash;
static jmp_buf power_off;

static void flash_power_fails(void)
{
    longjmp(power_off, 1);
}

static void flash_new(uint32_t seed)
{
    hal_host_flash_init(&flash, seed);
    flash.power_fails = flash_power_fails;
}

static void flash_assert_inside(uint32_t slot, uint32_t unit)
{
    TEST_ASSERT_LESS_THAN_UINT32(HAL_FLASH_SLOTS, slot);
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_UNITS, unit);
}

bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    flash_assert_inside(slot, unit);
    return hal_host_flash_read(&flash, slot, unit, bytes);
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    (void)hal;
    flash_assert_inside(slot, 0U);
    return hal_host_flash_erase(&flash, slot);
}

bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    (void)hal;
    flash_assert_inside(slot, unit);
    return hal_host_flash_program(&flash, slot, unit, bytes);
}

#endif
