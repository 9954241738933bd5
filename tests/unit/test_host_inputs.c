/* SPDX-License-Identifier: MIT */
/* Inputs and sensor of a simulated board, through hal.h. */
#include "hal_host.h"
#include "testing.h"

#define TICK_PS (62500000U) /* 16 kHz: 625 units of a pulse's time */
#define UNITS_OF_A_TICK (625U)
#define PS_OF_A_UNIT (100000U)

static hal_t hal;
static hal_host_inputs_t inputs;

void setUp(void)
{
    hal_host_init(&hal, NULL);
    hal_host_inputs_init(&inputs, TICK_PS);
    hal.inputs = &inputs;
}

static void pass(uint32_t ticks)
{
    for (uint32_t k = 0U; k < ticks; k++) {
        hal_host_step(&hal);
    }
}

static void send_pulse(uint32_t start, uint32_t width)
{
    const hal_pulse_t pulse = {start, width};

    hal_host_inputs_send(&inputs, &pulse);
}

static void gives(uint32_t start, uint32_t width)
{
    hal_pulse_t pulse = {0U, 0U};

    TEST_ASSERT_TRUE(hal_pulse(&hal, &pulse));
    TEST_ASSERT_EQUAL_UINT32(start, pulse.start);
    TEST_ASSERT_EQUAL_UINT32(width, pulse.width);
}

static void gives_none(void)
{
    hal_pulse_t pulse = {7U, 8U};

    TEST_ASSERT_FALSE(hal_pulse(&hal, &pulse));
    TEST_ASSERT_EQUAL_UINT32(7U, pulse.start);
    TEST_ASSERT_EQUAL_UINT32(8U, pulse.width);
}

TEST(test_a_board_without_inputs_says_so)
{
    hal.inputs = NULL;
    pass(1U);
    gives_none();
    TEST_ASSERT_EQUAL_UINT32(0U, hal_pulse_now(&hal));
    TEST_ASSERT_EQUAL_UINT16(HAL_NO_THROTTLE, hal_inputs(&hal).throttle);
    TEST_ASSERT_FALSE(hal_inputs(&hal).button);
    TEST_ASSERT_EQUAL_UINT16(0U, hal_shaft(&hal).reading);
    TEST_ASSERT_FALSE(hal_shaft(&hal).indexed);
}

TEST(test_inputs_that_nobody_sets_are_none)
{
    gives_none();
    TEST_ASSERT_EQUAL_UINT16(HAL_NO_THROTTLE, hal_inputs(&hal).throttle);
    TEST_ASSERT_FALSE(hal_inputs(&hal).button);
}

TEST(test_the_time_of_pulses_follows_the_ticks)
{
    pass(3U);
    TEST_ASSERT_EQUAL_UINT32(3U * UNITS_OF_A_TICK, hal_pulse_now(&hal));
}

TEST(test_a_tick_that_is_no_whole_number_of_units_loses_no_time)
{
    hal_host_inputs_init(&inputs, PS_OF_A_UNIT + (PS_OF_A_UNIT / 4U));
    pass(4U);
    TEST_ASSERT_EQUAL_UINT32(5U, hal_pulse_now(&hal));
}

TEST(test_a_pulse_is_seen_once_it_has_ended)
{
    send_pulse(UNITS_OF_A_TICK, UNITS_OF_A_TICK);
    pass(1U);
    gives_none();
    pass(1U);
    gives(UNITS_OF_A_TICK, UNITS_OF_A_TICK);
    gives_none();
}

TEST(test_pulses_come_in_the_order_in_which_they_were_sent)
{
    pass(1U);
    send_pulse(1U, 10U);
    send_pulse(20U, 5U);
    gives(1U, 10U);
    gives(20U, 5U);
}

TEST(test_a_pulse_over_the_wrap_of_the_time_is_seen_once_it_has_ended)
{
    inputs.passed_ps = (uint64_t)0xFFFFFFF0U * PS_OF_A_UNIT;
    send_pulse(0xFFFFFFF8U, 16U);
    gives_none();
    pass(1U);
    gives(0xFFFFFFF8U, 16U);
}

TEST(test_a_full_queue_keeps_the_oldest_pulses)
{
    pass(1U);
    for (uint32_t k = 0U; k <= HAL_HOST_PULSES; k++) {
        send_pulse(2U * k, 1U);
    }
    for (uint32_t k = 0U; k < HAL_HOST_PULSES; k++) {
        gives(2U * k, 1U);
    }
    gives_none();
}

TEST(test_throttle_and_button_are_what_was_set)
{
    inputs.now = (hal_inputs_t){.throttle = 1234U, .button = true};
    TEST_ASSERT_EQUAL_UINT16(1234U, hal_inputs(&hal).throttle);
    TEST_ASSERT_TRUE(hal_inputs(&hal).button);
}

TEST(test_a_conversion_of_the_throttle_ends_in_each_tick)
{
    pass(300U);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)300U, hal_inputs(&hal).conversions);
}

TEST(test_an_index_pulse_is_told_once)
{
    hal_shaft_t shaft;

    inputs.shaft = (hal_shaft_t){.reading = 40000U, .index = 39990U, .indexed = true};
    shaft = hal_shaft(&hal);
    TEST_ASSERT_EQUAL_UINT16(40000U, shaft.reading);
    TEST_ASSERT_EQUAL_UINT16(39990U, shaft.index);
    TEST_ASSERT_TRUE(shaft.indexed);
    shaft = hal_shaft(&hal);
    TEST_ASSERT_EQUAL_UINT16(40000U, shaft.reading);
    TEST_ASSERT_FALSE(shaft.indexed);
}
