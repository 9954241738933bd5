/* SPDX-License-Identifier: MIT */
/* COBS: the examples of its paper, and that every piece of bytes comes back. */
#include "cobs.h"
#include "seeded.h"
#include "testing.h"

#include <string.h>

#define CODE_MAX (COBS_BYTES_MAX + 1U)

static uint32_t encode(const uint8_t *bytes, uint32_t count, uint8_t *code)
{
    for (uint32_t at = 0U; at <= count; at++) {
        code[at] = cobs_encoded(bytes, count, at);
        TEST_ASSERT_NOT_EQUAL_UINT8(0U, code[at]);
    }
    return count + 1U;
}

/* How many bytes it gives; *whole: whether the code may end there. */
static uint32_t decode(const uint8_t *code, uint32_t length, uint8_t *bytes, bool *whole)
{
    cobs_decoder_t decoder;
    uint32_t count = 0U;

    cobs_start(&decoder);
    for (uint32_t k = 0U; k < length; k++) {
        if (cobs_decode(&decoder, code[k], &bytes[count])) {
            count++;
        }
    }
    *whole = cobs_may_end(&decoder);
    return count;
}

static void assert_code(const char *expected, const char *bytes, uint32_t count)
{
    uint8_t code[CODE_MAX];

    TEST_ASSERT_EQUAL_UINT32(count + 1U, encode((const uint8_t *)bytes, count, code));
    TEST_ASSERT_EQUAL_UINT8_ARRAY((const uint8_t *)expected, code, count + 1U);
}

TEST(test_a_zero_in_a_code_ends_a_piece_as_a_one_does)
{
    static const uint8_t code[] = {0U, 0U, 3U, 0x11U, 0x22U};
    uint8_t bytes[sizeof code];
    bool whole = false;

    TEST_ASSERT_EQUAL_UINT32(4U, decode(code, sizeof code, bytes, &whole));
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\0\0\x11\x22", bytes, 4U);
    TEST_ASSERT_TRUE(whole);
}

TEST(test_examples_have_the_codes_that_are_published)
{
    assert_code("\x01\x01", "\0", 1U);
    assert_code("\x01\x01\x01", "\0\0", 2U);
    assert_code("\x01\x02\x11\x01", "\0\x11\0", 3U);
    assert_code("\x03\x11\x22\x02\x33", "\x11\x22\0\x33", 4U);
    assert_code("\x05\x11\x22\x33\x44", "\x11\x22\x33\x44", 4U);
    assert_code("\x02\x11\x01\x01\x01", "\x11\0\0\0", 4U);
    assert_code("\x01", "", 0U);
}

static void assert_comes_back(const uint8_t *bytes, uint32_t count)
{
    uint8_t code[CODE_MAX];
    uint8_t back[CODE_MAX];
    bool whole = false;

    TEST_ASSERT_EQUAL_UINT32(count, decode(code, encode(bytes, count, code), back, &whole));
    TEST_ASSERT_TRUE(whole);
    if (count > 0U) {
        TEST_ASSERT_EQUAL_UINT8_ARRAY(bytes, back, count);
    }
}

TEST(test_bytes_of_each_length_and_density_of_zeros_come_back)
{
    seeded_t chance = {7U};
    uint8_t bytes[COBS_BYTES_MAX];

    for (uint32_t count = 0U; count <= COBS_BYTES_MAX; count++) {
        for (uint32_t density = 1U; density <= 256U; density *= 4U) {
            for (uint32_t k = 0U; k < count; k++) {
                const bool zero = (seeded_u32(&chance) % density) == 0U;

                bytes[k] = zero ? 0U : (uint8_t)(seeded_u32(&chance) | 1U);
            }
            assert_comes_back(bytes, count);
        }
    }
}

/* A longer code of another program: the distance 255 stands for no 0. */
TEST(test_a_piece_of_254_bytes_without_a_zero_has_none_behind_it)
{
    uint8_t code[257];
    uint8_t back[260];
    bool whole = false;

    memset(code, 0x55, sizeof code);
    code[0] = 255U;
    code[255] = 2U;
    TEST_ASSERT_EQUAL_UINT32(255U, decode(code, 257U, back, &whole));
    TEST_ASSERT_TRUE(whole);
    TEST_ASSERT_EACH_EQUAL_UINT8(0x55U, back, 255U);
}

TEST(test_a_piece_of_253_bytes_has_a_zero_behind_it)
{
    uint8_t code[256];
    uint8_t back[260];
    bool whole = false;

    memset(code, 0x55, sizeof code);
    code[0] = 254U;
    code[254] = 2U;
    TEST_ASSERT_EQUAL_UINT32(255U, decode(code, 256U, back, &whole));
    TEST_ASSERT_TRUE(whole);
    TEST_ASSERT_EACH_EQUAL_UINT8(0x55U, back, 253U);
    TEST_ASSERT_EQUAL_UINT8(0U, back[253]);
    TEST_ASSERT_EQUAL_UINT8(0x55U, back[254]);
}

TEST(test_a_code_that_is_cut_is_not_whole)
{
    uint8_t back[CODE_MAX];
    bool whole = true;

    (void)decode((const uint8_t *)"\x05\x11\x22\x33", 4U, back, &whole);
    TEST_ASSERT_FALSE(whole);
}
