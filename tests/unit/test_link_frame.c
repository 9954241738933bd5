/* SPDX-License-Identifier: MIT */
/* Frames of the link, in and out: what is whole is taken, and nothing else. */
#include "link_frame.h"
#include "seeded.h"
#include "testing.h"
#include "text.h"

#include <string.h>

#define FRAME_MAX (LINK_FRAME_BYTES_MAX + 3U)

static link_in_t in;
static link_out_t out;
static uint8_t frame[FRAME_MAX + 8U];
static uint32_t frame_length;

void setUp(void)
{
    memset(&in, 0xA5, sizeof in);
    memset(&out, 0xA5, sizeof out);
    link_in_start(&in);
    link_out_start(&out);
}

/* What goes out of a message of so many bytes behind type 7 and tag 9. */
static void make(uint32_t body)
{
    uint8_t byte = 1U;

    link_out_begin(&out, 7U, 9U);
    for (uint32_t k = 0U; k < body; k++) {
        link_out_byte(&out, k * 7U);
    }
    link_out_end(&out);
    frame_length = 0U;
    while (link_out_next(&out, &byte)) {
        frame[frame_length] = byte;
        frame_length++;
        link_out_sent(&out);
    }
}

/* How many messages come of `count` bytes; *length: of the last one. */
static uint32_t take(const uint8_t *bytes, uint32_t count, uint32_t *length)
{
    uint32_t messages = 0U;

    for (uint32_t k = 0U; k < count; k++) {
        uint32_t found = 0U;

        if (link_in_take(&in, bytes[k], &found)) {
            messages++;
            *length = found;
        }
    }
    return messages;
}

TEST(test_a_message_of_each_length_comes_in_as_it_went_out)
{
    for (uint32_t body = 0U; body <= LINK_FRAME_BODY_MAX; body++) {
        uint32_t length = 0U;

        make(body);
        TEST_ASSERT_EQUAL_UINT32(body + 2U + LINK_CRC_BYTES + 3U, frame_length);
        TEST_ASSERT_EQUAL_UINT8(0U, frame[0]);
        TEST_ASSERT_NULL_MESSAGE(memchr(&frame[1], 0, frame_length - 2U), "0 is a delimiter only");
        TEST_ASSERT_EQUAL_UINT32(1U, take(frame, frame_length, &length));
        TEST_ASSERT_EQUAL_UINT32(body + 2U, length);
        TEST_ASSERT_EQUAL_UINT8(7U, in.bytes[0]);
        TEST_ASSERT_EQUAL_UINT8(9U, in.bytes[1]);
        for (uint32_t k = 0U; k < body; k++) {
            TEST_ASSERT_EQUAL_UINT8((uint8_t)(k * 7U), in.bytes[2U + k]);
        }
    }
}

TEST(test_the_bytes_on_the_line_are_those_of_the_page)
{
    /* HELLO, tag 1, version 4, salt 12345678h: as docs/link.md shows it */
    static const uint8_t hello[] = {0x00, 0x0C, 0x01, 0x01, 0x04, 0x78, 0x56,
                                    0x34, 0x12, 0x61, 0xF9, 0xEE, 0x8B, 0x00};
    uint8_t byte = 0U;

    link_out_begin(&out, (uint8_t)LINK_HELLO, 1U);
    link_out_byte(&out, LINK_VERSION);
    link_out_word(&out, 0x12345678U);
    link_out_end(&out);
    for (uint32_t k = 0U; k < sizeof hello; k++) {
        TEST_ASSERT_TRUE(link_out_next(&out, &byte));
        TEST_ASSERT_EQUAL_HEX8_MESSAGE(hello[k], byte, "a byte of the frame");
        link_out_sent(&out);
    }
    TEST_ASSERT_FALSE(link_out_next(&out, &byte));
    TEST_ASSERT_TRUE(link_out_is_free(&out));
}

TEST(test_numbers_have_their_lowest_byte_first_and_text_its_characters)
{
    static const uint8_t expected[] = {7U, 9U, 0x34U, 0x12U, 0x78U, 0x56U, 0x34U, 0x12U, 'a', 'b'};

    link_out_begin(&out, 7U, 9U);
    link_out_half(&out, 0x1234U);
    link_out_word(&out, 0x12345678U);
    link_out_text(&out, "ab");
    TEST_ASSERT_EQUAL_UINT32(sizeof expected, out.length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, out.bytes, sizeof expected);
}

TEST(test_what_does_not_fit_into_a_message_is_left_out)
{
    uint32_t room = 0U;

    make(LINK_FRAME_BODY_MAX + 40U);
    TEST_ASSERT_EQUAL_UINT32(FRAME_MAX, frame_length);
    link_out_begin(&out, 7U, 9U);
    TEST_ASSERT_EQUAL_PTR(&out.bytes[2], link_out_room(&out, &room));
    TEST_ASSERT_EQUAL_UINT32(LINK_FRAME_BODY_MAX, room);
    link_out_add(&out, 100U);
    (void)link_out_room(&out, &room);
    TEST_ASSERT_EQUAL_UINT32(LINK_FRAME_BODY_MAX - 100U, room);
}

TEST(test_nothing_is_sent_before_the_message_ends)
{
    uint8_t byte = 0U;

    TEST_ASSERT_TRUE(link_out_is_free(&out));
    TEST_ASSERT_FALSE(link_out_next(&out, &byte));
    link_out_begin(&out, 7U, 9U);
    TEST_ASSERT_FALSE(link_out_is_free(&out));
    TEST_ASSERT_FALSE(link_out_next(&out, &byte));
}

