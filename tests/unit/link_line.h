/* SPDX-License-Identifier: MIT */
/*
 * The PC at the other end of the link: hal_receive() and hal_send() over two pieces of memory,
 * questions as frames, and the frames that came back. The bytes between two frames are a person's
 * text.
 */
#ifndef LINK_LINE_H
#define LINK_LINE_H

#include "cobs.h"
#include "crc32.h"
#include "hal.h"
#include "link_messages.h"
#include "words.h"

#include "testing.h"

#include <string.h>

#define LINE_BYTES_MAX (65536U)
#define LINE_MESSAGES_MAX (512U)

typedef struct {
    uint32_t length; /* of type, tag and body */
    uint8_t bytes[LINK_MESSAGE_BYTES_MAX];
} line_message_t;

static struct {
    uint8_t in[LINE_BYTES_MAX]; /* to the board */
    size_t in_at;
    size_t in_length;
    size_t room; /* that the board may still send */
    uint8_t out[LINE_BYTES_MAX];
    size_t out_length;
    line_message_t messages[LINE_MESSAGES_MAX];
    uint32_t count;
    char text[LINE_BYTES_MAX]; /* outside of frames */
    size_t text_length;
} line;

bool hal_receive(hal_t *hal, uint8_t *byte)
{
    const bool there = line.in_at < line.in_length;

    (void)hal;
    if (there) {
        *byte = line.in[line.in_at];
        line.in_at++;
    }
    return there;
}

bool hal_send(hal_t *hal, uint8_t byte)
{
    const bool room = (line.room > 0U) && (line.out_length < LINE_BYTES_MAX);

    (void)hal;
    if (room) {
        line.out[line.out_length] = byte;
        line.out_length++;
        line.room--;
    }
    return room;
}

static void line_new(void)
{
    memset(&line, 0, sizeof line);
    line.room = SIZE_MAX;
}

static void line_type(const char *typed)
{
    const size_t length = strlen(typed);

    memcpy(&line.in[line.in_length], typed, length);
    line.in_length += length;
}

static void line_byte(uint8_t byte)
{
    line.in[line.in_length] = byte;
    line.in_length++;
}

/* A frame around a message, with its CRC changed by `wrong`. */
static void line_frame(const uint8_t *message, uint32_t length, uint32_t wrong)
{
    uint8_t bytes[COBS_BYTES_MAX];
    uint32_t crc = CRC32_START;

    memcpy(bytes, message, length);
    for (uint32_t k = 0U; k < length; k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    words_put(&bytes[length], ~crc ^ wrong);
    line_byte(0U);
    for (uint32_t at = 0U; at <= (length + LINK_CRC_BYTES); at++) {
        line_byte(cobs_encoded(bytes, length + LINK_CRC_BYTES, at));
    }
    line_byte(0U);
}

static inline void line_ask(uint8_t type, uint8_t tag, const void *body, uint32_t length)
{
    uint8_t message[COBS_BYTES_MAX] = {type, tag};

    if (length > 0U) {
        memcpy(&message[2], body, length);
    }
    line_frame(message, length + 2U, 0U);
}

/* A frame that came: its CRC is right, and it is no longer than a message may be. */
static void line_keep(const uint8_t *code, size_t length)
{
    line_message_t *const message = &line.messages[line.count];
    uint8_t bytes[COBS_BYTES_MAX + 1U];
    cobs_decoder_t decoder;
    uint32_t count = 0U;
    uint32_t crc = CRC32_START;

    cobs_start(&decoder);
    for (size_t k = 0U; k < length; k++) {
        TEST_ASSERT_LESS_THAN_UINT32(sizeof bytes, count);
        count += cobs_decode(&decoder, code[k], &bytes[count]) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(cobs_may_end(&decoder));
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(2U + LINK_CRC_BYTES, count);
    message->length = count - LINK_CRC_BYTES;
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(LINK_MESSAGE_BYTES_MAX, message->length);
    for (uint32_t k = 0U; k < message->length; k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    TEST_ASSERT_EQUAL_HEX32(~crc, words_get(&bytes[message->length]));
    memcpy(message->bytes, bytes, message->length);
    TEST_ASSERT_LESS_THAN_UINT32(LINE_MESSAGES_MAX - 1U, line.count);
    line.count++;
}

/* What came since the last look: messages and text. Frames are whole by then. */
static void line_listen(void)
{
    size_t at = 0U;

    line.count = 0U;
    line.text_length = 0U;
    while (at < line.out_length) {
        if (line.out[at] == 0U) {
            const uint8_t *const code = &line.out[at + 1U];
            const uint8_t *const end = memchr(code, 0, line.out_length - at - 1U);

            TEST_ASSERT_NOT_NULL_MESSAGE(end, "a frame ends");
            line_keep(code, (size_t)(end - code));
            at = (size_t)(end - line.out) + 1U;
        } else {
            line.text[line.text_length] = (char)line.out[at];
            line.text_length++;
            at++;
        }
    }
    line.text[line.text_length] = '\0';
    line.out_length = 0U;
}

/* The first message of a type since line_listen(); NULL when there is none. */
static inline const line_message_t *line_find(uint8_t type)
{
    const line_message_t *found = NULL;

    for (uint32_t k = 0U; (k < line.count) && (found == NULL); k++) {
        if (line.messages[k].bytes[0] == type) {
            found = &line.messages[k];
        }
    }
    return found;
}

/* All characters of LINK_TEXT since line_listen(). */
static inline const char *line_said(void)
{
    line.text_length = 0U;
    for (uint32_t k = 0U; k < line.count; k++) {
        const line_message_t *const message = &line.messages[k];

        if (message->bytes[0] == (uint8_t)LINK_TEXT) {
            memcpy(&line.text[line.text_length], &message->bytes[2], message->length - 2U);
            line.text_length += message->length - 2U;
        }
    }
    line.text[line.text_length] = '\0';
    return line.text;
}

#endif
