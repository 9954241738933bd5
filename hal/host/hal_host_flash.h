/* SPDX-License-Identifier: MIT */
/*
 * Flash for the store's two slots (hal.h), in units of 64 bits with a code that corrects errors.
 * Power can fail in it.
 *
 * Each erase and each programming of a unit is a step. Before the step that `left` counts down to,
 * power fails: what the step was about to change is left half done, and power_fails() is called,
 * which need not return.
 *
 * Half done is, by chance for each unit, what it was, what it should become, a mixture of both, or
 * what the code cannot correct. A unit is one of these from then on; with `unstable` another one at
 * each read.
 *
 * Context: the one thread of the simulation. Slots are below HAL_STORE_SLOTS, units below
 * HAL_STORE_UNITS.
 */
#ifndef HAL_HOST_FLASH_H
#define HAL_HOST_FLASH_H

#include "hal.h"
#include "random.h"

#define HAL_HOST_FLASH_ERASED UINT64_MAX
#define HAL_HOST_FLASH_NEVER UINT32_MAX

typedef enum {
    HAL_HOST_FLASH_BEFORE,
    HAL_HOST_FLASH_AFTER,
    HAL_HOST_FLASH_MIXED,
    HAL_HOST_FLASH_UNREADABLE,
    HAL_HOST_FLASH_HALVES
} hal_host_flash_half_t;

typedef struct {
    uint64_t before; /* of the step that was cut */
    uint64_t after;  /* or of the last one that was not */
    bool half_done;
    hal_host_flash_half_t half; /* of a stable one */
} hal_host_flash_unit_t;

typedef struct {
    hal_host_flash_unit_t units[HAL_STORE_SLOTS][HAL_STORE_UNITS];
    uint32_t left; /* steps until power fails; HAL_HOST_FLASH_NEVER: it does not */
    uint32_t steps;
    uint32_t erases; /* that have begun */
    bool unstable;
    bool refuses_erase;
    bool refuses_program;
    uint32_t dead; /* of both slots, this unit and those up to dead_last keep what they are */
    uint32_t dead_last;
    uint64_t flips; /* bits of each unit that come out wrong */
    plant_random_t chance;
    void (*power_fails)(void); /* NULL: nobody is told */
} hal_host_flash_t;

/* Erased, without a fault, and a sequence of chances of its own for each seed. */
void hal_host_flash_init(hal_host_flash_t *flash, uint32_t seed);

/* As the three functions of hal.h. */
bool hal_host_flash_read(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                         uint8_t bytes[HAL_STORE_UNIT_BYTES]);
bool hal_host_flash_erase(hal_host_flash_t *flash, uint32_t slot);
bool hal_host_flash_program(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                            const uint8_t bytes[HAL_STORE_UNIT_BYTES]);

#endif
