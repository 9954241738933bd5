/* SPDX-License-Identifier: MIT */
/*
 * The state as words: none is missed, none is the machine's, and each goes back to where it came
 * from.
 */
#include "drive_words.h"
#include "testing.h"

#include <stddef.h>
#include <string.h>

/*
 * Bytes of drive_t on a 64-bit PC that belong to the machine: the pointer to the configuration, the
 * rest of the words of the mode, of the count of the slow period and of five flags, and the words
 * where 64-bit fields ask for alignment.
 */
#define LONE_BYTES (7U)
#define BYTE_PADDING (LONE_BYTES * 3U)
#define WORD (4U)
/* The source of the estimate and its three flags lie side by side: words without a rest. */
#define SIDE_BY_SIDE (4U)
#define FLAGS_AND_BYTES (LONE_BYTES + SIDE_BY_SIDE)
#define ADDED (SIDE_BY_SIDE * (WORD - 1U))
#define END(member) (offsetof(drive_t, member) + sizeof(((drive_t *)NULL)->member))
#define BETWEEN(member, next) (offsetof(drive_t, next) - END(member))
#define ALIGNMENT \
    (BETWEEN(control, rotor) + BETWEEN(rotor.residual, rotor.angle_sensor) + \
     BETWEEN(rotor.failed, sensors) + BETWEEN(voltage_drive, motion) + \
     BETWEEN(motion.torque_loop, motor) + BETWEEN(motor, vector) + \
     BETWEEN(vector.current_mean, start) + (sizeof(drive_t) - END(scene)))
#define MACHINE_BYTES (sizeof(void *) + BYTE_PADDING + ALIGNMENT)

/* A field that is added to the state and not to its words is found here. */
TEST(test_hash_sees_every_byte)
{
    drive_t drive;
    uint8_t bytes[sizeof(drive)];
    uint32_t unseen = 0U;
    uint32_t hash;

    (void)memset(&drive, 0, sizeof(drive));
    hash = drive_words_hash(&drive);
    for (size_t k = 0U; k < sizeof(drive); k++) {
        (void)memset(bytes, 0, sizeof(bytes));
        bytes[k] = 1U;
        (void)memcpy(&drive, bytes, sizeof(drive));
        if (drive_words_hash(&drive) == hash) {
            unseen++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(MACHINE_BYTES, unseen);
}

/* FNV-1a by its definition, over a state of zeros; bytes go in as words. */
TEST(test_hash_is_fnv_1a)
{
    drive_t drive;
    uint32_t expected = 2166136261U;

    (void)memset(&drive, 0, sizeof(drive));
    for (size_t k = 0U; k < (sizeof(drive) - sizeof(void *) - ALIGNMENT + ADDED); k++) {
        expected *= 16777619U;
    }
    TEST_ASSERT_EQUAL_HEX32(expected, drive_words_hash(&drive));
}

TEST(test_number_of_words_is_that_of_the_states_bytes)
{
    TEST_ASSERT_EQUAL_UINT32(sizeof(drive_t) - sizeof(void *) - ALIGNMENT + ADDED,
                             WORD * drive_words_count());
}

/* Bytes of 1, so that a flag is one. */
TEST(test_state_of_a_states_words_has_its_hash)
{
    drive_t from;
    drive_t to;
    uint32_t words = 0U;

    (void)memset(&from, 1, sizeof(from));
    (void)memset(&to, 0, sizeof(to));
    TEST_ASSERT_NOT_EQUAL(drive_words_hash(&from), drive_words_hash(&to));
    for (uint32_t at = 0U; at < drive_words_count(); at++) {
        const uint32_t word = drive_words_get(&from, at);

        words += (word == 0x01010101U) ? 1U : 0U;
        drive_words_set(&to, at, word);
        TEST_ASSERT_EQUAL_HEX32(word, drive_words_get(&to, at));
    }
    TEST_ASSERT_EQUAL_UINT32(drive_words_count() - FLAGS_AND_BYTES, words);
    TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&from), drive_words_hash(&to));
    TEST_ASSERT_NULL(to.cfg);
}

TEST(test_hash_is_over_the_words_in_their_order)
{
    uint32_t expected = 2166136261U;
    drive_t drive;

    (void)memset(&drive, 0, sizeof(drive));
    for (uint32_t at = 0U; at < drive_words_count(); at++) {
        drive_words_set(&drive, at, at & 1U);
    }
    for (uint32_t at = 0U; at < drive_words_count(); at++) {
        const uint32_t word = drive_words_get(&drive, at);

        for (uint32_t k = 0U; k < WORD; k++) {
            expected = (expected ^ ((word >> (8U * k)) & 0xFFU)) * 16777619U;
        }
    }
    TEST_ASSERT_EQUAL_HEX32(expected, drive_words_hash(&drive));
}

TEST(test_beyond_the_last_word_there_is_nothing)
{
    drive_t drive;
    uint32_t hash;

    (void)memset(&drive, 1, sizeof(drive));
    hash = drive_words_hash(&drive);
    drive_words_set(&drive, drive_words_count(), 7U);
    TEST_ASSERT_EQUAL_HEX32(0U, drive_words_get(&drive, drive_words_count()));
    TEST_ASSERT_EQUAL_HEX32(hash, drive_words_hash(&drive));
}

TEST(test_a_hash_in_parts_of_any_size_is_the_whole_one)
{
    drive_t drive;

    memset(&drive, 0x3C, sizeof drive);
    for (uint32_t part = 1U; part <= (drive_words_count() + 1U); part++) {
        uint32_t hash = DRIVE_WORDS_HASH_START;
        uint32_t at = 0U;

        while (at < drive_words_count()) {
            const uint32_t before = at;

            hash = drive_words_hash_part(hash, &drive, &at, part);
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(part, at - before);
        }
        TEST_ASSERT_EQUAL_HEX32(drive_words_hash(&drive), hash);
    }
}
