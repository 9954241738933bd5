/* SPDX-License-Identifier: MIT */
/* Protection: each fault exactly at its limit, the order of faults, what is recorded. */
#include "example_cfg.h"
#include "protection.h"
#include "testing.h"

#include <stdbool.h>
#include <stddef.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static protection_cfg_t cfg;
static sample_t in;

static fault_id_t check(bool running)
{
    const protection_limits_t limits = protection_limits(&cfg, running);
    fault_t fault;

    return protection_check(&limits, &in, &fault);
}

#define RUNNING (true)
#define UNTOUCHED (77U) /* what a check without a fault leaves as it is */
#define AT_REST (false)

void setUp(void)
{
    cfg = example_protection_cfg();
    in = (sample_t){.bus = 22572};
}

TEST(test_nothing_wrong_is_no_fault)
{
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(RUNNING));
}

TEST(test_overcurrent_begins_one_above_the_limit_in_each_phase_and_direction)
{
    /* Phase c = −a − b takes the whole limit from two halves. */
    const int32_t max = cfg.current_max;
    const int32_t at_limit[][2] = {{max, 0},        {-max, 0},           {0, max},
                                   {0, -max},       {max / 2, max / 2},  {-max / 2, -max / 2},
                                   {max, -max / 2}, {-max / 2, max - 1}, {max, -max}};
    const int32_t above[][2] = {{max + 1, 0},
                                {-max - 1, 0},
                                {0, max + 1},
                                {0, -max - 1},
                                {(max / 2) + 1, max / 2},
                                {(-max / 2) - 1, -max / 2},
                                {max + 1, -max / 2}};

    for (size_t i = 0; i < COUNT(at_limit); i++) {
        in.phase_a = at_limit[i][0];
        in.phase_b = at_limit[i][1];
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(RUNNING));
    }
    for (size_t i = 0; i < COUNT(above); i++) {
        in.phase_a = above[i][0];
        in.phase_b = above[i][1];
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
    }
}

TEST(test_a_saturated_current_sample_always_exceeds_the_largest_limit)
{
    static const int32_t ends[] = {-16384, 16383};

    cfg.current_max = 16382; /* the largest that the configuration allows */
    for (size_t i = 0; i < COUNT(ends); i++) {
        in.phase_a = ends[i];
        in.phase_b = 0;
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
        in.phase_b = ends[i];
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
        in.phase_a = 0;
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
    }
}

TEST(test_currents_and_a_low_bus_are_not_watched_at_rest)
{
    static const int32_t currents[] = {-16384, 0, 16383};

    for (size_t i = 0; i < (COUNT(currents) * COUNT(currents)); i++) {
        in.phase_a = currents[i % COUNT(currents)];
        in.phase_b = currents[i / COUNT(currents)];
        in.bus = cfg.bus_max;
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(AT_REST));
        in.bus = 0;
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(AT_REST));
    }
}

TEST(test_too_high_a_bus_is_watched_at_rest_too)
{
    in.bus = cfg.bus_max + 1;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, check(AT_REST));
    in.bus = 32767;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, check(AT_REST));
}

TEST(test_smallest_current_limit_allows_one_and_no_more)
{
    cfg.current_max = 1;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        in.phase_a = sign;
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(RUNNING));
        in.phase_a = 2 * sign;
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
    }
}

TEST(test_overvoltage_begins_one_above_the_limit)
{
    in.bus = cfg.bus_max;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(RUNNING));
    in.bus = cfg.bus_max + 1;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, check(RUNNING));
}

TEST(test_undervoltage_begins_one_below_the_limit_and_only_while_running)
{
    in.bus = cfg.bus_min;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(RUNNING));
    in.bus = cfg.bus_min - 1;
    TEST_ASSERT_EQUAL_INT(FAULT_UNDERVOLTAGE, check(RUNNING));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, check(AT_REST));
}

TEST(test_faults_are_found_in_the_order_of_their_numbers)
{
    in.phase_a = 16383;
    in.bus = cfg.bus_max + 1;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
    in.phase_a = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, check(RUNNING));
    in.phase_a = 16383;
    in.bus = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, check(RUNNING));
    in.phase_a = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_UNDERVOLTAGE, check(RUNNING));
    TEST_ASSERT_TRUE((FAULT_BREAK < FAULT_OVERCURRENT) && (FAULT_OVERCURRENT < FAULT_OVERVOLTAGE) &&
                     (FAULT_OVERVOLTAGE < FAULT_UNDERVOLTAGE));
}

