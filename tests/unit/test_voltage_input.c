/* SPDX-License-Identifier: MIT */
/* A potentiometer: its reading, its low-pass, and a wire that is open or shorted. */
#include "hal.h"
#include "testing.h"
#include "voltage_input.h"

#define SHIFT (3U) /* 12 bits */

static const input_cfg_t CFG = {.least = 328, .most = 32439, .filter_q15 = 328}; /* 1/100 */

static voltage_input_t voltage;
static input_signal_t signal;
static uint32_t tick;
static hal_inputs_t inputs;

void setUp(void)
{
    voltage = (voltage_input_t){0};
    inputs = (hal_inputs_t){0};
    input_signal_init(&signal, 0U);
    tick = 0U;
}

/* A pass without a conversion. */
static void look(void)
{
    voltage_input_take(&voltage, &inputs, SHIFT, &CFG, &signal, tick);
}

static void take_after(uint32_t count, uint32_t ticks)
{
    tick += ticks;
    inputs.throttle = (uint16_t)count;
    inputs.conversions++;
    look();
}

static void take(uint32_t count, uint32_t times)
{
    for (uint32_t k = 0U; k < times; k++) {
        take_after(count, 1U);
    }
}

TEST(test_the_first_counts_are_the_reading_without_delay)
{
    take(1000U, 8U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
    TEST_ASSERT_EQUAL_UINT32(8000U, input_signal_value(&signal));
}

/* After its time constant, 100 ticks, a step has come by 1 − 1/e = 63.4 % at 0.99^100. */
TEST(test_a_step_comes_with_the_time_constant)
{
    take(1000U, 8U);
    take(2000U, 100U);
    TEST_ASSERT_UINT32_WITHIN(60U, 8000U + 5072U, input_signal_value(&signal));
    take(2000U, 2000U);
    TEST_ASSERT_UINT32_WITHIN(8U, 16000U, input_signal_value(&signal));
}

/* A conversion that comes after several ticks takes over as much as they would, up to the whole. */
TEST(test_conversions_that_come_late_do_not_slow_it_down)
{
    take(1000U, 8U);
    take_after(2000U, 10U);
    TEST_ASSERT_INT32_WITHIN(3, 8000 + 800, voltage.smooth_q30 / 32768);
    take_after(2000U, UINT32_MAX);
    TEST_ASSERT_INT32_WITHIN(2, 16000, voltage.smooth_q30 / 32768);
}

TEST(test_a_conversion_is_one_reading_however_often_it_is_looked_at)
{
    for (uint32_t k = 1U; k < INPUT_SIGNAL_GOOD; k++) {
        take_after(1000U, 128U);
        for (uint32_t j = 0U; j < 200U; j++) {
            look();
        }
        TEST_ASSERT_EQUAL_UINT8(k, signal.good);
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SILENT, signal.lost);
    }
    take_after(1000U, 128U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
}

TEST(test_a_converter_that_stands_still_is_silent)
{
    take(1000U, 8U);
    for (uint32_t k = 0U; k < 101U; k++) {
        TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost);
        tick++;
        look();
        input_signal_step(&signal, tick, 100U);
    }
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_SILENT, signal.lost);
}

TEST(test_counts_at_the_ends_are_a_wire_and_change_no_reading)
{
    take(1000U, 8U);
    take(40U, 100U); /* 320 of 32768 */
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_LOW, signal.why);
    take(0U, 1U);
    take(4056U, 100U); /* 32448 */
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_HIGH, signal.why);
    TEST_ASSERT_EQUAL_UINT32(8000U, input_signal_value(&signal));
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NOT, signal.lost); /* until its time runs out */
    take(41U, 1U);
    TEST_ASSERT_EQUAL_UINT8(0U, signal.bad);
    take(4054U, 1U);
    TEST_ASSERT_EQUAL_UINT8(0U, signal.bad);
}

TEST(test_a_board_without_a_throttle_is_named)
{
    take(HAL_NO_THROTTLE, 20U);
    TEST_ASSERT_EQUAL_UINT8(INPUT_LOST_NO_PIN, signal.lost);
}
