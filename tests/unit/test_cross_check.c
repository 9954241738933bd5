/* SPDX-License-Identifier: MIT */
/* What the background checks, and how a fault of it comes into the drive. */
#include "cross_check.h"
#include "example_app.h"

void setUp(void)
{
    power_on();
}

/* Ticks, each with a pass of the background. */
static void pass(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        tick(1U);
        cross_check_step(&app);
    }
}

static uint32_t window(void)
{
    return (cfg.slow_ticks * SUPERVISION_STEPS) << cfg.supervision.mean_shift;
}

/* As if the current were controlled, for the ticks of a window: nothing else acts. */
static void pass_controlled(uint32_t count)
{
    for (uint32_t k = 0U; k < count; k++) {
        app.drive.state = DRIVE_STATE_RUN;
        app.drive.tick++;
        cross_check_step(&app);
    }
}

TEST(test_a_sum_beside_zero_is_told_within_two_windows_and_the_drive_latches_it)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    pass_controlled(2U * window());
    TEST_ASSERT_TRUE(app.fails);
    app.drive.state = DRIVE_STATE_READY;
    tick_period();
    TEST_ASSERT_EQUAL_INT(DRIVE_STATE_FAULT, app.drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, app.drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(800, app.drive.fault.value); /* 100 counts of 12 bits */
    TEST_ASSERT_TRUE(app.drive.fault.limit < 800);
    cross_check_step(&app);
    TEST_ASSERT_FALSE(app.fails);
}

TEST(test_what_is_off_from_the_calibration_on_is_a_zero_and_no_fault)
{
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    pass(EXAMPLE_CALIBRATION_TICKS);
    pass_controlled(3U * window());
    TEST_ASSERT_FALSE(app.fails);
}

TEST(test_no_current_is_judged_at_rest_nor_at_an_end_of_a_converter)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    pass(3U * window());
    TEST_ASSERT_FALSE(app.fails);
    hardware.health.adc_ic = 4095U;
    pass_controlled(3U * window());
    TEST_ASSERT_FALSE(app.fails);
}

TEST(test_many_passes_within_a_tick_are_one_sample)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    for (uint32_t k = 0U; k < (4U * window()); k++) {
        app.drive.state = DRIVE_STATE_RUN;
        cross_check_step(&app);
    }
    TEST_ASSERT_TRUE(app.check.sum.samples <= 1U);
    TEST_ASSERT_FALSE(app.fails);
}

TEST(test_a_new_calibration_measures_the_zero_of_the_sum_anew)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    app.drive.state = DRIVE_STATE_INIT;
    pass(EXAMPLE_CALIBRATION_TICKS);
    pass_controlled(3U * window());
    TEST_ASSERT_FALSE(app.fails);
}

/* ---- one sample ---- */

TEST(test_a_sample_has_the_sum_of_the_three_counts_and_the_currents_of_the_drive)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    app.in.adc_ia = (uint16_t)(EXAMPLE_MIDDLE + 10U);
    app.in.adc_ib = (uint16_t)(EXAMPLE_MIDDLE + 20U);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 30U);
    app.drive.sensors.offset_a += 80 - 100; /* 10 counts are 80 LSB */
    app.drive.sensors.offset_b += 160 + 300;
    pass_controlled(1U);
    TEST_ASSERT_EQUAL_UINT32(1U, app.check.sum.samples);
    TEST_ASSERT_EQUAL_UINT32(8U * 60U, app.check.sum.sum);
    TEST_ASSERT_EQUAL_UINT32(100U + 300U + 680U, app.check.sum.flowing);
}

