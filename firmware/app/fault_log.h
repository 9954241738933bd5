/* SPDX-License-Identifier: MIT */
/*
 * The log of the last faults and resets, with a CRC, so that it can lie in a memory that a reset
 * leaves as it is, and in the flash.
 *
 * Time counts from the power-up on, over resets. Power-ups are counted by the log itself: a
 * power-up has the number after the one of the log that it has found. So all entries of one
 * power-up have the same number, and a power-up without an entry that was saved has none.
 *
 * Pure functions, for the background.
 */
#ifndef FAULT_LOG_H
#define FAULT_LOG_H

#include "fault.h"
#include "hal.h"
#include "text.h"

#include <stdbool.h>
#include <stdint.h>

#define FAULT_LOG_ENTRIES (32U)

/* An entry. All members are words. */
typedef struct {
    /*
     * fault_id_t, or FAULT_LOG_RESET + hal_reset_reason_t; of a reset, its exception; number of the
     * power-up: see the masks below
     */
    uint32_t what;
    uint32_t seconds; /* since the power-up */
    uint32_t value;   /* of the fault, int32_t as in fault.h; of a reset 0 */
    uint32_t limit;
} fault_log_entry_t;

#define FAULT_LOG_RESET (0x80U)
#define FAULT_LOG_ID_MASK (0xFFU)
#define FAULT_LOG_EXCEPTION_SHIFT (8U)
#define FAULT_LOG_EXCEPTION_MASK (0xFFU)
#define FAULT_LOG_POWER_UP_SHIFT (16U)

/* The log. All members are words. */
typedef struct {
    uint32_t count; /* entries since the board is new: the number of the newest one */
    uint32_t power_up;
    uint32_t seconds; /* since the power-up */
    uint32_t saves;   /* recordings whose saving was begun since the power-up */
    uint32_t saved;   /* number of the last segment of the recording saved last; 0: none */
    /* entry n is at n modulo FAULT_LOG_ENTRIES */
    fault_log_entry_t entries[FAULT_LOG_ENTRIES];
    uint32_t crc;
} fault_log_t;

#define FAULT_LOG_WORDS ((uint32_t)(sizeof(fault_log_t) / sizeof(uint32_t)))

/* Empties the log. */
void fault_log_init(fault_log_t *log);

/* Whether the CRC is right. */
bool fault_log_is_whole(const fault_log_t *log);

/* Call after a change of any member: computes the CRC. About 8000 instructions. */
void fault_log_seal(fault_log_t *log);

/* Word `at` of the log, below FAULT_LOG_WORDS. */
uint32_t fault_log_word(const fault_log_t *log, uint32_t at);
void fault_log_set_word(fault_log_t *log, uint32_t at, uint32_t word);

/* Begins a power-up with a log that an earlier one has left. Seals. */
void fault_log_power_up(fault_log_t *log);

/* Add an entry. They seal. */
void fault_log_fault(fault_log_t *log, const fault_t *fault);
void fault_log_reset(fault_log_t *log, hal_reset_t reset);

/* Returns the number of entries that the log still has, 0…FAULT_LOG_ENTRIES. */
uint32_t fault_log_size(const fault_log_t *log);

/* Returns an entry; 0 is the newest, `age` is below fault_log_size(). */
const fault_log_entry_t *fault_log_entry(const fault_log_t *log, uint32_t age);

/* Adds the reason of a reset: "watchdog after exception 3". */
void fault_log_tell_reset(text_t *text, hal_reset_t reset);

#endif
