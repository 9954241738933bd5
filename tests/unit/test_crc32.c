/* SPDX-License-Identifier: MIT */
/*
 * The check value: against the polynomial itself, bit by bit, and against values of the standard.
 */
#include "crc32.h"
#include "testing.h"

#define POLYNOMIAL (0xEDB88320U)
#define BYTES (4U)

static uint32_t bit_by_bit(uint32_t before, const uint8_t *bytes)
{
    uint32_t crc = before;

    for (uint32_t bit = 0U; bit < (8U * BYTES); bit++) {
        const uint32_t in = (uint32_t)bytes[bit / 8U] >> (bit % 8U);

        crc = (crc >> 1U) ^ ((((crc ^ in) & 1U) != 0U) ? POLYNOMIAL : 0U);
    }
    return crc;
}

TEST(test_each_value_of_each_byte_divides_as_the_polynomial_does)
{
    static const uint32_t before[] = {CRC32_START, 0U, 0x12345678U};

    for (uint32_t start = 0U; start < 3U; start++) {
        for (uint32_t at = 0U; at < BYTES; at++) {
            for (uint32_t value = 0U; value < 256U; value++) {
                uint8_t bytes[BYTES] = {0x5AU, 0xC3U, 0x0FU, 0x96U};

                bytes[at] = (uint8_t)value;
                TEST_ASSERT_EQUAL_HEX32(bit_by_bit(before[start], bytes),
                                        crc32_step(before[start], bytes));
            }
        }
    }
}

static void assert_crc(uint32_t expected, const char *text)
{
    const uint8_t *const bytes = (const uint8_t *)text;
    const uint32_t first = crc32_step(CRC32_START, bytes);

    TEST_ASSERT_EQUAL_HEX32(expected, ~crc32_step(first, &bytes[BYTES]));
}

/* As every other program of this CRC gives them. */
TEST(test_known_texts_have_their_known_values)
{
    assert_crc(0x9AE0DAAFU, "12345678");
    assert_crc(0xAEEF2A50U, "abcdefgh");
}

TEST(test_four_single_bytes_are_a_step)
{
    static const uint8_t bytes[BYTES] = {0x5AU, 0x00U, 0xFFU, 0x96U};
    uint32_t crc = 0x12345678U;

    for (uint32_t k = 0U; k < BYTES; k++) {
        crc = crc32_byte(crc, bytes[k]);
    }
    TEST_ASSERT_EQUAL_HEX32(bit_by_bit(0x12345678U, bytes), crc);
    TEST_ASSERT_EQUAL_HEX32(0xE8B7BE43U, ~crc32_byte(CRC32_START, (uint8_t)'a'));
}