/* 8 Q15 of I_b to a count. */
TEST(test_the_zero_is_the_mean_of_the_whole_calibration_from_mid_scale)
{
    measured.adc_ia = (uint16_t)(EXAMPLE_MIDDLE + 1U);
    measured.adc_ib = (uint16_t)(EXAMPLE_MIDDLE - 3U);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE - 5U);
    pass(EXAMPLE_CALIBRATION_TICKS);
    TEST_ASSERT_INT32_WITHIN(2, 256, app.check.sum.zeros);
    TEST_ASSERT_EQUAL_INT32(8 * -7 * app.check.sum.zeros, app.check.sum.zero_sum);
}

TEST(test_a_calibration_behind_a_fault_forgets_the_zero_of_before)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
    app.drive.state = DRIVE_STATE_OFFSET_CAL;
    app.drive.tick++;
    cross_check_step(&app);
    TEST_ASSERT_EQUAL_INT32(1, app.check.sum.zeros);
    TEST_ASSERT_EQUAL_INT32(800, app.check.sum.zero_sum);
}

TEST(test_a_drive_that_begins_anew_has_no_zero)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    app.drive.state = DRIVE_STATE_INIT;
    app.drive.tick++;
    cross_check_step(&app);
    TEST_ASSERT_EQUAL_INT32(0, app.check.sum.zeros);
}

TEST(test_any_converter_at_an_end_begins_the_window_anew)
{
    uint16_t *const counts[] = {&app.in.adc_ia, &app.in.adc_ib, &hardware.health.adc_ic};

    pass(EXAMPLE_CALIBRATION_TICKS);
    for (uint32_t k = 0U; k < (sizeof counts / sizeof counts[0]); k++) {
        pass_controlled(3U);
        TEST_ASSERT_EQUAL_UINT32(3U, app.check.sum.samples);
        *counts[k] = 4095U;
        pass_controlled(1U);
        TEST_ASSERT_EQUAL_UINT32(0U, app.check.sum.samples);
        *counts[k] = EXAMPLE_MIDDLE;
    }
}

TEST(test_a_tick_that_comes_meanwhile_makes_no_sample)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    pass_controlled(2U);
    app.drive.tick++;
    interrupted = true;
    cross_check_step(&app);
    interrupted = false;
    TEST_ASSERT_EQUAL_UINT32(2U, app.check.sum.samples);
}

/* ---- a window ---- */

static void be_off(void)
{
    pass(EXAMPLE_CALIBRATION_TICKS);
    hardware.health.adc_ic = (uint16_t)(EXAMPLE_MIDDLE + 100U);
}

TEST(test_a_window_ends_so_many_ticks_after_its_first_sample)
{
    be_off();
    pass_controlled(window());
    TEST_ASSERT_FALSE(app.fails);
    pass_controlled(1U);
    TEST_ASSERT_TRUE(app.fails);
}

TEST(test_a_window_that_was_broken_off_begins_with_the_next_sample)
{
    be_off();
    pass_controlled(window() / 2U);
    app.in.adc_ia = 4095U;
    pass_controlled(1U);
    app.in.adc_ia = EXAMPLE_MIDDLE;
    pass_controlled(window());
    TEST_ASSERT_FALSE(app.fails);
    pass_controlled(1U);
    TEST_ASSERT_TRUE(app.fails);
}

/*
 * A background that comes by eight times in a window: 9 samples are no mean, the 17 of two windows
 * are one.
 */
TEST(test_a_window_with_few_samples_is_judged_with_the_next_one)
{
    be_off();
    for (uint32_t k = 0U; k <= 16U; k++) {
        TEST_ASSERT_FALSE(app.fails);
        app.drive.state = DRIVE_STATE_RUN;
        app.drive.tick += window() / 8U;
        cross_check_step(&app);
    }
    TEST_ASSERT_TRUE(app.fails);
}

/* ---- what becomes of a fault ---- */