/* A CRC-32 finds each: a byte at this length is a burst of 8 bits. */
TEST(test_a_frame_with_any_byte_changed_is_dropped_and_the_next_one_is_taken)
{
    for (uint32_t at = 0U; at < 40U; at++) {
        for (uint32_t flip = 1U; flip < 256U; flip++) {
            uint32_t length = 0U;

            make(31U);
            frame[at % frame_length] ^= (uint8_t)flip;
            TEST_ASSERT_EQUAL_UINT32(0U, take(frame, frame_length, &length));
            make(31U);
            (void)take(frame, 1U, &length);
            TEST_ASSERT_EQUAL_UINT32(1U, take(frame, frame_length, &length));
        }
    }
}

TEST(test_a_frame_with_a_byte_lost_or_doubled_is_dropped)
{
    for (uint32_t at = 1U; at < 39U; at++) {
        uint32_t length = 0U;

        make(31U);
        (void)take(frame, at, &length);
        TEST_ASSERT_EQUAL_UINT32(0U, take(&frame[at + 1U], frame_length - at - 1U, &length));
        (void)take(frame, at + 1U, &length);
        TEST_ASSERT_EQUAL_UINT32(0U, take(&frame[at], frame_length - at, &length));
    }
}

TEST(test_a_frame_without_type_and_tag_or_beyond_the_longest_is_none)
{
    /* the CRC of nothing, 0, and of one byte that is 0xFF: 0xFF000000 */
    static const uint8_t nothing[] = {0U, 1U, 1U, 1U, 1U, 1U, 0U};
    static const uint8_t one[] = {0U, 2U, 0xFFU, 1U, 1U, 2U, 0xFFU, 0U};
    uint8_t longer[300];
    uint32_t length = 0U;

    TEST_ASSERT_EQUAL_UINT32(0U, take(nothing, sizeof nothing, &length));
    TEST_ASSERT_EQUAL_UINT32(0U, take(one, sizeof one, &length));
    memset(longer, 1, sizeof longer);
    longer[0] = 0U;
    longer[sizeof longer - 1U] = 0U;
    TEST_ASSERT_EQUAL_UINT32(0U, take(longer, sizeof longer, &length));
    make(3U);
    TEST_ASSERT_EQUAL_UINT32(1U, take(frame, frame_length, &length));
}

/* Its first bytes alone would be a frame, with the right CRC. */
TEST(test_the_longest_frame_with_a_byte_behind_it_is_none)
{
    uint8_t longer[LINK_FRAME_BYTES_MAX + 1U] = {0U};
    uint32_t length = 0U;

    make(LINK_FRAME_BODY_MAX);
    TEST_ASSERT_EQUAL_UINT32(1U, take(frame, frame_length, &length));
    memcpy(longer, in.bytes, LINK_FRAME_BYTES_MAX);
    (void)take((const uint8_t[]){0U}, 1U, &length);
    for (uint32_t at = 0U; at <= sizeof longer; at++) {
        const uint8_t code = cobs_encoded(longer, sizeof longer, at);

        TEST_ASSERT_EQUAL_UINT32(0U, take(&code, 1U, &length));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, take((const uint8_t[]){0U}, 1U, &length));
}

TEST(test_a_frame_is_open_from_its_first_byte_to_its_delimiter)
{
    uint32_t length = 0U;

    make(3U);
    (void)take(frame, 1U, &length);
    TEST_ASSERT_FALSE(link_in_is_open(&in));
    (void)take(&frame[1], 1U, &length);
    TEST_ASSERT_TRUE(link_in_is_open(&in));
    (void)take(&frame[2], frame_length - 2U, &length);
    TEST_ASSERT_FALSE(link_in_is_open(&in));
}

TEST(test_frames_that_share_a_delimiter_are_both_taken)
{
    uint32_t length = 0U;

    make(3U);
    TEST_ASSERT_EQUAL_UINT32(1U, take(frame, frame_length, &length));
    TEST_ASSERT_EQUAL_UINT32(1U, take(&frame[1], frame_length - 1U, &length));
}

TEST(test_any_bytes_harm_nothing)
{
    seeded_t chance = {5U};

    for (uint32_t k = 0U; k < 500000U; k++) {
        uint32_t length = 0U;
        const bool zero = (seeded_u32(&chance) % 128U) == 0U;

        if (link_in_take(&in, zero ? 0U : (uint8_t)seeded_u32(&chance), &length)) {
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(LINK_MESSAGE_BYTES_MAX, length);
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(LINK_FRAME_HEAD_BYTES, length);
        }
    }
}

TEST(test_a_packed_text_goes_out_in_full)
{
    const char packed[] = {'a', (char)0x80, 'z', '\0'};
    const char *const piece = text_piece(packed[1]);
    const uint32_t length = (uint32_t)strlen(piece);

    link_out_start(&out);
    link_out_begin(&out, 1U, 2U);
    link_out_text(&out, packed);
    TEST_ASSERT_EQUAL_UINT32(LINK_FRAME_HEAD_BYTES + length + 2U, out.length);
    TEST_ASSERT_EQUAL_CHAR('a', out.bytes[LINK_FRAME_HEAD_BYTES]);
    TEST_ASSERT_EQUAL_MEMORY(piece, &out.bytes[LINK_FRAME_HEAD_BYTES + 1U], length);
    TEST_ASSERT_EQUAL_CHAR('z', out.bytes[LINK_FRAME_HEAD_BYTES + 1U + length]);
}
