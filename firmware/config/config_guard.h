/* SPDX-License-Identifier: MIT */
/*
 * Guard of the configuration. A CRC is stored with it. The whole configuration is checked at the
 * start, and then again and again, one word per call.
 *
 * The CRC is a CRC-32 (crc32.h) over the bytes of drive_cfg_t before its field crc. It finds every
 * error of up to three bits at this length and every burst of up to 32 bits. Fletcher's sums do
 * not: two flips of highest bits can cancel.
 *
 * All machines that share a configuration are little-endian, and all fields of a configuration have
 * 32 bits, so its bytes are the same on each machine.
 */
#ifndef CONFIG_GUARD_H
#define CONFIG_GUARD_H

#include "drive_cfg.h"
#include "fault.h"

#include <stdint.h>

typedef struct {
    uint32_t at;  /* index of the next byte */
    uint32_t crc; /* CRC of the bytes before `at` */
} config_guard_t;

/* Returns the CRC for the field crc. Any context. */
uint32_t config_guard_crc(const drive_cfg_t *cfg);

/* Begin anew at the first byte. */
void config_guard_reset(config_guard_t *guard);

/*
 * Process the next four bytes. After the last ones it finds FAULT_CONFIGURATION (fault.h) when the
 * CRC differs from the stored one. So it finds a changed bit within two times CONFIG_GUARD_STEPS
 * calls. It finds FAULT_MEMORY when guard->at is beyond the configuration: value is guard->at,
 * limit the end.
 */
fault_id_t config_guard_step(config_guard_t *guard, const drive_cfg_t *cfg, fault_t *fault);

#define CONFIG_GUARD_STEPS (sizeof(drive_cfg_t) / 4U)

#endif
