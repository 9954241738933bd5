/* SPDX-License-Identifier: MIT */
/* Fixed-point primitives: exact results, saturation on both sides, direction of rounding. */
#include "exact.h"
#include "fx.h"
#include "seeded.h"
#include "testing.h"

#include <stddef.h>
#include <stdint.h>

#define SEEDED_CASES (200000)
#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static int32_t saturate32(int64_t x)
{
    return (int32_t)clamp64(x, INT32_MIN, INT32_MAX);
}

TEST(test_shift_rounds_towards_minus_infinity)
{
    TEST_ASSERT_EQUAL_INT32(-2, fx_asr(-3, 1U));
    TEST_ASSERT_EQUAL_INT32(1, fx_asr(3, 1U));
    TEST_ASSERT_EQUAL_INT32(-1, fx_asr(-1, 31U));
    TEST_ASSERT_EQUAL_INT32(0, fx_asr(INT32_MAX, 31U));
    TEST_ASSERT_EQUAL_INT32(-1, fx_asr(INT32_MIN, 31U));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, fx_asr(INT32_MIN, 0U));
}

TEST(test_shift_equals_floor_division_for_every_shift)
{
    seeded_t seed = {0x2545F491U};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const int32_t x = seeded_i32(&seed);
        const uint32_t n = (uint32_t)i % 32U;

        TEST_ASSERT_EQUAL_INT64(floor_div_pow2(x, n), fx_asr(x, n));
    }
}

