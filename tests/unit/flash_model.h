/* SPDX-License-Identifier: MIT */
/*
 * Flash whose power fails: the store's two slots of hal.h, in units of 64 bits with a code that corrects errors.
 *
 * Each erase and each programming of a unit is a step. Before the step `flash.left` counts to, power fails in it: what it
 * was about to change is left half done, and the program is left by longjmp(flash.power_fails, 1).
 *
 * Half done is, by chance for each unit, what it was, what it should become, a mixture of both, or what the code cannot
 * correct. A unit is one of these from then on; with `flash.unstable` another one at each read.
 */
#ifndef FLASH_MODEL_H
#define FLASH_MODEL_H

#include "hal.h"
#include "seeded.h"

#include "unity.h"

#include <setjmp.h>
#include <string.h>

#define FLASH_ERASED UINT64_MAX
#define FLASH_NEVER UINT32_MAX

typedef enum {
    FLASH_BEFORE,
    FLASH_AFTER,
    FLASH_MIXED,
    FLASH_UNREADABLE,
    FLASH_HALVES
} flash_half_t;

typedef struct {
    uint64_t before; /* of the step that was cut */
    uint64_t after;  /* or of the last one that was not */
    bool half_done;
    flash_half_t half; /* of a stable one */
} flash_unit_t;

static struct {
    flash_unit_t units[HAL_STORE_SLOTS][HAL_STORE_UNITS];
    uint32_t left; /* steps until power fails */
    uint32_t steps;
    uint32_t erases; /* that have begun */
    bool unstable;
    bool refuses_erase;
    bool refuses_program;
    uint32_t dead; /* of both slots, this unit and those up to dead_last keep what they are */
    uint32_t dead_last;
    uint64_t flips; /* bits of each unit that come out wrong */
    seeded_t chance;
    jmp_buf power_fails;
} flash;

static uint64_t flash_random(void)
{
    return ((uint64_t)seeded_u32(&flash.chance) << 32U) | seeded_u32(&flash.chance);
}

static bool flash_is_dead(uint32_t unit)
{
    return (unit >= flash.dead) && (unit <= flash.dead_last);
}

static flash_half_t flash_any_half(void)
{
    return (flash_half_t)(seeded_u32(&flash.chance) % FLASH_HALVES);
}

/* Erased, and a sequence of chances of its own for each seed. */
static void flash_new(uint32_t seed)
{
    memset(&flash, 0, sizeof flash);
    for (uint32_t slot = 0U; slot < HAL_STORE_SLOTS; slot++) {
        for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
            flash.units[slot][unit].after = FLASH_ERASED;
        }
    }
    flash.left = FLASH_NEVER;
    flash.dead = FLASH_NEVER;
    flash.chance = (seeded_t){.state = (seed * 2654435761U) | 1U};
}

/* Whether power fails in this step. */
static bool flash_step(void)
{
    const bool fails = flash.left == 0U;

    flash.steps++;
    if (flash.left != FLASH_NEVER) {
        flash.left--;
    }
    return fails;
}

static void flash_leave_half_done(flash_unit_t *unit, uint64_t after)
{
    unit->before = unit->half_done ? flash_random() : unit->after;
    unit->after = after;
    unit->half_done = true;
    unit->half = flash_any_half();
}

bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_SLOTS, slot);
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_UNITS, unit);
    const flash_unit_t *const it = &flash.units[slot][unit];
    const flash_half_t half = flash.unstable ? flash_any_half() : it->half;
    uint64_t value = it->after;

    (void)hal;
    if (it->half_done && (half == FLASH_BEFORE)) {
        value = it->before;
    } else if (it->half_done && (half == FLASH_MIXED)) {
        value = (it->before & 0xF0F0F0F00F0F0F0FU) | (it->after & 0x0F0F0F0FF0F0F0F0U);
    } else {
        /* the bytes may be right where the code says that they are not */
    }
    for (uint32_t k = 0U; k < HAL_STORE_UNIT_BYTES; k++) {
        bytes[k] = (uint8_t)(value >> (8U * k));
    }
    return !it->half_done || (half != FLASH_UNREADABLE);
}

bool hal_store_erase(hal_t *hal, uint32_t slot)
{
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_SLOTS, slot);
    const bool fails = flash_step();

    (void)hal;
    if (flash.refuses_erase) {
        return false;
    }
    flash.erases++;
    for (uint32_t unit = 0U; unit < HAL_STORE_UNITS; unit++) {
        flash_unit_t *const it = &flash.units[slot][unit];

        if (fails) {
            flash_leave_half_done(it, FLASH_ERASED);
        } else if (!flash_is_dead(unit)) {
            *it = (flash_unit_t){.after = FLASH_ERASED};
        }
    }
    if (fails) {
        longjmp(flash.power_fails, 1);
    }
    return true;
}

/* What is not erased is not programmed, and the flash says so; of what is half done it does not know. */
bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES])
{
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_SLOTS, slot);
    TEST_ASSERT_LESS_THAN_UINT32(HAL_STORE_UNITS, unit);
    flash_unit_t *const it = &flash.units[slot][unit];
    const bool fails = flash_step();
    uint64_t value = 0U;

    (void)hal;
    for (uint32_t k = 0U; k < HAL_STORE_UNIT_BYTES; k++) {
        value |= (uint64_t)bytes[k] << (8U * k);
    }
    if (flash.refuses_program || (!it->half_done && (it->after != FLASH_ERASED))) {
        return false;
    }
    if (fails || it->half_done) {
        flash_leave_half_done(it, value);
    } else if (!flash_is_dead(unit)) {
        it->after = value ^ flash.flips;
    }
    if (fails) {
        longjmp(flash.power_fails, 1);
    }
    return true;
}

#endif
