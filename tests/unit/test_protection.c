/* Protection: each fault exactly at its limit, the order of faults, what is recorded. */
#include "example_cfg.h"
#include "protection.h"
#include "unity.h"

#include <stddef.h>

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

static protection_cfg_t cfg;
static protection_in_t in;

void setUp(void)
{
    cfg = example_protection_cfg();
    in = (protection_in_t){.bus = 22572, .check_current = true, .check_undervoltage = true};
}

void tearDown(void)
{
}

static void test_nothing_wrong_is_no_fault(void)
{
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
}

static void test_overcurrent_begins_one_above_the_limit_in_each_phase_and_direction(void)
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
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
    }
    for (size_t i = 0; i < COUNT(above); i++) {
        in.phase_a = above[i][0];
        in.phase_b = above[i][1];
        TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, protection_check(&cfg, &in));
    }
}

static void test_a_saturated_current_sample_always_exceeds_the_largest_limit(void)
{
    cfg.current_max = 16382; /* the largest that the configuration allows */
    in.phase_a = -16383;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, protection_check(&cfg, &in));
}

static void test_overcurrent_is_ignored_while_the_sensors_are_not_calibrated(void)
{
    in.phase_a = 16383;
    in.check_current = false;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
}

static void test_overvoltage_begins_one_above_the_limit(void)
{
    in.bus = cfg.bus_max;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
    in.bus = cfg.bus_max + 1;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, protection_check(&cfg, &in));
}

static void test_undervoltage_begins_one_below_the_limit_and_only_when_watched(void)
{
    in.bus = cfg.bus_min;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
    in.bus = cfg.bus_min - 1;
    TEST_ASSERT_EQUAL_INT(FAULT_UNDERVOLTAGE, protection_check(&cfg, &in));
    in.check_undervoltage = false;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check(&cfg, &in));
}

static void test_faults_are_found_in_the_order_of_their_numbers(void)
{
    in.break_input = true;
    in.phase_a = 16383;
    in.bus = cfg.bus_max + 1;
    TEST_ASSERT_EQUAL_INT(FAULT_BREAK, protection_check(&cfg, &in));
    in.break_input = false;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, protection_check(&cfg, &in));
    in.phase_a = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERVOLTAGE, protection_check(&cfg, &in));
    in.phase_a = 16383;
    in.bus = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_OVERCURRENT, protection_check(&cfg, &in));
    in.phase_a = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_UNDERVOLTAGE, protection_check(&cfg, &in));
    TEST_ASSERT_TRUE((FAULT_BREAK < FAULT_OVERCURRENT) && (FAULT_OVERCURRENT < FAULT_OVERVOLTAGE) &&
                     (FAULT_OVERVOLTAGE < FAULT_UNDERVOLTAGE));
}

static void assert_record(fault_id_t id, int32_t value, int32_t limit)
{
    const fault_t fault = protection_record(&cfg, &in, id);

    TEST_ASSERT_EQUAL_INT(id, fault.id);
    TEST_ASSERT_EQUAL_INT32(value, fault.value);
    TEST_ASSERT_EQUAL_INT32(limit, fault.limit);
}

static void test_record_holds_the_measured_value_and_its_limit(void)
{
    in.phase_a = -9000;
    in.phase_b = -8000;
    in.bus = 12345;
    assert_record(FAULT_BREAK, 17000, cfg.current_max);
    assert_record(FAULT_OVERCURRENT, 17000, cfg.current_max);
    assert_record(FAULT_OVERVOLTAGE, 12345, cfg.bus_max);
    assert_record(FAULT_UNDERVOLTAGE, 12345, cfg.bus_min);
}

static void test_offset_fault_begins_one_above_the_limit_for_either_sensor_and_sign(void)
{
    const int32_t max = cfg.offset_max;
    const int32_t above[][2] = {{max + 1, 0}, {-max - 1, 0}, {0, max + 1}, {0, -max - 1}};

    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, max, -max).id);
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, -max, max).id);
    for (size_t i = 0; i < COUNT(above); i++) {
        const fault_t fault = protection_check_offset(&cfg, above[i][0], above[i][1]);

        TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET, fault.id);
        TEST_ASSERT_EQUAL_INT32(max + 1, fault.value);
        TEST_ASSERT_EQUAL_INT32(max, fault.limit);
    }
}

static void test_offset_limit_of_zero_accepts_only_a_perfect_sensor(void)
{
    cfg.offset_max = 0;
    TEST_ASSERT_EQUAL_INT(FAULT_NONE, protection_check_offset(&cfg, 0, 0).id);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_OFFSET, protection_check_offset(&cfg, 0, 1).id);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_nothing_wrong_is_no_fault);
    RUN_TEST(test_overcurrent_begins_one_above_the_limit_in_each_phase_and_direction);
    RUN_TEST(test_a_saturated_current_sample_always_exceeds_the_largest_limit);
    RUN_TEST(test_overcurrent_is_ignored_while_the_sensors_are_not_calibrated);
    RUN_TEST(test_overvoltage_begins_one_above_the_limit);
    RUN_TEST(test_undervoltage_begins_one_below_the_limit_and_only_when_watched);
    RUN_TEST(test_faults_are_found_in_the_order_of_their_numbers);
    RUN_TEST(test_record_holds_the_measured_value_and_its_limit);
    RUN_TEST(test_offset_fault_begins_one_above_the_limit_for_either_sensor_and_sign);
    RUN_TEST(test_offset_limit_of_zero_accepts_only_a_perfect_sensor);
    return UNITY_END();
}