TEST(test_min_and_max_choose_in_both_orders_and_at_equality)
{
    TEST_ASSERT_EQUAL_INT32(-7, fx_min(-7, 7));
    TEST_ASSERT_EQUAL_INT32(-7, fx_min(7, -7));
    TEST_ASSERT_EQUAL_INT32(7, fx_max(-7, 7));
    TEST_ASSERT_EQUAL_INT32(7, fx_max(7, -7));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, fx_min(INT32_MIN, INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, fx_max(INT32_MIN, INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(5, fx_min(5, 5));
    TEST_ASSERT_EQUAL_INT32(5, fx_max(5, 5));
}

TEST(test_clamp_passes_the_inside_and_stops_at_both_ends)
{
    TEST_ASSERT_EQUAL_INT32(-10, fx_clamp(-11, -10, 20));
    TEST_ASSERT_EQUAL_INT32(-10, fx_clamp(-10, -10, 20));
    TEST_ASSERT_EQUAL_INT32(-9, fx_clamp(-9, -10, 20));
    TEST_ASSERT_EQUAL_INT32(20, fx_clamp(20, -10, 20));
    TEST_ASSERT_EQUAL_INT32(20, fx_clamp(21, -10, 20));
    TEST_ASSERT_EQUAL_INT32(-10, fx_clamp(INT32_MIN, -10, 20));
    TEST_ASSERT_EQUAL_INT32(20, fx_clamp(INT32_MAX, -10, 20));
    TEST_ASSERT_EQUAL_INT32(3, fx_clamp(-5, 3, 3));
}

TEST(test_towards_goes_by_one_step_and_stops_at_its_goal_from_both_sides)
{
    TEST_ASSERT_EQUAL_INT32(3, fx_towards(0, 10, 3));
    TEST_ASSERT_EQUAL_INT32(-3, fx_towards(0, -10, 3));
    TEST_ASSERT_EQUAL_INT32(10, fx_towards(8, 10, 3));
    TEST_ASSERT_EQUAL_INT32(10, fx_towards(12, 10, 3));
    TEST_ASSERT_EQUAL_INT32(10, fx_towards(10, 10, 3));
    TEST_ASSERT_EQUAL_INT32(7, fx_towards(7, 10, 0));
}

TEST(test_approach_goes_by_the_share_of_the_distance_rounded_down)
{
    /* 1000 + (5000 − 1000)/8, and back; 7/8 and −7/8 rounded down. */
    TEST_ASSERT_EQUAL_INT32(1500, fx_approach(1000, 5000, 3U));
    TEST_ASSERT_EQUAL_INT32(4500, fx_approach(5000, 1000, 3U));
    TEST_ASSERT_EQUAL_INT32(100, fx_approach(100, 107, 3U));
    TEST_ASSERT_EQUAL_INT32(99, fx_approach(100, 93, 3U));
    TEST_ASSERT_EQUAL_INT32(-300, fx_approach(-300, -300, 3U));
    TEST_ASSERT_EQUAL_INT32(-7, fx_approach(12, -7, 0U));
}

/* x and x ± 2^n stand for the same bits. */
TEST(test_bits_read_as_signed_and_unsigned_are_the_same_bits)
{
    static const uint32_t bits[] = {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU};
    static const int32_t numbers[] = {0, 1, INT32_MAX, INT32_MIN, -1};
    static const uint64_t wide_bits[] = {0U, 1U, INT64_MAX, 0x8000000000000000U, UINT64_MAX};
    static const int64_t wide_numbers[] = {0, 1, INT64_MAX, INT64_MIN, -1};

    for (uint32_t i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL_INT32(numbers[i], fx_signed(bits[i]));
        TEST_ASSERT_EQUAL_HEX32(bits[i], fx_unsigned(numbers[i]));
        TEST_ASSERT_EQUAL_INT64(wide_numbers[i], fx_signed64(wide_bits[i]));
        TEST_ASSERT_EQUAL_HEX64(wide_bits[i], fx_unsigned64(wide_numbers[i]));
    }
}

TEST(test_abs_of_the_whole_range_but_the_excluded_minimum)
{
    TEST_ASSERT_EQUAL_INT32(0, fx_abs(0));
    TEST_ASSERT_EQUAL_INT32(1, fx_abs(-1));
    TEST_ASSERT_EQUAL_INT32(32768, fx_abs(INT16_MIN));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, fx_abs(INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, fx_abs(INT32_MIN + 1));
}

typedef struct {
    int32_t (*saturate)(int32_t x);
    int32_t lowest;
    int32_t highest;
} saturation_t;

static const saturation_t SATURATIONS[] = {
    {fx_sat14, -8192, 8191},
    {fx_sat15, -16384, 16383},
    {fx_sat16, -32768, 32767},
    {fx_sat27, -67108864, 67108863},
    {fx_sat28, -134217728, 134217727},
    {fx_sat30, -536870912, 536870911},
    {fx_usat15, 0, 32767},
};

TEST(test_saturation_passes_the_inside_up_to_both_ends)
{
    for (size_t i = 0; i < COUNT(SATURATIONS); i++) {
        const saturation_t *const s = &SATURATIONS[i];

        TEST_ASSERT_EQUAL_INT32(0, s->saturate(0));
        TEST_ASSERT_EQUAL_INT32(1, s->saturate(1));
        TEST_ASSERT_EQUAL_INT32((s->lowest < 0) ? -1 : 0, s->saturate(-1));
        TEST_ASSERT_EQUAL_INT32(s->highest - 1, s->saturate(s->highest - 1));
        TEST_ASSERT_EQUAL_INT32(s->highest, s->saturate(s->highest));
        TEST_ASSERT_EQUAL_INT32(s->lowest + 1, s->saturate(s->lowest + 1));
        TEST_ASSERT_EQUAL_INT32(s->lowest, s->saturate(s->lowest));
    }
}

TEST(test_saturation_begins_one_beyond_the_ends_and_holds_to_the_extremes)
{
    for (size_t i = 0; i < COUNT(SATURATIONS); i++) {
        const saturation_t *const s = &SATURATIONS[i];

        for (uint32_t bit = 0U; bit < 31U; bit++) {
            /* 1, 2, 4, … beyond each end, as far as they are numbers of 32 bits. */
            const int32_t above = saturate32((int64_t)s->highest + ((int64_t)1 << bit));
            const int32_t below = saturate32((int64_t)s->lowest - ((int64_t)1 << bit));

            TEST_ASSERT_EQUAL_INT32(s->highest, s->saturate(above));
            TEST_ASSERT_EQUAL_INT32(s->lowest, s->saturate(below));
        }
        TEST_ASSERT_EQUAL_INT32(s->highest, s->saturate(INT32_MAX));
        TEST_ASSERT_EQUAL_INT32(s->highest, s->saturate(INT32_MAX - 1));
        TEST_ASSERT_EQUAL_INT32(s->lowest, s->saturate(INT32_MIN));
        TEST_ASSERT_EQUAL_INT32(s->lowest, s->saturate(INT32_MIN + 1));
    }
}

TEST(test_saturation_is_the_clamp_to_its_ends_for_seeded_values_of_any_size)
{
    seeded_t seed = {0x5A7B17E5U};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const int32_t x = (int32_t)floor_div_pow2(seeded_i32(&seed), (uint32_t)i % 32U);

        for (size_t k = 0; k < COUNT(SATURATIONS); k++) {
            const saturation_t *const s = &SATURATIONS[k];
            const int32_t not_above = (x > s->highest) ? s->highest : x;

            TEST_ASSERT_EQUAL_INT32((not_above < s->lowest) ? s->lowest : not_above,
                                    s->saturate(x));
        }
    }
}

/* Around every edge of 32 and of 16 bits. */
static const int32_t EDGES[] = {
    INT32_MIN, INT32_MIN + 1, -65537, -65536, -65535, -32769, -32768, -32767,        -1,        0,
    1,         32767,         32768,  32769,  65535,  65536,  65537,  INT32_MAX - 1, INT32_MAX,
};

TEST(test_mul_32x16_is_the_floored_64_bit_product_on_all_edges)
{
    static const int32_t factors[] = {-32768, -32767, -2, -1, 0, 1, 2, 32766, 32767};

    for (size_t i = 0; i < COUNT(EDGES); i++) {
        for (size_t j = 0; j < COUNT(factors); j++) {
            const int64_t exact = floor_div_pow2((int64_t)EDGES[i] * factors[j], 16U);

            TEST_ASSERT_EQUAL_INT64(exact, fx_mul_32x16(EDGES[i], factors[j]));
        }
    }
}

TEST(test_mul_32x16_is_the_floored_64_bit_product_on_seeded_pairs)
{
    seeded_t seed = {0xCC9E2D51U};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const int32_t a = seeded_i32(&seed);
        const int32_t b = seeded_i16(&seed);

        TEST_ASSERT_EQUAL_INT64(floor_div_pow2((int64_t)a * b, 16U), fx_mul_32x16(a, b));
    }
}

