/* SPDX-License-Identifier: MIT */
/* Words as bytes: the lowest first, and nothing beside them. */
#include "testing.h"
#include "words.h"

TEST(test_a_word_is_read_with_its_lowest_byte_first)
{
    const uint8_t bytes[] = {0xFFU, 0x81U, 0x02U, 0x43U, 0xF4U, 0xFFU};

    TEST_ASSERT_EQUAL_HEX32(0xF4430281U, words_get(&bytes[1]));
}

TEST(test_a_word_is_written_with_its_lowest_byte_first)
{
    const uint8_t expected[] = {0xAAU, 0x81U, 0x02U, 0x43U, 0xF4U, 0xAAU};
    uint8_t bytes[] = {0xAAU, 0U, 0U, 0U, 0U, 0xAAU};

    words_put(&bytes[1], 0xF4430281U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, sizeof bytes);
}
