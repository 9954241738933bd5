/* SPDX-License-Identifier: MIT */
#include "fault_log.h"

#include "crc32.h"
#include "words.h"

#define CRC_WORD (FAULT_LOG_WORDS - 1U)
#define POWER_UP_MASK (0xFFFFU)

uint32_t fault_log_word(const fault_log_t *log, uint32_t at)
{
    const uint8_t *const bytes = (const uint8_t *)log;
    const uint32_t offset = at * WORDS_BYTES;

    return words_get(&bytes[offset]);
}

void fault_log_set_word(fault_log_t *log, uint32_t at, uint32_t word)
{
    uint8_t *const bytes = (uint8_t *)log;
    const uint32_t offset = at * WORDS_BYTES;

    words_put(&bytes[offset], word);
}

static uint32_t crc_of(const fault_log_t *log)
{
    uint32_t crc = CRC32_START;

    for (uint32_t at = 0U; at < CRC_WORD; at++) {
        crc = crc32_word(crc, fault_log_word(log, at));
    }
    return ~crc;
}

void fault_log_seal(fault_log_t *log)
{
    log->crc = crc_of(log);
}

bool fault_log_is_whole(const fault_log_t *log)
{
    return log->crc == crc_of(log);
}

void fault_log_init(fault_log_t *log)
{
    *log = (fault_log_t){.count = 0U};
    fault_log_seal(log);
}

void fault_log_power_up(fault_log_t *log)
{
    log->power_up = (log->power_up + 1U) & POWER_UP_MASK;
    log->seconds = 0U;
    log->saves = 0U;
    log->saved = 0U;
    fault_log_seal(log);
}

static void add(fault_log_t *log, const fault_log_entry_t *entry)
{
    log->entries[log->count % FAULT_LOG_ENTRIES] = *entry;
    log->count++;
    fault_log_seal(log);
}

void fault_log_fault(fault_log_t *log, const fault_t *fault)
{
    const fault_log_entry_t entry = {.what = (uint32_t)fault->id |
                                             (log->power_up << FAULT_LOG_POWER_UP_SHIFT),
                                     .seconds = log->seconds,
                                     .value = (uint32_t)fault->value,
                                     .limit = (uint32_t)fault->limit};

    add(log, &entry);
}

void fault_log_reset(fault_log_t *log, hal_reset_t reset)
{
    const uint32_t exception = reset.exception & FAULT_LOG_EXCEPTION_MASK;
    const uint32_t what = FAULT_LOG_RESET + (uint32_t)reset.reason;
    const fault_log_entry_t entry = {.what = what | (exception << FAULT_LOG_EXCEPTION_SHIFT) |
                                             (log->power_up << FAULT_LOG_POWER_UP_SHIFT),
                                     .seconds = log->seconds};

    add(log, &entry);
}

uint32_t fault_log_size(const fault_log_t *log)
{
    return (log->count < FAULT_LOG_ENTRIES) ? log->count : FAULT_LOG_ENTRIES;
}

const fault_log_entry_t *fault_log_entry(const fault_log_t *log, uint32_t age)
{
    return &log->entries[(log->count - 1U - age) % FAULT_LOG_ENTRIES];
}

void fault_log_tell_reset(text_t *text, hal_reset_t reset)
{
    static const char *const names[HAL_RESETS] = {"unknown",  "supply",   "pin",
                                                  "software", "watchdog", "of another kind"};
    const uint32_t reason = (uint32_t)reset.reason;

    text_add(text, names[(reason < (uint32_t)HAL_RESETS) ? reason : 0U]);
    if (reset.exception != 0U) {
        text_add(text, " after exception ");
        text_number(text, (int32_t)reset.exception, 0U);
    }
}
