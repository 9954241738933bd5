/* SPDX-License-Identifier: MIT */
#include "config_guard.h"

#include "crc32.h"
#include "inlining.h"

/* all fields before the last one, crc */
#define GUARDED_BYTES (sizeof(drive_cfg_t) - sizeof(uint32_t))
#define BYTES_AT_ONCE (4U)

uint32_t config_guard_crc(const drive_cfg_t *cfg)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;
    uint32_t crc = CRC32_START;

    for (uint32_t at = 0U; at < GUARDED_BYTES; at += BYTES_AT_ONCE) {
        crc = crc32_step(crc, &bytes[at]);
    }
    return ~crc;
}

void config_guard_reset(config_guard_t *guard)
{
    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START};
}

static fault_id_t check_next_word(config_guard_t *guard, const drive_cfg_t *cfg, fault_t *fault)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;
    fault_id_t id = FAULT_NONE;

    guard->crc = crc32_step(guard->crc, &bytes[guard->at]);
    guard->at += BYTES_AT_ONCE;
    if (guard->at >= GUARDED_BYTES) {
        const uint32_t found = ~guard->crc;
        const uint32_t stored = cfg->crc;

        if (found != stored) {
            id = FAULT_CONFIGURATION;
            *fault = (fault_t){.id = id, .value = fx_signed(found), .limit = fx_signed(stored)};
        }
        config_guard_reset(guard);
    }
    return id;
}

/*
 * Begins again at the first byte, and finds MEMORY: a bit of the index has flipped by itself, and
 * the index is beyond the configuration.
 */
RARE static fault_id_t begin_again(config_guard_t *guard, fault_t *fault)
{
    const uint32_t end = GUARDED_BYTES;

    *fault = (fault_t){.id = FAULT_MEMORY, .value = fx_signed(guard->at), .limit = fx_signed(end)};
    config_guard_reset(guard);
    return FAULT_MEMORY;
}

fault_id_t config_guard_step(config_guard_t *guard, const drive_cfg_t *cfg, fault_t *fault)
{
    return (guard->at < GUARDED_BYTES) ? check_next_word(guard, cfg, fault)
                                       : begin_again(guard, fault);
}
