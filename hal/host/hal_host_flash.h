/* SPDX-License-Identifier: MIT */
/*
 * Simulated flash with all slots of hal.h, in units of 64 bits with an error-correcting
 * code. A loss of power can be simulated.
 *
 * Each erase and each programming of a unit is a step. Power fails in the step that begins when
 * `left` is 0: the units that this step changes are left half done, and power_fails() is called,
 * which need not return.
 *
 * A half-done unit holds, by chance, its old value, its new value, a mixture of both, or bits that
 * the code cannot correct. It keeps this choice from then on; with `unstable` each read chooses
 * anew.
 *
 * Context: the one thread of the simulation. Slots are below HAL_FLASH_SLOTS, units below
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
    uint64_t before; /* old value of a half-done unit */
    uint64_t after;  /* new value of a half-done unit; value of any other unit */
    bool half_done;
    /* the value that a half-done unit holds; with `unstable` it is not used */
    hal_host_flash_half_t half;
} hal_host_flash_unit_t;

typedef struct {
    hal_host_flash_unit_t units[HAL_FLASH_SLOTS][HAL_STORE_UNITS];
    uint32_t left; /* whole steps until power fails; HAL_HOST_FLASH_NEVER: it does not fail */
    uint32_t steps;
    uint32_t erases; /* erases that were begun */
    bool unstable;
    bool refuses_erase;
    bool refuses_program;
    uint32_t dead; /* the units from this one to dead_last never change, in all slots */
    uint32_t dead_last;
    uint64_t flips; /* bits that are programmed wrong in each unit */
    plant_random_t chance;
    void (*power_fails)(void); /* NULL: nothing is called */
} hal_host_flash_t;

/* Sets up an erased flash without a fault. Each seed gives a random sequence of its own. */
void hal_host_flash_init(hal_host_flash_t *flash, uint32_t seed);

/* As the three functions of hal.h. */
bool hal_host_flash_read(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                         uint8_t bytes[HAL_STORE_UNIT_BYTES]);
bool hal_host_flash_erase(hal_host_flash_t *flash, uint32_t slot);
bool hal_host_flash_program(hal_host_flash_t *flash, uint32_t slot, uint32_t unit,
                            const uint8_t bytes[HAL_STORE_UNIT_BYTES]);

#endif
