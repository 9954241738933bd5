/* SPDX-License-Identifier: MIT */
#include "hal_host_flash.h"

#include <stddef.h>

static bool is_dead(const hal_host_flash_t *flash, uint32_t unit)
{
    return (unit >= flash->dead) && (unit <= flash->dead_last);
}

static hal_host_flash_half_t any_half(hal_host_flash_t *flash)
{
    return (hal_host_flash_half_t)(plant_random_bits(&flash->chance) %
                                   (uint64_t)HAL_HOST_FLASH_HALVES);
}

void hal_host_flash_init(hal_host_flash_t *flash, uint32_t seed)
{
    *flash = (hal_host_flash_t){.left = HAL_HOST_FLASH_NEVER, .dead = HAL_HOST_FLASH_NEVER};
    for (uint32_t slot = 0U; slot < HAL_FLASH_SLOTS; slot++) {
        for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
            flash->units[slot][unit].after = HAL_HOST_FLASH_ERASED;
        }
    }
    plant_random_init(&flash->chance, seed);
}

/* Whether power fails in this step. */
static bool begin_step(hal_host_flash_t *flash)
{
    const bool fails = flash->left == 0U;

    flash->steps++;
    if (flash->left != HAL_HOST_FLASH_NEVER) {
        flash->left--;
    }
    return fails;
}

static void end_step(const hal_host_flash_t *flash, bool fails)
{
    if (fails && (flash->power_fails != NULL)) {
        flash->power_fails();
    }
}

static void leave_half_done(hal_host_flash_t *flash, hal_host_flash_unit_t *unit, uint64_t after)
{
    unit->before = unit->half_done ? plant_random_bits(&flash->chance) : unit->after;
    unit->after = after;
    unit->half_done = true;
    unit->half = any_half(flash);
}

bool hal_host_flash_read(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                         uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    const hal_host_flash_unit_t *const it = &flash->units[slot][unit];
    const hal_host_flash_half_t half = flash->unstable ? any_half(flash) : it->half;
    uint64_t value = it->after;

    if (it->half_done && (half == HAL_HOST_FLASH_BEFORE)) {
        value = it->before;
    } else if (it->half_done && (half == HAL_HOST_FLASH_MIXED)) {
        value = (it->before & 0xF0F0F0F00F0F0F0FU) | (it->after & 0x0F0F0F0FF0F0F0F0U);
    } else {
        /* the bytes of an unreadable unit may be right, too */
    }
    for (uint32_t k = 0U; k < HAL_STORE_UNIT_BYTES; k++) {
        bytes[k] = (uint8_t)(value >> (8U * k));
    }
    return !it->half_done || (half != HAL_HOST_FLASH_UNREADABLE);
}

static void erase_unit(hal_host_flash_t *flash, uint32_t slot, uint32_t unit, bool fails)
{
    hal_host_flash_unit_t *const it = &flash->units[slot][unit];

    if (fails) {
        leave_half_done(flash, it, HAL_HOST_FLASH_ERASED);
    } else if (!is_dead(flash, unit)) {
        *it = (hal_host_flash_unit_t){.after = HAL_HOST_FLASH_ERASED};
    } else {
        /* a dead unit keeps its value */
    }
}

bool hal_host_flash_erase(hal_host_flash_t *flash, uint32_t slot)
{
    const bool fails = begin_step(flash);
    const bool works = !flash->refuses_erase;

    if (works) {
        flash->erases++;
        for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
            erase_unit(flash, slot, unit, fails);
        }
        end_step(flash, fails);
    }
    return works;
}

/*
 * A unit that is not erased is not programmed, and the flash reports it. The flash does not notice
 * that a unit is half done, so it programs it, and the unit stays half done.
 */
bool hal_host_flash_program(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                            const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    hal_host_flash_unit_t *const it = &flash->units[slot][unit];
    const bool fails = begin_step(flash);
    const bool works =
        !flash->refuses_program && (it->half_done || (it->after == HAL_HOST_FLASH_ERASED));
    uint64_t value = 0U;

    for (uint32_t k = 0U; k < HAL_STORE_UNIT_BYTES; k++) {
        value |= (uint64_t)bytes[k] << (8U * k);
    }
    if (works && (fails || it->half_done)) {
        leave_half_done(flash, it, value);
    } else if (works && !is_dead(flash, unit)) {
        it->after = value ^ flash->flips;
    } else {
        /* nothing is programmed */
    }
    end_step(flash, works && fails);
    return works;
}
