/* SPDX-License-Identifier: MIT */
/* The state of the line, for link.h and link_answers.h. */
#ifndef LINK_STATE_H
#define LINK_STATE_H

#include "console.h"
#include "link_frame.h"
#include "link_guard.h"
#include "link_stream.h"
#include "live_config.h"

#include <stdbool.h>
#include <stdint.h>

/* The last question, by the CRC of its whole message, and the last verdict. */
typedef struct {
    uint32_t crc;
    live_config_verdict_t verdict;
} link_answered_t;

typedef struct {
    live_config_t *live;
    console_t console;
    uint32_t said;      /* characters of the console's text that are on their way */
    bool is_linked;     /* the line is the PC's */
    bool is_framing;    /* the line is a person's, and a frame has begun */
    uint32_t byte_tick; /* when the last byte of that frame came in */
    uint32_t tick;      /* of the last pass */
    uint32_t still;     /* passes since the tick has changed or the PC was heard */
    uint32_t question;  /* bytes of a message in `in` that waits for its answer; 0: none */
    link_answered_t last;
    link_in_t in;
    link_out_t out;
    link_guard_t guard;
    link_stream_t stream;
} link_t;

#endif
