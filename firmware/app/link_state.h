/* SPDX-License-Identifier: MIT */
/* The state of the line, for link.h and link_answers.h. */
#ifndef LINK_STATE_H
#define LINK_STATE_H

#include "console.h"
#include "input.h"
#include "link_frame.h"
#include "link_stream.h"
#include "live_config.h"
#include "source_guard.h"

#include <stdbool.h>
#include <stdint.h>

/* Kept to recognise a question that the PC repeats. */
typedef struct {
    uint32_t crc;                  /* CRC of the whole message of the last question */
    live_config_verdict_t verdict; /* the last verdict */
} link_answered_t;

typedef struct {
    live_config_t *live;
    console_t console;
    uint32_t said;      /* characters of the console's text that have been passed on already */
    bool is_linked;     /* the PC has the line */
    bool is_framing;    /* a frame has begun; used only while a person has the line */
    uint32_t byte_tick; /* tick in which the last byte of a frame came in */
    uint32_t tick;      /* tick at the last pass */
    uint32_t still;     /* passes since the tick last changed or the PC was last heard */
    /* bytes of a message in `in` that waits for its answer; 0: no message waits */
    uint32_t question;
    link_answered_t last;
    link_in_t in;
    link_out_t out;
    source_guard_t guard; /* of the PC */
    source_guard_t typed; /* of the person at the console */
    input_t input;
    link_stream_t stream;
} link_t;

#endif
