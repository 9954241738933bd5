/* SPDX-License-Identifier: MIT */
#include "shaft_decoder.h"

#include "inlining.h"

#define Q32_TO_Q16_SHIFT (16U)

void shaft_decoder_init(shaft_decoder_t *shaft)
{
    *shaft = (shaft_decoder_t){.kind = (uint32_t)SENSOR_KIND_NONE};
}

RARE static void shaft_decoder_begin(shaft_decoder_t *shaft, uint32_t kind)
{
    shaft->kind = kind;
    hall_start(&shaft->hall);
    encoder_start(&shaft->encoder);
    absolute_start(&shaft->absolute);
}

/* No angle is known: the frame says so, with the last trouble as the reason. */
RARE static void shaft_decoder_tell(const shaft_decoder_t *shaft, drive_in_t *in)
{
    const uint32_t flags = DRIVE_FLAG_NO_ANGLE | ((uint32_t)shaft->trouble << DRIVE_TROUBLE_SHIFT);

    in->flags = (uint16_t)(in->flags | flags);
}

/* A request to run begins to count anew. */
static void shaft_decoder_ask(shaft_decoder_t *shaft, uint8_t request)
{
    const bool asked = (request & DRIVE_REQUEST_RUN) != 0U;

    if (asked && !shaft->asked) {
        shaft->before = shaft->troubles;
    }
    shaft->asked = asked;
}

RARE static void shaft_decoder_note(shaft_decoder_t *shaft, uint8_t trouble)
{
    shaft->trouble = trouble;
    shaft->troubles++;
}

/* Of a tick with a sensor. */
static void decode(shaft_decoder_t *shaft, const sensor_cfg_t *cfg, hal_shaft_t read,
                   drive_in_t *in)
{
    const uint32_t kind = cfg->kind;
    bool known;
    uint8_t trouble;

    if (kind == (uint32_t)SENSOR_KIND_HALL) {
        known = hall_step(&shaft->hall, &cfg->hall, (hall_reading_t){read.reading, read.age_q8});
        in->angle = (uint16_t)(shaft->hall.angle >> Q32_TO_Q16_SHIFT);
        trouble = shaft->hall.trouble;
    } else if (kind == (uint32_t)SENSOR_KIND_ABSOLUTE) {
        known = absolute_step(&shaft->absolute, &cfg->absolute, read.reading);
        in->angle = shaft->absolute.ahead;
        trouble = shaft->absolute.trouble;
    } else {
        in->angle = encoder_step(&shaft->encoder, &cfg->encoder,
                                 (encoder_reading_t){read.reading, read.index, read.indexed});
        known = shaft->encoder.known;
        trouble = shaft->encoder.trouble;
    }
    if (trouble != (uint8_t)SHAFT_TROUBLE_NONE) {
        shaft_decoder_note(shaft, trouble);
    }
    if (!known) {
        shaft_decoder_tell(shaft, in);
    }
}

NEVER_INLINED void shaft_decoder_step(shaft_decoder_t *shaft, const sensor_cfg_t *cfg, hal_t *hal,
                                      drive_in_t *in)
{
    if (cfg->kind != shaft->kind) {
        shaft_decoder_begin(shaft, cfg->kind);
    }
    shaft_decoder_ask(shaft, in->command.request);
    if (cfg->kind != (uint32_t)SENSOR_KIND_NONE) {
        decode(shaft, cfg, hal_shaft(hal), in);
    }
}

const char *shaft_trouble_text(shaft_trouble_t trouble)
{
    static const char *const texts[SHAFT_TROUBLES] = {
        [SHAFT_TROUBLE_NONE] = "none",
        [SHAFT_TROUBLE_HALL_PATTERN] = "hall_pattern",
        [SHAFT_TROUBLE_HALL_SIGNAL] = "hall_signal",
        [SHAFT_TROUBLE_HALL_JUMP] = "hall_jump",
        [SHAFT_TROUBLE_COUNTS] = "encoder_counts",
        [SHAFT_TROUBLE_INDEX] = "encoder_index",
        [SHAFT_TROUBLE_FRAME] = "bad_frame",
        [SHAFT_TROUBLE_FLAGGED] = "sensor_error",
        [SHAFT_TROUBLE_TURNED] = "sensor_turned",
    };
    const uint32_t index = (uint32_t)trouble;

    return texts[(index < (uint32_t)SHAFT_TROUBLES) ? index : 0U];
}
