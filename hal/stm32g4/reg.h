/* SPDX-License-Identifier: MIT */
/*
 * Access to memory-mapped registers by their address: the one place that turns a number into a
 * pointer.
 *
 * All are 32-bit accesses, done in the order in which they are written. Waits are bounded: hardware
 * that does not answer leads to a message, not to an endless loop.
 */
#ifndef REG_H
#define REG_H

#include <stdbool.h>
#include <stdint.h>

/*
 * Reads that reg_wait() makes before it gives up. A read and its loop take at least 8 cycles, so
 * all reads take at least 28 ms at up to 170 MHz. That is longer than an erase of the flash
 * (24.5 ms) and than any wait of the start.
 */
#define REG_PATIENCE (600000U)

static inline volatile uint32_t *reg_at(uint32_t address)
{
    // cppcheck-suppress misra-c2012-11.4 ; D2: the address is given by the chip
    return (volatile uint32_t *)address;
}

static inline uint32_t reg_read(uint32_t address)
{
    return *reg_at(address);
}

static inline void reg_write(uint32_t address, uint32_t value)
{
    *reg_at(address) = value;
}

/* Replaces the bits of `mask` by the bits of `value`, which has no bits outside of `mask`. */
static inline void reg_change(uint32_t address, uint32_t mask, uint32_t value)
{
    reg_write(address, (reg_read(address) & ~mask) | value);
}

static inline void reg_set(uint32_t address, uint32_t bits)
{
    reg_change(address, bits, bits);
}

static inline void reg_clear(uint32_t address, uint32_t bits)
{
    reg_change(address, bits, 0U);
}

static inline bool reg_any(uint32_t address, uint32_t bits)
{
    return (reg_read(address) & bits) != 0U;
}

/* Waits until the bits of `mask` are `value`. False when that does not happen. */
static inline bool reg_wait(uint32_t address, uint32_t mask, uint32_t value)
{
    uint32_t left = REG_PATIENCE;

    while (((reg_read(address) & mask) != value) && (left > 0U)) {
        left--;
    }
    return left > 0U;
}

#endif
