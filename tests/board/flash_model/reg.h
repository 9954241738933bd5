/* SPDX-License-Identifier: MIT */
/*
 * In place of the binding's header of this name: each access of flash.c goes to the model of
 * test_flash.c.
 */
#ifndef REG_H
#define REG_H

#include <stdbool.h>
#include <stdint.h>

uint32_t reg_read(uint32_t address);
void reg_write(uint32_t address, uint32_t value);

static inline void reg_set(uint32_t address, uint32_t bits)
{
    reg_write(address, reg_read(address) | bits);
}

static inline void reg_clear(uint32_t address, uint32_t bits)
{
    reg_write(address, reg_read(address) & ~bits);
}

static inline bool reg_any(uint32_t address, uint32_t bits)
{
    return (reg_read(address) & bits) != 0U;
}

/* Gives up after three looks. */
static inline bool reg_wait(uint32_t address, uint32_t mask, uint32_t value)
{
    bool there = false;

    for (uint32_t k = 0U; (k < 3U) && !there; k++) {
        there = (reg_read(address) & mask) == value;
    }
    return there;
}

#endif
