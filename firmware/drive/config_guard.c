#include "config_guard.h"

#define GUARDED_BYTES (sizeof(drive_cfg_t) - sizeof(uint32_t)) /* all before the last field, crc */
#define BYTES_AT_ONCE (4U)
#define CRC_START (0xFFFFFFFFU)

/* The polynomial 0xEDB88320 over four bits. */
static uint32_t crc_nibble(uint32_t crc)
{
    static const uint32_t table[16] = {
        0x00000000U, 0x1DB71064U, 0x3B6E20C8U, 0x26D930ACU, 0x76DC4190U, 0x6B6B51F4U,
        0x4DB26158U, 0x5005713CU, 0xEDB88320U, 0xF00F9344U, 0xD6D6A3E8U, 0xCB61B38CU,
        0x9B64C2B0U, 0x86D3D2D4U, 0xA00AE278U, 0xBDBDF21CU,
    };

    return (crc >> 4U) ^ table[crc & 0xFU];
}

static uint32_t crc_word(uint32_t before, const uint8_t *bytes)
{
    uint32_t crc = before;

    for (uint32_t k = 0U; k < BYTES_AT_ONCE; k++) {
        crc = crc_nibble(crc_nibble(crc ^ bytes[k]));
    }
    return crc;
}

uint32_t config_guard_crc(const drive_cfg_t *cfg)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;
    uint32_t crc = CRC_START;

    for (uint32_t at = 0U; at < GUARDED_BYTES; at += BYTES_AT_ONCE) {
        crc = crc_word(crc, &bytes[at]);
    }
    return ~crc;
}

void config_guard_reset(config_guard_t *guard)
{
    *guard = (config_guard_t){.at = 0U, .crc = CRC_START};
}

fault_id_t config_guard_step(config_guard_t *guard, const drive_cfg_t *cfg, fault_t *fault)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;
    fault_id_t id = FAULT_NONE;

    guard->crc = crc_word(guard->crc, &bytes[guard->at]);
    guard->at += BYTES_AT_ONCE;
    if (guard->at >= GUARDED_BYTES) {
        const uint32_t found = ~guard->crc;
        const uint32_t stored = cfg->crc;

        if (found != stored) {
            id = FAULT_CONFIGURATION;
            *fault = (fault_t){.id = id, .value = (int32_t)found, .limit = (int32_t)stored};
        }
        config_guard_reset(guard);
    }
    return id;
}