/* In place of the user's command, which is as it was afterwards. */
TEST(test_a_fault_of_the_background_leaves_the_command_in_the_mailbox)
{
    const drive_command_t command = {.target = 7, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};
    const fault_t fault = {.id = FAULT_CURRENT_SUM, .value = 70000, .limit = -1};

    pass(EXAMPLE_CALIBRATION_TICKS);
    command_mailbox_post(&app.mailbox, &command);
    app_fail(&app, &fault);
    tick_period();
    TEST_ASSERT_EQUAL_UINT8(DRIVE_REQUEST_FAIL, app.in.command.request);
    TEST_ASSERT_EQUAL_INT(FAULT_CURRENT_SUM, app.drive.fault.id);
    TEST_ASSERT_EQUAL_INT32(65535, app.drive.fault.value);
    TEST_ASSERT_EQUAL_INT32(0, app.drive.fault.limit);
    cross_check_step(&app);
    tick_period();
    TEST_ASSERT_EQUAL_INT32(7, app.in.command.target);
    TEST_ASSERT_EQUAL_UINT8(0U, app.in.command.request);
}

TEST(test_a_number_that_is_no_fault_is_none)
{
    const int ids[] = {(int)FAULT_NONE, (int)FAULT_COUNT, 255};

    for (uint32_t k = 0U; k < (sizeof ids / sizeof ids[0]); k++) {
        const fault_t fault = {.id = (fault_id_t)ids[k], .value = 1, .limit = 1};

        power_on();
        pass(EXAMPLE_CALIBRATION_TICKS);
        app_fail(&app, &fault);
        tick_period();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
    }
}

/* The words of a failure that is told. */
static void flip_failure(uint32_t bit)
{
    uint8_t *const bytes = (uint8_t *)&app.failure;

    bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
}

static void flip_fails(void)
{
    app.fails = !app.fails;
}

/* A slow period and a pass later. */
static void assert_nothing_is_driven(void)
{
    pass(cfg.slow_ticks);
    TEST_ASSERT_FALSE(app.out.gate_enable);
    TEST_ASSERT_TRUE((app.drive.state == DRIVE_STATE_READY) ||
                     (app.drive.state == DRIVE_STATE_FAULT));
}

TEST(test_a_flipped_bit_tells_nothing_and_the_command_stays_in_force)
{
    const drive_command_t command = {.target = 7, .mode = (uint8_t)DRIVE_MODE_SPEED, .request = 0U};
    const drive_command_t clear = {.request = DRIVE_REQUEST_CLEAR};
    const fault_t fault = {.id = FAULT_CURRENT_SUM, .value = 1, .limit = 1};

    for (uint32_t bit = 0U; bit <= (8U * sizeof(app.failure)); bit++) {
        power_on();
        pass(EXAMPLE_CALIBRATION_TICKS);
        app_fail(&app, &fault);
        pass(cfg.slow_ticks);
        command_mailbox_post(&app.mailbox, &clear); /* and nothing of it is left */
        pass(EXAMPLE_CALIBRATION_TICKS + cfg.slow_ticks);
        command_mailbox_post(&app.mailbox, &command);
        if (bit < (8U * sizeof(app.failure))) {
            flip_failure(bit);
        } else {
            flip_fails();
        }
        assert_nothing_is_driven();
        TEST_ASSERT_EQUAL_INT(DRIVE_STATE_READY, app.drive.state);
        TEST_ASSERT_EQUAL_INT32(7, app.in.command.target);
        TEST_ASSERT_FALSE(app.fails);
    }
}

TEST(test_a_flipped_bit_of_what_is_told_starts_no_motor)
{
    const fault_t fault = {.id = FAULT_CURRENT_SUM, .value = 300, .limit = 228};
    uint32_t latched = 0U;

    for (uint32_t bit = 0U; bit < (8U * sizeof(app.failure)); bit++) {
        power_on();
        pass(EXAMPLE_CALIBRATION_TICKS);
        app_fail(&app, &fault);
        flip_failure(bit);
        assert_nothing_is_driven();
        latched += (app.drive.state == DRIVE_STATE_FAULT) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(latched >= 32U); /* with other numbers, or another name */
}
