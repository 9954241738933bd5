/* SPDX-License-Identifier: MIT */
/*
 * A recorded run: the input frame of every tick, and the results of the drive.
 *
 * Two files of one layout: a header, then one record per tick. All numbers are little-endian and
 * packed; each field is written by itself, so the bytes depend neither on the compiler nor on the
 * machine. The simulator's host and the targets compile this one file.
 *
 *     header, 16 bytes    magic 4, version 2, bytes of a record 2, configuration hash 4, ticks 4
 *     frame,  18 bytes    adc_ia 2, adc_ib 2, adc_bus 2, adc_temperature 2, angle 2, flags 2,
 *                         target 4, mode 1, request 1
 *     result, 12 bytes    compare 3 × 2, gate_enable 1, state 1, drive_words_hash() 4
 *
 * Pure functions; only the check of a header can fail.
 */
#ifndef RECORDING_H
#define RECORDING_H

#include "drive.h"

#include <stdint.h>

#define RECORDING_FRAMES (0x5246464EU)  /* magic "NFFR" */
#define RECORDING_RESULTS (0x5352464EU) /* magic "NFRS" */
#define RECORDING_VERSION (4U)

#define RECORDING_HEADER_BYTES (16U)
#define RECORDING_FRAME_BYTES (18U)
#define RECORDING_RESULT_BYTES (12U)

typedef struct {
    uint32_t magic;
    uint16_t version;
    uint16_t record_bytes;
    uint32_t config_hash;
    uint32_t ticks;
} recording_header_t;

/* Returns the header that this version writes. magic: RECORDING_FRAMES or RECORDING_RESULTS. */
recording_header_t recording_header(uint32_t magic, uint32_t config_hash, uint32_t ticks);

void recording_put_header(uint8_t *to, const recording_header_t *header);
recording_header_t recording_get_header(const uint8_t *from);

/*
 * Returns NULL when the frames after this header can be replayed with a drive of this
 * configuration, otherwise the reason why not.
 */
const char *recording_refuse(const recording_header_t *header, uint32_t config_hash);

void recording_put_frame(uint8_t *to, const drive_in_t *in);
drive_in_t recording_get_frame(const uint8_t *from);

/* Writes the output frame of a tick, and the state of the drive after it. */
void recording_put_result(uint8_t *to, const drive_out_t *out, const drive_t *drive);

/* Returns FNV-1a, 32 bits, over the configuration: 32-bit fields without padding. */
uint32_t recording_config_hash(const drive_cfg_t *cfg);

#endif
