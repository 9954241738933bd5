/* SPDX-License-Identifier: MIT */
#include "link_frame.h"

#include "crc32.h"
#include "text.h"
#include "words.h"

#include <stddef.h>

#define BYTE_BITS (8U)
#define BYTE_MASK (0xFFU)
#define TOO_LONG (LINK_FRAME_BYTES_MAX + 1U)
#define WHOLE_MIN (LINK_FRAME_HEAD_BYTES + LINK_CRC_BYTES)

_Static_assert(LINK_FRAME_BYTES_MAX <= COBS_BYTES_MAX, "a frame is one piece of COBS");

static uint32_t frame_crc(const uint8_t *bytes, uint32_t count)
{
    uint32_t crc = CRC32_START;

    for (uint32_t k = 0U; k < count; k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    return ~crc;
}

void link_in_start(link_in_t *in)
{
    cobs_start(&in->cobs);
    in->length = 0U;
    in->is_open = false;
}

static bool is_whole(const link_in_t *in)
{
    bool whole = false;

    if (cobs_may_end(&in->cobs) && (in->length >= WHOLE_MIN) &&
        (in->length <= LINK_FRAME_BYTES_MAX)) {
        const uint32_t length = in->length - LINK_CRC_BYTES;

        whole = frame_crc(in->bytes, length) == words_get(&in->bytes[length]);
    }
    return whole;
}

static void take_inside(link_in_t *in, uint8_t byte)
{
    uint8_t decoded = 0U;

    in->is_open = true;
    if (cobs_decode(&in->cobs, byte, &decoded)) {
        if (in->length < LINK_FRAME_BYTES_MAX) {
            in->bytes[in->length] = decoded;
            in->length++;
        } else {
            in->length = TOO_LONG;
        }
    }
}

bool link_in_take(link_in_t *in, uint8_t byte, uint32_t *length)
{
    bool ends = false;

    if (byte != LINK_FRAME_DELIMITER) {
        take_inside(in, byte);
    } else {
        ends = is_whole(in);
        *length = ends ? (in->length - LINK_CRC_BYTES) : 0U;
        link_in_start(in);
    }
    return ends;
}

bool link_in_is_open(const link_in_t *in)
{
    return in->is_open;
}

void link_out_start(link_out_t *out)
{
    out->length = 0U;
    out->sent = 0U;
    out->ready = false;
}

bool link_out_is_free(const link_out_t *out)
{
    return out->length == 0U;
}

void link_out_begin(link_out_t *out, uint8_t type, uint8_t tag)
{
    link_out_start(out);
    link_out_byte(out, type);
    link_out_byte(out, tag);
}

uint8_t *link_out_room(link_out_t *out, uint32_t *room)
{
    *room = LINK_MESSAGE_BYTES_MAX - out->length;
    return &out->bytes[out->length];
}

void link_out_add(link_out_t *out, uint32_t count)
{
    out->length += count;
}

void link_out_byte(link_out_t *out, uint32_t value)
{
    if (out->length < LINK_MESSAGE_BYTES_MAX) {
        out->bytes[out->length] = (uint8_t)(value & BYTE_MASK);
        out->length++;
    }
}

void link_out_half(link_out_t *out, uint32_t value)
{
    link_out_byte(out, value);
    link_out_byte(out, value >> BYTE_BITS);
}

void link_out_word(link_out_t *out, uint32_t value)
{
    link_out_half(out, value);
    link_out_half(out, value >> (2U * BYTE_BITS));
}

static void put_plain(link_out_t *out, const char *text)
{
    for (uint32_t k = 0U; text[k] != '\0'; k++) {
        link_out_byte(out, (uint8_t)text[k]);
    }
}

void link_out_text(link_out_t *out, const char *text)
{
    for (uint32_t k = 0U; text[k] != '\0'; k++) {
        const char *const piece = text_piece(text[k]);

        if (piece == NULL) {
            link_out_byte(out, (uint8_t)text[k]);
        } else {
            put_plain(out, piece);
        }
    }
}

void link_out_end(link_out_t *out)
{
    words_put(&out->bytes[out->length], frame_crc(out->bytes, out->length));
    out->length += LINK_CRC_BYTES;
    out->ready = true;
}

/*
 * A frame has three parts: a delimiter; the COBS code, which is one byte longer than message and
 * CRC; another delimiter.
 */
bool link_out_next(const link_out_t *out, uint8_t *byte)
{
    const uint32_t code = out->length + 1U;

    if (out->ready) {
        const bool is_code = (out->sent >= 1U) && (out->sent <= code);

        *byte =
            is_code ? cobs_encoded(out->bytes, out->length, out->sent - 1U) : LINK_FRAME_DELIMITER;
    }
    return out->ready;
}

void link_out_sent(link_out_t *out)
{
    out->sent++;
    if (out->sent >= (out->length + 3U)) {
        link_out_start(out);
    }
}
