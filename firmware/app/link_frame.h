/* SPDX-License-Identifier: MIT */
/*
 * Frames of the link: COBS and CRC-32 around a message (link_messages.h), one frame in and one
 * frame out.
 *
 * Context: background.
 */
#ifndef LINK_FRAME_H
#define LINK_FRAME_H

#include "cobs.h"
#include "link_messages.h"

#include <stdbool.h>
#include <stdint.h>

#define LINK_FRAME_DELIMITER (0U)
#define LINK_FRAME_HEAD_BYTES (2U) /* type and tag */
#define LINK_FRAME_BODY_MAX (LINK_MESSAGE_BYTES_MAX - LINK_FRAME_HEAD_BYTES)
#define LINK_FRAME_BYTES_MAX (LINK_MESSAGE_BYTES_MAX + LINK_CRC_BYTES)

/* A frame that comes in. */
typedef struct {
    cobs_decoder_t cobs;
    /*
     * bytes of the message and its CRC so far; more than LINK_FRAME_BYTES_MAX: the frame is too
     * long
     */
    uint32_t length;
    bool is_open; /* a byte has come since the last delimiter */
    uint8_t bytes[LINK_FRAME_BYTES_MAX];
} link_in_t;

/* Forgets a frame that has begun, and waits for a new one. */
void link_in_start(link_in_t *in);

/*
 * Takes the next byte of the line. Returns true when the byte ends a frame whose CRC is right: then
 * in->bytes has the message, at least type and tag, and *length is its number of bytes. The message
 * stays there until the next byte. Bytes between two delimiters that are not a frame are dropped.
 */
bool link_in_take(link_in_t *in, uint8_t byte, uint32_t *length);

/* Whether a frame has begun and not ended. */
bool link_in_is_open(const link_in_t *in);

/* A frame that goes out. */
typedef struct {
    /* bytes of the message, from link_out_end() on with its CRC; 0: there is no message */
    uint32_t length;
    uint32_t sent; /* bytes of the frame that are on the line */
    bool ready;    /* the frame is whole and may be sent */
    uint8_t bytes[LINK_FRAME_BYTES_MAX];
} link_out_t;

/* Makes `out` free: it has no frame. */
void link_out_start(link_out_t *out);

/* Whether a message can be begun: the last frame has been sent. */
bool link_out_is_free(const link_out_t *out);

/* Begins a message. The frame before must have been sent. */
void link_out_begin(link_out_t *out, uint8_t type, uint8_t tag);

/* Append to the message, the lowest byte first. Bytes that do not fit are left out. */
void link_out_byte(link_out_t *out, uint32_t value);
void link_out_half(link_out_t *out, uint32_t value);
void link_out_word(link_out_t *out, uint32_t value);
void link_out_text(link_out_t *out, const char *text);

/*
 * link_out_room() returns the place for the next bytes of the body; *room gets the number of bytes
 * that fit. Then link_out_add() appends the `count` bytes that were written there.
 */
uint8_t *link_out_room(link_out_t *out, uint32_t *room);
void link_out_add(link_out_t *out, uint32_t count);

/* Ends the message: appends its CRC. From now on the frame may be sent. */
void link_out_end(link_out_t *out);

/*
 * link_out_next() gets the next byte for the line; it returns false if there is none. Call
 * link_out_sent() when the line has taken this byte.
 */
bool link_out_next(const link_out_t *out, uint8_t *byte);
void link_out_sent(link_out_t *out);

#endif