TEST(test_limits_hold_exactly_where_no_fault_is_found)
{
    static const int32_t currents[] = {-16384, -8193, -8192, -1, 0, 1, 8192, 8193, 16383};
    const int32_t buses[] = {0, cfg.bus_min - 1, cfg.bus_min, cfg.bus_max, cfg.bus_max + 1};
    const protection_limits_t limits = protection_limits(&cfg, RUNNING);
    fault_t fault;

    for (size_t k = 0U; k < (COUNT(currents) * COUNT(currents) * COUNT(buses)); k++) {
        in.phase_a = currents[k % COUNT(currents)];
        in.phase_b = currents[(k / COUNT(currents)) % COUNT(currents)];
        in.bus = buses[k / (COUNT(currents) * COUNT(currents))];
        TEST_ASSERT_EQUAL_INT(protection_check(&limits, &in, &fault) == FAULT_NONE,
                              protection_holds(&limits, in));
    }
}

static void assert_record(fault_id_t id, int32_t value, int32_t limit)
{
    const protection_limits_t limits = protection_limits(&cfg, RUNNING);
    fault_t fault = {.id = FAULT_NONE, .tick = UNTOUCHED};

    TEST_ASSERT_EQUAL_INT(id, protection_check(&limits, &in, &fault));
    TEST_ASSERT_EQUAL_INT(id, fault.id);
    TEST_ASSERT_EQUAL_INT32(value, fault.value);
    TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
}

TEST(test_record_holds_the_measured_value_and_its_limit)
{
    fault_t opened;

    in.phase_a = -9000;
    in.phase_b = -8000;
    opened = protection_break(&in);
    TEST_ASSERT_EQUAL_INT(FAULT_BREAK, opened.id);
    TEST_ASSERT_EQUAL_INT32(17000, opened.value);
    TEST_ASSERT_EQUAL_INT32(0, opened.limit);
    assert_record(FAULT_OVERCURRENT, 17000, cfg.current_max);
    in.phase_a = 0;
    in.phase_b = 0;
    in.bus = cfg.bus_max + 1;
    assert_record(FAULT_OVERVOLTAGE, cfg.bus_max + 1, cfg.bus_max);
    in.bus = cfg.bus_min - 1;
    assert_record(FAULT_UNDERVOLTAGE, cfg.bus_min - 1, cfg.bus_min);
}

TEST(test_record_of_an_overcurrent_holds_the_phase_that_carries_most)
{
    static const int32_t currents[][3] = {
        {-15000, 1000, 15000}, {1000, -15000, 15000}, {15000, -14000, 15000}, {8000, 7000, 15000}};

    for (size_t i = 0; i < COUNT(currents); i++) {
        in.phase_a = currents[i][0];
        in.phase_b = currents[i][1];
        assert_record(FAULT_OVERCURRENT, currents[i][2], cfg.current_max);
    }
}

TEST(test_offset_fault_begins_one_above_the_limit_for_either_sensor_and_sign)
{
    const int32_t max = cfg.offset_max;
    const int32_t above[][2] = {{max + 1, 0}, {-max - 1, 0}, {0, max + 1}, {0, -max - 1}};

    fault_t fault = {.tick = UNTOUCHED};

    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, max, -max, &fault));
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, -max, max, &fault));
    TEST_ASSERT_EQUAL_UINT32(UNTOUCHED, fault.tick);
    for (size_t i = 0; i < COUNT(above); i++) {
        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET,
                              protection_check_offset(&cfg, above[i][0], above[i][1], &fault));
        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET, fault.id);
        TEST_ASSERT_EQUAL_INT32(max + 1, fault.value);
        TEST_ASSERT_EQUAL_INT32(max, fault.limit);
    }
}

TEST(test_offset_limit_of_zero_accepts_only_a_perfect_sensor)
{
    fault_t fault;

    cfg.offset_max = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, 0, 0, &fault));
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET, protection_check_offset(&cfg, 0, 1, &fault));
}
