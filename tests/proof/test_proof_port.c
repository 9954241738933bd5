/* SPDX-License-Identifier: MIT */
/* What the proof has in place of some functions gives what they give. */
#include "fx.h"
#include "proof_port.h"
#include "ring.h"
#include "testing.h"

#include <stdint.h>

#define COUNT (7U)
#define STEP (7U)
#define ENTRIES (40U)

static proof_word_t *const saturations[COUNT] = {fx_sat14, fx_sat15, fx_sat16, fx_sat27,
                                                 fx_sat28, fx_sat30, fx_usat15};

TEST(test_each_saturation_is_that_of_the_proof_around_every_limit_and_over_the_range)
{
    for (uint32_t k = 0U; k < COUNT; k++) {
        for (uint64_t x = 0U; x <= UINT32_MAX; x += STEP * 101U) {
            const int32_t word = (int32_t)(uint32_t)x;

            TEST_ASSERT_EQUAL_INT32(saturations[k](word), proof_saturations[k](word));
        }
        for (uint32_t bit = 12U; bit < 32U; bit++) {
            for (uint32_t x = (1U << bit) - 3U; x != ((1U << bit) + 4U); x++) {
                TEST_ASSERT_EQUAL_INT32(saturations[k]((int32_t)x),
                                        proof_saturations[k]((int32_t)x));
                TEST_ASSERT_EQUAL_INT32(saturations[k]((int32_t)(0U - x)),
                                        proof_saturations[k]((int32_t)(0U - x)));
            }
        }
    }
}

TEST(test_words_are_read_as_the_proof_reads_them)
{
    for (uint64_t x = 0U; x <= UINT32_MAX; x += STEP * 11U) {
        const uint32_t word = (uint32_t)x;

        TEST_ASSERT_EQUAL_INT32(fx_signed(word), proof_signed(word));
        TEST_ASSERT_EQUAL_UINT32(fx_unsigned(fx_signed(word)), proof_unsigned(fx_signed(word)));
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, proof_signed(0x80000000U));
    TEST_ASSERT_EQUAL_UINT32(0x80000000U, proof_unsigned(INT32_MIN));
}

static void check_long_word(uint64_t word)
{
    TEST_ASSERT_EQUAL_INT64(fx_signed64(word), proof_signed64(word));
    TEST_ASSERT_EQUAL_UINT64(word, proof_unsigned64(fx_signed64(word)));
    TEST_ASSERT_EQUAL_UINT64(word, fx_unsigned64(fx_signed64(word)));
}

TEST(test_long_words_are_read_as_the_proof_reads_them)
{
    uint64_t seed = 1U;

    for (uint32_t k = 0U; k < 1000000U; k++) {
        seed = (seed * 6364136223846793005U) + 1442695040888963407U;
        check_long_word(seed);
    }
    for (uint32_t bit = 0U; bit < 64U; bit++) {
        for (uint64_t off = 0U; off < 4U; off++) {
            check_long_word((1ULL << bit) + off);
            check_long_word((1ULL << bit) - off);
        }
    }
    TEST_ASSERT_EQUAL_INT64(INT64_MIN, proof_signed64(0x8000000000000000U));
    TEST_ASSERT_EQUAL_INT64(-1, proof_signed64(UINT64_MAX));
}

TEST(test_zeros_are_counted_as_the_proof_counts_them)
{
    for (uint64_t x = 1U; x <= UINT32_MAX; x += STEP * 1001U) {
        TEST_ASSERT_EQUAL_UINT32(fx_leading_zeros((uint32_t)x), proof_leading_zeros((uint32_t)x));
    }
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        TEST_ASSERT_EQUAL_UINT32(31U - bit, proof_leading_zeros(1U << bit));
    }
}

TEST(test_products_and_low_pass_are_those_of_the_proof)
{
    uint32_t seed = 1U;

    for (uint32_t k = 0U; k < 1000000U; k++) {
        int32_t a;
        int32_t b;
        uint32_t shift;

        seed = (seed * 1664525U) + 1013904223U;
        a = fx_signed(seed);
        seed = (seed * 1664525U) + 1013904223U;
        b = fx_asr(fx_signed(seed), 16U);
        shift = seed % 31U;
        TEST_ASSERT_EQUAL_INT32(fx_mla_32x16(b, a, b), proof_mla_32x16(b, a, b));
        TEST_ASSERT_EQUAL_INT32(fx_approach(fx_asr(a, 1U), b, shift),
                                proof_approach(fx_asr(a, 1U), b, shift));
    }
}

TEST(test_entries_of_a_ring_are_counted_as_the_proof_counts_them)
{
    static const recorder_entry_t ring[ENTRIES];

    for (uint32_t first = 0U; first < ENTRIES; first++) {
        for (uint32_t end = first; end < ENTRIES; end++) {
            TEST_ASSERT_EQUAL_UINT32(end - first, ring_entries_between(&ring[first], &ring[end]));
            TEST_ASSERT_EQUAL_UINT32(end - first, proof_entries_between(&ring[first], &ring[end]));
        }
    }
}

TEST(test_a_place_is_within_a_ring_where_the_proof_has_it_within)
{
    static const recorder_entry_t ring[ENTRIES];

    for (uint32_t at = 0U; at < ENTRIES; at++) {
        for (uint32_t stop = 0U; stop < ENTRIES; stop++) {
            for (uint32_t span = 0U; span <= ENTRIES; span++) {
                const bool due = (at <= stop) && ((stop - at) <= span);

                TEST_ASSERT_EQUAL(due, ring_is_within(&ring[at], &ring[stop], span));
                TEST_ASSERT_EQUAL(due, proof_is_within(&ring[at], &ring[stop], span));
            }
        }
        TEST_ASSERT_FALSE(ring_is_within(&ring[at], NULL, UINT16_MAX));
        TEST_ASSERT_FALSE(proof_is_within(&ring[at], NULL, UINT16_MAX));
    }
}
