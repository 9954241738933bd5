/* SPDX-License-Identifier: MIT */
/*
 * The sensor of the shaft between its binding and the drive: makes the angle of a frame of what
 * hal_shaft() reads. The setting sensor.kind says which decoder does it.
 *
 * Where no angle is known the frame has DRIVE_FLAG_NO_ANGLE and the reason, so that a recording
 * replays without the sensor. Troubles that the decoder survives are counted here, for a person.
 *
 * Context: control interrupt, between hal_sample() and drive_step(); the background reads the
 * counts.
 */
#ifndef SHAFT_DECODER_H
#define SHAFT_DECODER_H

#include "drive_cfg.h"
#include "hal.h"
#include "hall_survey.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t kind;     /* sensor_kind_t of the decoder that runs */
    uint32_t troubles; /* ticks in which a trouble was found, wraps */
    uint32_t before;   /* so many of them were before the last request to run */
    uint8_t trouble;   /* the last one, shaft_trouble_t */
    bool asked;        /* the last frame had that request */
    hall_t hall;
    encoder_t encoder;
    absolute_t absolute;
    hall_survey_t survey; /* of the levels of Hall sensors */
} shaft_decoder_t;

/* Nothing is known; no decoder runs. */
void shaft_decoder_init(shaft_decoder_t *shaft);

/* Whether there is something to do in this tick: a sensor, or the end of one. */
static inline bool shaft_decoder_is_on(const shaft_decoder_t *shaft, const sensor_cfg_t *cfg)
{
    return (cfg->kind | shaft->kind) != (uint32_t)SENSOR_KIND_NONE;
}

/*
 * One tick: sets angle and flags of the frame, whose command is the last one that the drive took.
 * With a sensor of kind NONE the frame stays as it is.
 * Another kind than in the last tick begins anew. Need not be called while shaft_decoder_is_on() is
 * false.
 */
void shaft_decoder_step(shaft_decoder_t *shaft, const sensor_cfg_t *cfg, hal_t *hal,
                        drive_in_t *in);

/* Returns a trouble as a person reads it, lower case; "none". Never NULL. */
const char *shaft_trouble_text(shaft_trouble_t trouble);

#endif
