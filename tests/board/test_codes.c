/* SPDX-License-Identifier: MIT */
/*
 * Dead time and sampling time as register codes: never shorter than asked for, and no longer than
 * they have to be.
 */
#include "codes.h"

#include "testing.h"

#define DEAD_TIME_MAX 1008U /* ticks */
#define SAMPLING_MAX 1100U  /* ns: board.c */
#define ADC_CLOCK_MHZ 42.5

/* RM0440 28.6.20, DTG. */
static uint32_t ticks_of(uint32_t code)
{
    if (code < 0x80U) {
        return code;
    }
    if (code < 0xC0U) {
        return (64U + (code & 0x3FU)) * 2U;
    }
    return (32U + (code & 0x1FU)) * ((code < 0xE0U) ? 8U : 16U);
}

static uint32_t shortest_of_at_least(uint32_t ticks)
{
    uint32_t shortest = UINT32_MAX;

    for (uint32_t code = 0U; code <= 0xFFU; code++) {
        const uint32_t made = ticks_of(code);
        shortest = (made >= ticks && made < shortest) ? made : shortest;
    }
    return shortest;
}

TEST(test_a_dead_time_is_the_shortest_that_is_long_enough)
{
    for (uint32_t ticks = 0U; ticks <= DEAD_TIME_MAX; ticks++) {
        const uint32_t code = codes_dead_time(ticks);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(0xFFU, code);
        TEST_ASSERT_EQUAL_UINT32(shortest_of_at_least(ticks), ticks_of(code));
    }
}

/* RM0440 21.7.6, SMP. */
static double sampling_ns(uint32_t code)
{
    static const double cycles[] = {2.5, 6.5, 12.5, 24.5, 47.5};

    return cycles[code] / ADC_CLOCK_MHZ * 1000.0;
}

TEST(test_a_sampling_time_is_the_shortest_that_is_long_enough)
{
    for (uint32_t ns = 0U; ns <= SAMPLING_MAX; ns++) {
        const uint32_t code = codes_sampling(ns);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(CODES_SAMPLING_MAX, code);
        TEST_ASSERT_TRUE(sampling_ns(code) >= (double)ns);
        TEST_ASSERT_TRUE(code == 0U || sampling_ns(code - 1U) < (double)ns);
    }
}

TEST(test_no_sampling_time_is_longer_than_that_of_the_bus)
{
    TEST_ASSERT_EQUAL_UINT32(CODES_SAMPLING_MAX, codes_sampling(SAMPLING_MAX + 1U));
    TEST_ASSERT_EQUAL_UINT32(CODES_SAMPLING_MAX, codes_sampling(100000U));
}