/* The sums that leave room for the product, from one end of 32 bits to the other, and between. */
static void assert_sum_of_product(int32_t a, int32_t b, seeded_t *seed)
{
    const int64_t product = floor_div_pow2((int64_t)a * b, 16U);
    const int32_t lowest = saturate32(INT32_MIN - product);
    const int32_t highest = saturate32(INT32_MAX - product);
    const int32_t sums[] = {lowest, highest, 0, seeded_in(seed, lowest, highest)};

    for (size_t i = 0; i < COUNT(sums); i++) {
        TEST_ASSERT_EQUAL_INT64(sums[i] + product, fx_mla_32x16(sums[i], a, b));
    }
}

TEST(test_sum_of_product_is_exact_on_all_edges_as_long_as_it_fits)
{
    static const int32_t factors[] = {-32768, -32767, -2, -1, 0, 1, 2, 32766, 32767};
    seeded_t seed = {0x27D4EB2FU};

    for (size_t i = 0; i < COUNT(EDGES); i++) {
        for (size_t j = 0; j < COUNT(factors); j++) {
            assert_sum_of_product(EDGES[i], factors[j], &seed);
        }
    }
}

TEST(test_sum_of_product_is_exact_for_seeded_operands)
{
    seeded_t seed = {0x165667B1U};

    for (int32_t i = 0; i < SEEDED_CASES; i++) {
        const int32_t a = seeded_i32(&seed);

        assert_sum_of_product(a, seeded_i16(&seed), &seed);
    }
}

TEST(test_leading_zeros_are_those_above_the_highest_one)
{
    for (uint32_t bit = 0U; bit < 32U; bit++) {
        const uint32_t one = (uint32_t)1U << bit;

        TEST_ASSERT_EQUAL_UINT32(31U - bit, fx_leading_zeros(one));
        TEST_ASSERT_EQUAL_UINT32(31U - bit, fx_leading_zeros(one | (one - 1U)));
        if (bit > 0U) {
            TEST_ASSERT_EQUAL_UINT32(31U - bit, fx_leading_zeros(one + 1U));
            TEST_ASSERT_EQUAL_UINT32(32U - bit, fx_leading_zeros(one - 1U));
        }
    }
}

TEST(test_leading_zeros_do_not_depend_on_the_bits_below_the_highest_one)
{
    seeded_t seed = {0x85EBCA77U};

    for (uint32_t i = 0U; i < (uint32_t)SEEDED_CASES; i++) {
        const uint32_t zeros = i % 32U;
        const uint32_t x = (seeded_u32(&seed) | 0x80000000U) >> zeros;

        TEST_ASSERT_EQUAL_UINT32(zeros, fx_leading_zeros(x));
    }
}
