/* SPDX-License-Identifier: MIT */
#include "recording.h"

#include "drive_words.h"

#include <stddef.h>

#define FNV_BASIS (2166136261U)
#define FNV_PRIME (16777619U)

static void put8(uint8_t **to, uint32_t value)
{
    **to = (uint8_t)(value & 0xFFU);
    (*to)++;
}

static void put16(uint8_t **to, uint32_t value)
{
    put8(to, value);
    put8(to, value >> 8U);
}

static void put32(uint8_t **to, uint32_t value)
{
    put16(to, value);
    put16(to, value >> 16U);
}

static uint8_t get8(const uint8_t **from)
{
    const uint8_t value = **from;

    (*from)++;
    return value;
}

static uint16_t get16(const uint8_t **from)
{
    const uint32_t low = get8(from);
    const uint32_t high = get8(from);

    return (uint16_t)(low | (high << 8U));
}

static uint32_t get32(const uint8_t **from)
{
    const uint32_t low = get16(from);
    const uint32_t high = get16(from);

    return low | (high << 16U);
}

recording_header_t recording_header(uint32_t magic, uint32_t config_hash, uint32_t ticks)
{
    const uint32_t bytes =
        (magic == RECORDING_FRAMES) ? RECORDING_FRAME_BYTES : RECORDING_RESULT_BYTES;

    return (recording_header_t){
        .magic = magic,
        .version = RECORDING_VERSION,
        .record_bytes = (uint16_t)bytes,
        .config_hash = config_hash,
        .ticks = ticks,
    };
}

void recording_put_header(uint8_t *to, const recording_header_t *header)
{
    uint8_t *at = to;

    put32(&at, header->magic);
    put16(&at, header->version);
    put16(&at, header->record_bytes);
    put32(&at, header->config_hash);
    put32(&at, header->ticks);
}

recording_header_t recording_get_header(const uint8_t *from)
{
    const uint8_t *at = from;
    recording_header_t header;

    header.magic = get32(&at);
    header.version = get16(&at);
    header.record_bytes = get16(&at);
    header.config_hash = get32(&at);
    header.ticks = get32(&at);
    return header;
}

const char *recording_refuse(const recording_header_t *header, uint32_t config_hash)
{
    const char *why = NULL;

    if (header->magic != RECORDING_FRAMES) {
        why = "this is no recording of input frames\n";
    } else if ((header->version != RECORDING_VERSION) ||
               (header->record_bytes != RECORDING_FRAME_BYTES)) {
        why = "the recording has another version\n";
    } else if (header->config_hash != config_hash) {
        why = "the recording was made with another configuration\n";
    } else {
        /* the frames can be replayed */
    }
    return why;
}

void recording_put_frame(uint8_t *to, const drive_in_t *in)
{
    uint8_t *at = to;

    put16(&at, in->adc_ia);
    put16(&at, in->adc_ib);
    put16(&at, in->adc_bus);
    put16(&at, in->adc_temperature);
    put16(&at, in->angle);
    put16(&at, in->flags);
    put32(&at, (uint32_t)in->command.target);
    put8(&at, in->command.mode);
    put8(&at, in->command.request);
}

drive_in_t recording_get_frame(const uint8_t *from)
{
    const uint8_t *at = from;
    drive_in_t in;

    in.adc_ia = get16(&at);
    in.adc_ib = get16(&at);
    in.adc_bus = get16(&at);
    in.adc_temperature = get16(&at);
    in.angle = get16(&at);
    in.flags = get16(&at);
    in.command.target = (int32_t)get32(&at);
    in.command.mode = get8(&at);
    in.command.request = get8(&at);
    return in;
}

void recording_put_result(uint8_t *to, const drive_out_t *out, const drive_t *drive)
{
    uint8_t *at = to;

    put16(&at, out->compare.phase[0]);
    put16(&at, out->compare.phase[1]);
    put16(&at, out->compare.phase[2]);
    put8(&at, out->gate_enable ? 1U : 0U);
    put8(&at, (uint32_t)drive->state);
    put32(&at, drive_words_hash(drive));
}

uint32_t recording_config_hash(const drive_cfg_t *cfg)
{
    const uint8_t *const bytes = (const uint8_t *)cfg;
    uint32_t hash = FNV_BASIS;

    for (size_t k = 0U; k < sizeof(*cfg); k++) {
        hash = (hash ^ bytes[k]) * FNV_PRIME;
    }
    return hash;
}
