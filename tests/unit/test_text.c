/* SPDX-License-Identifier: MIT */
/* Numbers of the console, in and out. */
#include "text.h"

#include "testing.h"

#include <stdio.h>

#include <stdlib.h>
#include <string.h>

static void check_number(int32_t value, uint32_t decimals, const char *expected)
{
    text_t text = {0};

    text_number(&text, value, decimals);
    TEST_ASSERT_EQUAL_UINT32(strlen(expected), text.length);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, text.characters, text.length);
}

TEST(test_numbers_are_written_with_their_sign_and_decimals)
{
    check_number(0, 0U, "0");
    check_number(7, 0U, "7");
    check_number(-7, 0U, "-7");
    check_number(10, 0U, "10");
    check_number(12345, 2U, "123.45");
    check_number(-12345, 3U, "-12.345");
    check_number(5, 3U, "0.005");
    check_number(-5, 3U, "-0.005");
    check_number(1000, 3U, "1.000");
    check_number(0, 6U, "0.000000");
    check_number(INT32_MAX, 0U, "2147483647");
    check_number(INT32_MIN, 0U, "-2147483648");
    check_number(INT32_MIN, 6U, "-2147.483648");
}

static void check_read(const char *string, bool good, int32_t expected)
{
    int32_t value = 77;

    TEST_ASSERT_EQUAL(good, text_to_number(string, &value));
    TEST_ASSERT_EQUAL_INT32(good ? expected : 77, value);
}

TEST(test_numbers_are_read_whole_or_not_at_all)
{
    check_read("0", true, 0);
    check_read("9", true, 9);
    check_read("-9", true, -9);
    check_read("+42", true, 42);
    check_read("007", true, 7);
    check_read("123456789", true, 123456789);
    check_read("999999999", true, 999999999);
    check_read("-999999999", true, -999999999);
    check_read("1000000000", false, 0);
    check_read("-1000000000", false, 0);
    check_read("", false, 0);
    check_read("-", false, 0);
    check_read("+", false, 0);
    check_read("--1", false, 0);
    check_read("1 ", false, 0);
    check_read(" 1", false, 0);
    check_read("1.5", false, 0);
    check_read("1x", false, 0);
    check_read("/", false, 0); /* before '0', and behind '9' */
    check_read(":", false, 0);
}

TEST(test_what_is_written_is_read_again)
{
    for (int32_t value = -999999999; value <= 999999999 - 1234567; value += 1234567) {
        text_t text = {0};
        int32_t back = 0;

        text_number(&text, value, 0U);
        text.characters[text.length] = '\0';
        TEST_ASSERT_TRUE(text_to_number(text.characters, &back));
        TEST_ASSERT_EQUAL_INT32(value, back);
        TEST_ASSERT_EQUAL_INT32(value, (int32_t)strtol(text.characters, NULL, 10));
    }
}

TEST(test_what_does_not_fit_is_cut_off_and_its_line_still_ends)
{
    text_t text = {0};

    for (uint32_t k = 0U; k < TEXT_MAX; k++) {
        text_add(&text, "ab");
    }
    TEST_ASSERT_EQUAL_UINT32(TEXT_MAX - 2U, text.length);
    TEST_ASSERT_EQUAL_CHAR('b', text.characters[TEXT_MAX - 3U]);
    for (uint32_t k = 0U; k < 2U; k++) { /* the second finds it full */
        text_end_line(&text);
        TEST_ASSERT_EQUAL_UINT32(TEXT_MAX, text.length);
        TEST_ASSERT_EQUAL_CHAR('\r', text.characters[TEXT_MAX - 2U]);
        TEST_ASSERT_EQUAL_CHAR('\n', text.characters[TEXT_MAX - 1U]);
    }
    text_add(&text, "a");
    TEST_ASSERT_EQUAL_UINT32(TEXT_MAX, text.length);
}

TEST(test_what_follows_a_start)
{
    TEST_ASSERT_EQUAL_STRING("100", text_after("speed 100", "speed "));
    TEST_ASSERT_EQUAL_STRING("", text_after("run", "run"));
    TEST_ASSERT_NULL(text_after("ru", "run"));
    TEST_ASSERT_NULL(text_after("Run", "run"));
}

static void assert_millionths(bool good, int32_t expected, const char *string)
{
    int32_t value = 77;

    TEST_ASSERT_EQUAL_MESSAGE(good, text_to_millionths(string, &value), string);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(good ? expected : 77, value, string);
}

TEST(test_a_decimal_number_is_read_in_millionths)
{
    assert_millionths(true, 0, "0");
    assert_millionths(true, 2500000, "2.5");
    assert_millionths(true, -2500000, "-2.50");
    assert_millionths(true, 1, "+0.000001");
    assert_millionths(true, 999999999, "999.999999");
    assert_millionths(true, 12000000, "12");
}

TEST(test_what_is_no_decimal_number_is_none)
{
    static const char *const wrong[] = {"",    "-",  ".",    ".5",        "1.",  "1.2.3",
                                        "1,5", "1 ", "1000", "0.0000001", "1e3", "--1",
                                        "x",   "1-", "+-1",  "1.5x",      "0x10"};

    for (uint32_t k = 0U; k < (sizeof wrong / sizeof wrong[0]); k++) {
        assert_millionths(false, 0, wrong[k]);
    }
}

TEST(test_a_hexadecimal_number_has_eight_digits)
{
    text_t text = {0};

    text_hex(&text, 0x0012ABEFU);
    TEST_ASSERT_EQUAL_UINT32(8U, text.length);
    TEST_ASSERT_EQUAL_STRING("0012ABEF", text.characters);
}

/* The published check value of CRC-32 is that of the characters 1 to 9. */
TEST(test_the_crc_of_characters_is_the_published_one_also_in_parts)
{
    const uint32_t part = text_crc(0xFFFFFFFFU, "1234", 4U);

    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, ~text_crc(0xFFFFFFFFU, "123456789", 9U));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, ~text_crc(part, "56789", 5U));
    TEST_ASSERT_EQUAL_HEX32(part, text_crc(part, "", 0U));
}

/* ---- packed texts ---- */

#define FIRST_PIECE (0x80U)
#define CODES (128U)

static const char *const PIECES[] = {
#define TEXT_PIECE(piece) piece,
#include "text_pieces.def"
#undef TEXT_PIECE
};

#define PIECES_COUNT (sizeof(PIECES) / sizeof(PIECES[0]))

TEST(test_a_code_stands_for_its_piece_and_a_code_without_one_for_nothing)
{
    TEST_ASSERT_LESS_THAN_UINT32(CODES, PIECES_COUNT);
    for (uint32_t code = 1U; code < (FIRST_PIECE + CODES); code++) {
        const char string[] = {'<', (char)code, '>', '\0'};
        const uint32_t number = code - FIRST_PIECE;
        char expected[64];
        text_t text = {0};

        if (code < FIRST_PIECE) {
            (void)snprintf(expected, sizeof expected, "<%c>", (int)code);
        } else {
            (void)snprintf(expected, sizeof expected, "<%s>",
                           (number < PIECES_COUNT) ? PIECES[number] : "");
        }
        text_add(&text, string);
        text.characters[text.length] = '\0';
        TEST_ASSERT_EQUAL_STRING(expected, text.characters);
    }
}
