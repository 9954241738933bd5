/* SPDX-License-Identifier: MIT */
/*
 * Guard of the configuration: a CRC stored with it, checked at start and, a word at a time, for ever.
 *
 * CRC-32 (crc32.h) over the bytes of drive_cfg_t before its field crc. It finds every error of up to three
 * bits at this length and every burst of up to 32, which Fletcher's sums do not: in those two flips of a
 * highest bit can cancel.
 *
 * All machines that share a configuration are little-endian and have all its fields in 32 bits, so its
 * bytes are the same on each.
 */
#ifndef CONFIG_GUARD_H
#define CONFIG_GUARD_H

#include "fault.h"
#include "params.h"

#include <stdint.h>

typedef struct {
    uint32_t at;  /* byte that comes next */
    uint32_t crc; /* of those before */
} config_guard_t;

/* What belongs into the field crc. Any context. */
uint32_t config_guard_crc(const drive_cfg_t *cfg);

/* Begin at the first byte. */
void config_guard_reset(config_guard_t *guard);

/*
 * Four bytes further; at the end FAULT_CONFIGURATION with value and limit in `fault` when the CRC is not
 * the stored one, else FAULT_NONE. A changed bit is found within twice CONFIG_GUARD_STEPS calls.
 */
fault_id_t config_guard_step(config_guard_t *guard, const drive_cfg_t *cfg, fault_t *fault);

#define CONFIG_GUARD_STEPS (sizeof(drive_cfg_t) / 4U)

#endif
